// SPDX-License-Identifier: MIT
#include "turnscale/geometry/similarity.h"

#include <random>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

using Points = std::vector<Eigen::Vector3d>;

class SimilarityTest : public testing::Test {
 protected:
  Eigen::Vector3d RandomVector(double size) {
    std::normal_distribution<double> normal(0, size);
    const double x = normal(random_);
    const double y = normal(random_);
    return {x, y, normal(random_)};
  }
  Points RandomPoints(int count) {
    Points points;
    for (int i = 0; i < count; ++i) points.push_back(RandomVector(50));
    return points;
  }

  std::mt19937 random_{11};
};

Points Map(const Similarity& target_from_source, const Points& source) {
  Points target;
  for (const Eigen::Vector3d& x : source) target.push_back(target_from_source * x);
  return target;
}

double SquaredDistance(const Points& a, const Points& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return sum;
}

TEST_F(SimilarityTest, RecoversRandomSimilarities) {
  for (const double scale : {0.05, 1.0, 21.0}) {
    const Similarity truth{scale, RotationFromVector(RandomVector(1)), RandomVector(100)};
    const Points source = RandomPoints(40);
    const Similarity found = AlignPoints(source, Map(truth, source), AlignmentModel::kSimilarity);
    EXPECT_NEAR(found.scale / truth.scale, 1, 1e-9);
    EXPECT_LT(RotationAngle(found.rotation.conjugate() * truth.rotation), 1e-9);
    EXPECT_LT((found.translation - truth.translation).norm(), 1e-9 * 100);
  }
}

TEST_F(SimilarityTest, RigidKeepsTheScaleAndNeverMirrors) {
  const Points source = RandomPoints(20);
  Points mirrored = source;
  for (Eigen::Vector3d& x : mirrored) x.x() = -x.x();
  const Similarity found = AlignPoints(source, mirrored, AlignmentModel::kRigid);
  EXPECT_NEAR(found.scale, 1, 1e-12);
  EXPECT_NEAR(found.rotation.toRotationMatrix().determinant(), 1, 1e-12);
}

TEST_F(SimilarityTest, NoNearbySimilarityFitsNoisyPointsBetter) {
  const Points source = RandomPoints(30);
  Points target = Map({1.3, RotationFromVector({0.1, 0.5, -0.3}), {4, 5, 6}}, source);
  for (Eigen::Vector3d& x : target) x += RandomVector(3);
  for (const AlignmentModel model : {AlignmentModel::kRigid, AlignmentModel::kSimilarity}) {
    const Similarity best = AlignPoints(source, target, model);
    const double least = SquaredDistance(Map(best, source), target);
    for (int i = 0; i < 50; ++i) {
      Similarity other = best;
      other.rotation = (RotationFromVector(RandomVector(1e-3)) * best.rotation).normalized();
      other.translation += RandomVector(1e-2);
      if (model == AlignmentModel::kSimilarity) other.scale *= 1 + RandomVector(1e-3).x();
      EXPECT_GT(SquaredDistance(Map(other, source), target), least);
    }
  }
}

TEST_F(SimilarityTest, RefusesWhatHasNoAnswer) {
  const Points source = RandomPoints(10);
  EXPECT_THROW(AlignPoints(source, RandomPoints(9), AlignmentModel::kRigid), InternalError);
  EXPECT_THROW(AlignPoints({}, {}, AlignmentModel::kRigid), InputError);
  EXPECT_THROW(AlignPoints(RandomPoints(2), RandomPoints(2), AlignmentModel::kRigid), InputError);
  Points line;
  for (int i = 0; i < 10; ++i) line.push_back(Eigen::Vector3d(1, 2, 3) + 0.7 * i * Eigen::Vector3d(0.3, 0.1, 0.9));
  EXPECT_THROW(AlignPoints(source, line, AlignmentModel::kSimilarity), InputError);
  EXPECT_THROW(AlignPoints(line, source, AlignmentModel::kSimilarity), InputError);
  EXPECT_THROW(AlignPoints(source, Points(10, {1, 2, 3}), AlignmentModel::kSimilarity), InputError);
}

}  // namespace
}  // namespace turnscale

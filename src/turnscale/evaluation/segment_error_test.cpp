// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/segment_error.h"

#include <array>
#include <random>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/evaluation/test_drive.h"

namespace turnscale {
namespace {

// The devkit's evaluation written out with 4x4 matrices and arc cosines, as the original has it.
std::array<double, 2> Devkit(const PosePairs& pairs) {
  const auto matrix = [](const RigidTransform& pose) {
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix();
    m.topRightCorner<3, 1>() = pose.translation;
    return m;
  };
  std::vector<Eigen::Matrix4d> truth;
  std::vector<Eigen::Matrix4d> result;
  std::vector<double> dist;
  for (const PosePair& pair : pairs) {
    truth.push_back(matrix(pair.truth));
    result.push_back(matrix(pair.estimate));
    const size_t n = truth.size();
    dist.push_back(n == 1 ? 0 : dist.back() + (truth[n - 1] - truth[n - 2]).topRightCorner<3, 1>().norm());
  }
  double t_sum = 0;
  double r_sum = 0;
  int count = 0;
  for (size_t first = 0; first < truth.size(); first += 10) {
    for (int hundreds = 1; hundreds <= 8; ++hundreds) {
      const double length = 100.0 * hundreds;
      size_t last = first;
      while (last < dist.size() && dist[last] <= dist[first] + length) ++last;
      if (last == dist.size()) continue;
      const Eigen::Matrix4d delta_truth = truth[first].inverse() * truth[last];
      const Eigen::Matrix4d delta_result = result[first].inverse() * result[last];
      const Eigen::Matrix4d error = delta_result.inverse() * delta_truth;
      const double cosine = 0.5 * (error.topLeftCorner<3, 3>().trace() - 1);
      r_sum += std::acos(std::max(-1.0, std::min(1.0, cosine))) / length;
      t_sum += error.topRightCorner<3, 1>().norm() / length;
      ++count;
    }
  }
  return {t_sum / count, r_sum / count};
}

Trajectory Drifting(int poses, double step) {
  const Trajectory truth = WindingDrive(poses, step);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.002);
  Trajectory drifting = truth;
  for (size_t i = 1; i < truth.size(); ++i) {
    RigidTransform motion = truth[i - 1].world_from_camera.inverse() * truth[i].world_from_camera;
    const double x = noise(random);
    const double y = noise(random);
    motion.rotation = motion.rotation * RotationFromVector({x, y, noise(random)});
    motion.translation *= 1.02 + noise(random);
    drifting[i].world_from_camera = drifting[i - 1].world_from_camera * motion;
  }
  return drifting;
}

std::vector<double> Lengths(const SegmentErrors& errors) {
  std::vector<double> lengths;
  for (const SegmentLengthError& error : errors.by_length) lengths.push_back(error.length);
  return lengths;
}

TEST(Segments, AgreeWithTheDevkit) {
  const PosePairs pairs = AssociateByTime(Drifting(1100, 1.03), WindingDrive(1100, 1.03));
  const auto [translation, rotation] = Devkit(pairs);
  const SegmentErrors errors = MeasureSegments(pairs);
  EXPECT_GT(translation, 0.01);
  EXPECT_NEAR(errors.translation, translation, 1e-10);
  EXPECT_NEAR(errors.rotation, rotation, 1e-10);
  EXPECT_EQ(Lengths(errors), (std::vector<double>{100, 200, 300, 400, 500, 600, 700, 800}));
}

TEST(Segments, TenPerCentOfScaleOnAStraightRoadIsTenPerCent) {
  Trajectory truth;
  for (int i = 0; i <= 400; ++i) truth.push_back({0.1 * i, {Eigen::Quaterniond::Identity(), {0, 0, 1.0 * i}}});
  // The segment ends at the first pose beyond its length, hence 101/100 and the like.
  const PosePairs pairs = AssociateByTime(Scaled(truth, 1.1), truth);
  const SegmentErrors errors = MeasureSegments(pairs);
  EXPECT_NEAR(errors.by_length[0].translation, 0.1 * 1.01, 1e-9);
  EXPECT_NEAR(errors.by_length[2].translation, 0.1 * 301 / 300, 1e-9);
  EXPECT_NEAR(errors.rotation, 0, 1e-12);
  EXPECT_NEAR(MeasureSegments(pairs, 1 / 1.1).translation, 0, 1e-12) << "the scale undoes it";
}

TEST(Segments, AConstantYawDriftIsItsRate) {
  const Trajectory truth = WindingDrive(400);
  Trajectory estimate = truth;
  for (size_t i = 0; i < truth.size(); ++i) {
    const RigidTransform drift{RotationFromVector({0, 1e-4 * static_cast<double>(i), 0}), Eigen::Vector3d::Zero()};
    estimate[i].world_from_camera = truth[i].world_from_camera * drift;
  }
  const SegmentErrors errors = MeasureSegments(AssociateByTime(estimate, truth));
  EXPECT_NEAR(errors.by_length.back().rotation, 1e-4, 3e-6);
}

TEST(Segments, DoNotDependOnTheWorldFrames) {
  const Trajectory truth = WindingDrive(300, 1.03);
  const Trajectory estimate = Drifting(300, 1.03);
  const RigidTransform elsewhere{RotationFromVector({1, 2, 0.5}), {7, 8, 9}};
  const double translation = MeasureSegments(AssociateByTime(estimate, truth)).translation;
  EXPECT_NEAR(MeasureSegments(AssociateByTime(Moved(estimate, elsewhere), truth)).translation, translation, 1e-10);
  EXPECT_NEAR(MeasureSegments(AssociateByTime(estimate, Moved(truth, elsewhere))).translation, translation, 1e-10);
}

TEST(Segments, LengthsFitTheDrive) {
  const auto lengths = [](int poses, double step) {
    const Trajectory drive = WindingDrive(poses, step);
    return Lengths(MeasureSegments(AssociateByTime(drive, drive)));
  };
  EXPECT_EQ(lengths(356, 1.0), (std::vector<double>{100, 200, 300}));
  EXPECT_EQ(lengths(92, 1.0), (std::vector<double>{10, 20, 30, 40, 50, 60, 70, 80}));
  EXPECT_EQ(lengths(29, 1.0), (std::vector<double>{10, 20}));
  EXPECT_EQ(lengths(45, 0.1), (std::vector<double>{1, 2, 3, 4}));
}

TEST(Segments, ADriveThatGoesNowhereIsNoYardstick) {
  const Trajectory one = WindingDrive(1);
  EXPECT_THROW(MeasureSegments(AssociateByTime(one, one)), InputError);
  const Trajectory still = WindingDrive(50, 0.0);
  EXPECT_THROW(MeasureSegments(AssociateByTime(still, still)), InputError);
  const Trajectory drive = WindingDrive(50);
  EXPECT_THROW(MeasureSegments(AssociateByTime(drive, drive), 1, {.lengths = {100}}), InputError);
}

}  // namespace
}  // namespace turnscale

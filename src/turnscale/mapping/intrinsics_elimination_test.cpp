// SPDX-License-Identifier: MIT
#include "turnscale/mapping/intrinsics_elimination.h"

#include <cstddef>
#include <limits>
#include <optional>
#include <random>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "turnscale/geometry/random_vector.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr int kDof = IntrinsicsRow::kPoseDof;
constexpr int kEntriesOfChange = IntrinsicsChange::kEntries;

// Cameras that move along a curve, and the rows of points ahead of them. Residuals and derivatives by the intrinsics
// are random; those by poses and points are a camera's, so that the unit of length is free.
class Elimination : public testing::Test {
 protected:
  Elimination() {
    for (int k = 0; k < 4; ++k) {
      const Eigen::Quaterniond rotation = RotationFromVector({0.01 * k, 0.1 * k, 0});
      cameras_.push_back({rotation, rotation * -Eigen::Vector3d(0.3 * k * k, 0.05 * k, 1.2 * k)});
    }
    // Three points are seen by all cameras, the others by the last three.
    for (int p = 0; p < 12; ++p) {
      const Eigen::Vector3d shares = Draw<3>();
      const Eigen::Vector3d point = {3 * shares.x(), shares.y(), 12 + 2 * shares.z()};
      for (int k = p < 3 ? 0 : 1; k < static_cast<int>(cameras_.size()); ++k) AddRow(k, cameras_[k] * point, p);
    }
  }

  template <int kSize>
  Eigen::Matrix<double, kSize, 1> Draw() {
    return DrawVector<kSize>([&] { return normal_(random_); });
  }

  void AddRow(int camera, const Eigen::Vector3d& x, int point) {
    Eigen::Matrix<double, 2, 3> by_x;
    by_x << 1 / x.z(), 0, -x.x() / (x.z() * x.z()), 0, 1 / x.z(), -x.y() / (x.z() * x.z());
    IntrinsicsRow row;
    row.column = kDof * (camera - 1);
    row.residual = Draw<2>();
    row.pose << -by_x * Skew(x), by_x * cameras_[camera].rotation.toRotationMatrix();
    row.intrinsics << Draw<kEntriesOfChange>().transpose(), Draw<kEntriesOfChange>().transpose();
    if (point == static_cast<int>(rows_.size())) rows_.emplace_back();
    rows_[point].push_back(row);
  }

  int UnknownsOfPoses() const { return kDof * (static_cast<int>(cameras_.size()) - 1); }

  // The rows of all points that `takes_part` names, over poses, points and intrinsics.
  struct FullSystem {
    Eigen::MatrixXd jacobian;
    Eigen::VectorXd residual;
  };
  FullSystem Full(const std::vector<std::optional<EliminatedPoint>>& takes_part) const {
    const int poses = UnknownsOfPoses();
    const int points = 3 * static_cast<int>(rows_.size());
    FullSystem full;
    full.jacobian = Eigen::MatrixXd::Zero(200, poses + points + kEntriesOfChange);
    full.residual = Eigen::VectorXd::Zero(200);
    int at = 0;
    for (std::size_t p = 0; p < rows_.size(); ++p) {
      if (!takes_part[p]) continue;
      for (const IntrinsicsRow& row : rows_[p]) {
        if (row.column >= 0) full.jacobian.block<2, kDof>(at, row.column) = row.pose;
        full.jacobian.block<2, 3>(at, poses + 3 * static_cast<int>(p)) = row.point();
        full.jacobian.block<2, kEntriesOfChange>(at, poses + points) = row.intrinsics;
        full.residual.segment<2>(at) = row.residual;
        at += 2;
      }
    }
    return full;
  }

  std::vector<std::optional<EliminatedPoint>> EliminateAll(ReducedSystem& system) const {
    std::vector<std::optional<EliminatedPoint>> points;
    for (const std::vector<IntrinsicsRow>& rows : rows_) points.push_back(Eliminate(rows, system));
    return points;
  }

  std::vector<RigidTransform> cameras_;
  std::vector<std::vector<IntrinsicsRow>> rows_;  // of each point

 private:
  std::mt19937 random_{5};
  std::normal_distribution<double> normal_;
};

TEST_F(Elimination, LeavesTheSchurComplementOfThePoints) {
  // Once more in the same keyframe: both rows share its block.
  rows_[0].push_back(rows_[0].back());
  rows_[0].back().residual = {1, -2};
  ReducedSystem system(static_cast<int>(cameras_.size()));
  const auto [jacobian, residual] = Full(EliminateAll(system));
  const int poses = UnknownsOfPoses();
  const int points = 3 * static_cast<int>(rows_.size());
  Eigen::MatrixXd kept(jacobian.rows(), poses + kEntriesOfChange);
  kept << jacobian.leftCols(poses), jacobian.rightCols(kEntriesOfChange);
  const Eigen::MatrixXd of_points = jacobian.middleCols(poses, points);
  // What the points cannot explain.
  const Eigen::MatrixXd left = kept - of_points * of_points.householderQr().solve(kept);
  const Eigen::MatrixXd hessian = left.transpose() * left;
  const Eigen::MatrixXd found = system.hessian.selfadjointView<Eigen::Upper>();
  EXPECT_NEAR((found - hessian).norm(), 0, 1e-9 * hessian.norm());
  const Eigen::VectorXd gradient = left.transpose() * residual;
  EXPECT_NEAR((system.gradient - gradient).norm(), 0, 1e-9 * gradient.norm());
}

TEST_F(Elimination, PosesAndPointsFollowTheIntrinsicsToTheirMinimum) {
  rows_[4].resize(2);  // two rows fit a point whatever the camera: it does not take part
  ReducedSystem system(static_cast<int>(cameras_.size()));
  const std::vector<std::optional<EliminatedPoint>> points = EliminateAll(system);
  ASSERT_FALSE(points[4]);
  const std::optional<MarginalIntrinsics> marginal = Marginalize(system, points, cameras_);
  ASSERT_TRUE(marginal);
  const auto [jacobian, residual] = Full(points);
  const IntrinsicsResponse& response = marginal->response;
  EXPECT_EQ(response.points[4], PointByIntrinsics::Zero()) << "it stays";
  EXPECT_EQ(response.point_step[4], Eigen::Vector3d::Zero());
  for (const IntrinsicsChange::Vector& step :
       {IntrinsicsChange::Vector(IntrinsicsChange::Vector::Zero()), Draw<kEntriesOfChange>()}) {
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(jacobian.cols());
    moved.head(UnknownsOfPoses()) = response.poses * step + response.pose_step;
    for (std::size_t p = 0; p < points.size(); ++p)
      moved.segment<3>(UnknownsOfPoses() + 3 * static_cast<int>(p)) =
          response.points[p] * step + response.point_step[p];
    moved.tail<kEntriesOfChange>() = step;
    const Eigen::VectorXd gradient = jacobian.transpose() * (jacobian * moved + residual);
    const IntrinsicsChange::Vector of_intrinsics = marginal->information * step + marginal->gradient;
    EXPECT_NEAR(gradient.head(gradient.size() - kEntriesOfChange).norm(), 0, 1e-8) << "of poses and points";
    EXPECT_NEAR((gradient.tail<kEntriesOfChange>() - of_intrinsics).norm(), 0, 1e-8);
    // Nothing grows about the first camera.
    double growth = 0;
    for (std::size_t k = 1; k < cameras_.size(); ++k)
      growth += moved.segment<3>(kDof * (static_cast<int>(k) - 1) + 3).dot(cameras_[k].inverse().translation);
    EXPECT_NEAR(growth, 0, 1e-8);
  }
}

TEST_F(Elimination, APointWhoseDepthIsNotDeterminedLeavesTheSystemAsItWas) {
  ReducedSystem system(static_cast<int>(cameras_.size()));
  std::vector<IntrinsicsRow> from_one_place = {rows_[0][1], rows_[0][1], rows_[0][1]};
  EXPECT_FALSE(Eliminate(from_one_place, system));
  from_one_place.clear();
  EXPECT_FALSE(Eliminate(from_one_place, system)) << "no rows";
  EXPECT_TRUE(system.hessian.isZero(0));
  EXPECT_TRUE(system.gradient.isZero(0));
  EXPECT_TRUE(Eliminate(rows_[0], system));
}

TEST_F(Elimination, PosesHaveToBeDetermined) {
  const int cameras = static_cast<int>(cameras_.size());
  EXPECT_FALSE(Marginalize(ReducedSystem(cameras), {}, cameras_)) << "no points";
  ReducedSystem system(cameras);
  const std::vector<std::optional<EliminatedPoint>> points = EliminateAll(system);
  EXPECT_TRUE(Marginalize(system, points, cameras_));
  EXPECT_FALSE(Marginalize(system, points, std::vector<RigidTransform>(cameras_.size())))
      << "without motion there is no unit of length to hold";
  system.gradient[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Marginalize(system, points, cameras_));
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/calibration/axis_convention.h"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace turnscale {

AxisConvention FindAxisConvention(const std::vector<CameraStep>& steps) {
  Eigen::Vector3d way = Eigen::Vector3d::Zero();
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double turning = 0;
  for (const CameraStep& step : steps) {
    const Eigen::Vector3d turn = step.frames * VectorFromRotation(step.previous_from_current.rotation);
    way += step.previous_from_current.translation;
    scatter += turn * turn.transpose();
    turning += turn.norm();
  }
  constexpr double kCosine45Deg = 0.7071;
  if (way.norm() == 0 || std::abs(way.normalized().x()) < kCosine45Deg) return AxisConvention::kCamera;
  constexpr double kTurn = 0.5;  // rad
  if (turning < kTurn) return AxisConvention::kForwardLeftUp;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  const bool about_z = std::abs(solver.eigenvectors()(2, 2)) > kCosine45Deg;
  return about_z ? AxisConvention::kForwardLeftUp : AxisConvention::kCamera;
}

Trajectory InCameraAxes(Trajectory body_path, AxisConvention axes) {
  if (axes == AxisConvention::kCamera) return body_path;
  const double side = axes == AxisConvention::kForwardLeftUp ? -1 : 1;
  Eigen::Matrix3d body_from_camera;
  body_from_camera << 0, 0, 1, side, 0, 0, 0, side, 0;
  const RigidTransform mount{Eigen::Quaterniond(body_from_camera), Eigen::Vector3d::Zero()};
  for (StampedPose& pose : body_path) pose.world_from_camera = pose.world_from_camera * mount;
  return body_path;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/calibration/camera_axes.h"

#include <cmath>
#include <limits>
#include <numbers>

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

Eigen::Quaterniond BodyFromCamera(AxisConvention axes) {
  if (axes == AxisConvention::kCamera) return Eigen::Quaterniond::Identity();
  const double side = axes == AxisConvention::kForwardLeftUp ? -1 : 1;
  Eigen::Matrix3d body_from_camera;
  body_from_camera << 0, 0, 1, side, 0, 0, 0, side, 0;
  return Eigen::Quaterniond(body_from_camera);
}

Trajectory InCameraAxes(Trajectory body_path, AxisConvention axes) {
  if (axes == AxisConvention::kCamera) return body_path;
  const RigidTransform mount{BodyFromCamera(axes), Eigen::Vector3d::Zero()};
  for (StampedPose& pose : body_path) pose.world_from_camera = pose.world_from_camera * mount;
  return body_path;
}

YawPitchRoll SigmaOfAngles(const Eigen::Quaterniond& vehicle_from_camera, const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) {
    constexpr double kUnknown = std::numeric_limits<double>::infinity();
    return {kUnknown, kUnknown, kUnknown};
  }
  constexpr double kStep = 1e-6;
  Eigen::Matrix3d by_rotation;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d small = kStep * Eigen::Vector3d::Unit(axis);
    const YawPitchRoll more = YawPitchRollFromRotation(RotationFromVector(small) * vehicle_from_camera);
    const YawPitchRoll less = YawPitchRollFromRotation(RotationFromVector(-small) * vehicle_from_camera);
    const Eigen::Vector3d change(std::remainder(more.yaw - less.yaw, 2 * std::numbers::pi), more.pitch - less.pitch,
                                 std::remainder(more.roll - less.roll, 2 * std::numbers::pi));
    by_rotation.col(axis) = change / (2 * kStep);
  }
  const auto sigma = [&](int angle) {
    const Eigen::Vector3d row = by_rotation.row(angle);
    return std::sqrt(row.dot(covariance * row));
  };
  return {sigma(0), sigma(1), sigma(2)};
}

Eigen::Matrix3d UnknownRotation() {
  return Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()).asDiagonal();
}

Eigen::Quaterniond RotationFromForwardAndDown(const Eigen::Vector3d& forward, const Eigen::Vector3d& down) {
  Eigen::Matrix3d camera_from_vehicle;
  camera_from_vehicle.col(2) = forward.normalized();
  camera_from_vehicle.col(0) = down.cross(forward).normalized();
  camera_from_vehicle.col(1) = camera_from_vehicle.col(2).cross(camera_from_vehicle.col(0));
  return Eigen::Quaterniond(camera_from_vehicle).conjugate();
}

}  // namespace turnscale

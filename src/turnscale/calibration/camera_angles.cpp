// SPDX-License-Identifier: MIT
#include "turnscale/calibration/camera_angles.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace turnscale {

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

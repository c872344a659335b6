// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Geometry>

namespace turnscale {

/// The car, as far as the camera's motion tells of it.
struct VehicleOptions {
  /// Distance from the rear axle forward to the camera, metres. Without it the path stays up to scale.
  std::optional<double> lever_arm;
  /// c in L_eff = L - c v^2, s^2/m: the rear axle's slip angle per lateral acceleration (blueprint 4). 0 is the paper's
  /// rigid car.
  double side_slip = 0.0045;
  /// The paper's Q.
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
};

/// Everything that can be set; the defaults are the one frozen configuration for all drives.
struct OdometryOptions {
  VehicleOptions vehicle;
  /// Threads that image operations may use. Changes the time, never the result.
  int threads = 2;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {

/// The shape of the paper's synthetic drive (V-B, Fig. 8), as far as the paper tells: 1.2 km in 3,500 frames, nine
/// turns of about 90 degrees.
struct PaperDriveOptions {
  double length = 1200;    ///< metres of the rear axle
  int frames = 3500;       ///< poses; one fewer steps
  double rate_hz = 10;     ///< frames per second
  double turn_radius = 7;  ///< metres; 2.8 deg a frame, just above the paper's psi_th of 2.5 deg
  double ramp = 2;         ///< metres in which the steering goes from straight to full
  double lever_arm = 1;    ///< metres
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The drive's steps; nine turns with equal straights between, five to the right and four to the left. Throws
/// InputError where an option makes no sense.
std::vector<AckermannStep> PaperDriveSteps(const PaperDriveOptions& options = {});

/// What an odometry makes of a drive.
struct OdometryNoise {
  double rotation = 0;   ///< of each frame's rotation, rad about each axis
  double direction = 0;  ///< of each frame's direction of travel, rad about each axis across it
  std::uint64_t seed = 1;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The camera's path as an odometry with that noise would give it: each frame's motion is disturbed by itself, and the
/// motions are put one after the other. Same seed, same bits. Throws InputError where an option makes no sense.
Trajectory NoisyCameraPath(const std::vector<AckermannStep>& steps, const PaperDriveOptions& drive,
                           const OdometryNoise& noise);

}  // namespace turnscale

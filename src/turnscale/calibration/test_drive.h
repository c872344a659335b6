// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "turnscale/base/random.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/kinematics/synthetic_drive.h"

namespace turnscale {

constexpr double kDeg = 1 / kDegreesPerRadian;

/// How a camera may sit on a car: tilted about all three axes.
inline const Eigen::Quaterniond kTilted = RotationFromYawPitchRoll({5 * kDeg, 15 * kDeg, -10 * kDeg});
/// Another, that looks down.
inline const Eigen::Quaterniond kTiltedDown = RotationFromYawPitchRoll({0.2, -0.3, 0.1});

/// A drive of 10 frames a second and 0.8 m a frame, for tests: right angles by 3 deg a frame between straights of
/// `straight` frames; the signs of `turns` say which way.
inline std::vector<DriveSegment> TestRoute(const std::vector<int>& turns, int straight = 60) {
  std::vector<DriveSegment> route{{straight, 0.8, 0}};
  for (const int side : turns) {
    for (const double psi : {1.0, 2.0}) route.push_back({3, 0.8, side * psi * kDeg});
    route.push_back({24, 0.8, side * 3 * kDeg});
    for (const double psi : {2.0, 1.0}) route.push_back({3, 0.8, side * psi * kDeg});
    route.push_back({straight, 0.8, 0});
  }
  return route;
}

/// The camera's path on it, `noise` being that of each frame's rotation and direction of travel, rad.
inline Trajectory TestPath(const std::vector<DriveSegment>& route, const LeverArm& lever_arm,
                           const Eigen::Quaterniond& vehicle_from_camera, double noise = 0, int seed = 1) {
  Random random(static_cast<std::uint64_t>(seed));
  const auto disturbance = [&] {
    const double x = random.Gaussian();
    const double y = random.Gaussian();
    const double z = random.Gaussian();
    return RotationFromVector(noise * Eigen::Vector3d(x, y, z));
  };
  const CarDrive drive = MakeCarDrive(route, 0.1, lever_arm, vehicle_from_camera);
  Trajectory path{StampedPose{}};
  for (size_t i = 1; i < drive.world_from_camera.size(); ++i) {
    RigidTransform motion = drive.world_from_camera[i - 1].inverse() * drive.world_from_camera[i];
    motion.rotation = motion.rotation * disturbance();
    motion.translation = disturbance() * motion.translation;
    path.push_back({0.1 * static_cast<double>(i), path.back().world_from_camera * motion});
  }
  return path;
}

/// Keyframes of a path at unequal spacing: every 1, 4, 1, 2 and 6 frames.
inline Trajectory EveryFew(const Trajectory& path) {
  constexpr std::array<size_t, 5> kSpacing = {1, 4, 1, 2, 6};
  Trajectory keyframes;
  size_t turn = 0;
  for (size_t i = 0; i < path.size(); i += kSpacing[turn++ % kSpacing.size()]) keyframes.push_back(path[i]);
  return keyframes;
}

/// Angle between two rotations, degrees.
inline double DegreesBetween(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return RotationAngle(a.conjugate() * b) * kDegreesPerRadian;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <vector>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {

/// Equal steps of a made-up drive, for tests.
struct DriveSegment {
  int steps = 0;
  double camera_distance = 0;  ///< metres the camera moves in a step; negative in reverse
  double psi = 0;              ///< rad the car turns in a step
};

/// Seconds a step of such a drive usually takes.
constexpr double kStepInterval = 0.1;

/// A drive whose truth is known.
struct CarDrive {
  double dt = kStepInterval;                      ///< seconds a step
  std::vector<RigidTransform> world_from_camera;  ///< one more than there are steps; metres; the first is the identity
};

/// `previous_from_current` of a camera on a car whose tyres slip: the rigid car's motion about the point that does not
/// move sideways, which the slip puts nearer to the camera, and in reverse farther away.
inline RigidTransform SlippingCameraMotion(const DriveSegment& segment, double dt, const LeverArm& lever_arm,
                                           const Eigen::Quaterniond& vehicle_from_camera) {
  const double effective = lever_arm.At(segment.camera_distance / dt);
  const double swing = 2.0 * effective * std::sin(0.5 * segment.psi);
  const double way = std::sqrt(segment.camera_distance * segment.camera_distance - swing * swing);
  const double rho = std::copysign(way, segment.camera_distance);
  return ConstrainedCameraMotion({segment.psi, rho}, effective, vehicle_from_camera);
}

inline CarDrive MakeCarDrive(const std::vector<DriveSegment>& segments, double dt, const LeverArm& lever_arm,
                             const Eigen::Quaterniond& vehicle_from_camera) {
  CarDrive drive{dt, {RigidTransform{}}};
  for (const DriveSegment& segment : segments) {
    const RigidTransform step = SlippingCameraMotion(segment, dt, lever_arm, vehicle_from_camera);
    for (int i = 0; i < segment.steps; ++i) {
      drive.world_from_camera.push_back(drive.world_from_camera.back() * step);
    }
  }
  return drive;
}

/// A body on springs: it leans outwards in a turn, about an axis below the camera.
struct BodyRoll {
  double height = 0;            ///< of the camera above that axis, metres
  double per_acceleration = 0;  ///< rad per m/s^2 sideways
};

/// Lets the body of the car roll; `dt` seconds from pose to pose.
inline void RollBody(std::vector<RigidTransform>& world_from_camera, const Eigen::Quaterniond& vehicle_from_camera,
                     const BodyRoll& body, double dt) {
  constexpr double kLag = 0.2;  // share of what is missing that a step makes good
  double roll = 0;
  RigidTransform before = world_from_camera.front();
  for (std::size_t i = 1; i < world_from_camera.size(); ++i) {
    RigidTransform& pose = world_from_camera[i];
    const TurningMotion step = TurningMotionOf(before.inverse() * pose, vehicle_from_camera);
    before = pose;
    roll += kLag * (-body.per_acceleration * step.step * step.psi / (dt * dt) - roll);
    const Eigen::Quaterniond world_from_vehicle = pose.rotation * vehicle_from_camera.conjugate();
    pose.translation +=
        world_from_vehicle * Eigen::Vector3d(body.height * std::sin(roll), body.height * (1 - std::cos(roll)), 0);
    pose.rotation = world_from_vehicle * RotationFromVector({0, 0, roll}) * vehicle_from_camera;
  }
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// What a car that rolls without slipping does from one moment to the next (1).
struct AckermannStep {
  double psi = 0;  ///< turning angle, rad, positive to the right
  double rho = 0;  ///< straight distance between the two places of the rear axle's centre, metres
};

/// `previous_from_current` of the vehicle frame V (1).
RigidTransform ConstrainedVehicleMotion(const AckermannStep& step);

/// `previous_from_current` of the auxiliary camera frame A, `lever_arm` metres ahead of the rear axle (2), (3).
RigidTransform ConstrainedAuxiliaryMotion(const AckermannStep& step, double lever_arm);

/// `previous_from_current` of the camera, `vehicle_from_camera` being the paper's Q (4).
RigidTransform ConstrainedCameraMotion(const AckermannStep& step, double lever_arm,
                                       const Eigen::Quaterniond& vehicle_from_camera);

/// Straight distance between the two places of the camera, metres: s^2 = rho^2 + 4 L^2 sin^2(psi/2), from (3).
double CameraDistance(const AckermannStep& step, double lever_arm);

/// theta: where the camera goes, seen from where it looks in A; rad, positive to the right (23).
double DirectionOfTravel(const AckermannStep& step, double lever_arm);

/// rho in metres from the two angles the camera sees (21). Infinite or of either sign where theta - psi/2 is zero or
/// contradicts psi: no such step exists then.
double TravelFromAngles(double psi, double theta, double lever_arm);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Motion of a car without slip between two poses (1).
struct AckermannStep {
  double psi = 0;  ///< turning angle, rad, positive to the right
  double rho = 0;  ///< straight distance between the two positions of the rear axle's centre, metres
};

/// `previous_from_current` of the vehicle frame V (1).
RigidTransform ConstrainedVehicleMotion(const AckermannStep& step);

/// `previous_from_current` of the auxiliary camera frame A, `lever_arm` metres ahead of the rear axle (2), (3).
RigidTransform ConstrainedAuxiliaryMotion(const AckermannStep& step, double lever_arm);

/// `previous_from_current` of the camera, `vehicle_from_camera` being the paper's Q (4).
RigidTransform ConstrainedCameraMotion(const AckermannStep& step, double lever_arm,
                                       const Eigen::Quaterniond& vehicle_from_camera);

/// Straight distance between the two camera positions, metres: s^2 = rho^2 + 4 L^2 sin^2(psi/2), from (3).
double CameraDistance(const AckermannStep& step, double lever_arm);

/// theta: direction of travel of the camera relative to its heading in A; rad, positive to the right (23).
double DirectionOfTravel(const AckermannStep& step, double lever_arm);

/// rho in metres from the two observed angles (21). Infinite or of either sign if theta - psi/2 is zero or
/// inconsistent with psi: no such step exists then.
double TravelFromAngles(double psi, double theta, double lever_arm);

}  // namespace turnscale

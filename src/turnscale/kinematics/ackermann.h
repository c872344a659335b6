// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include <Eigen/Geometry>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Default slip-angle coefficient c of an unknown car, s^2/m: about 2.5 deg of rear slip angle per g.
constexpr double kUsualSideSlip = 0.0045;
/// Its standard deviation over cars with soft to stiff tyres, s^2/m.
constexpr double kUsualSideSlipSigma = 0.002;
/// Relative standard deviation of a measured c: load and tyre pressure change.
constexpr double kGivenSideSlipSigma = 0.12;
/// Standard deviation of a c that was given without one, s^2/m. Zero is not measured but assumed: no tyre is that
/// stiff.
constexpr double SigmaOfGivenSideSlip(double side_slip) {
  return side_slip > 0 ? kGivenSideSlipSigma * side_slip : kUsualSideSlipSigma;
}
/// Standard deviation of a lever arm measured with a tape, metres.
constexpr double kTapeSigma = 0.03;
/// Longest lever arm and largest height of a camera above the road that make sense, metres: more is a wrong unit.
constexpr double kLongestLeverArm = 20;
constexpr double kHighestCamera = 10;
/// Largest relative standard deviation that is put on a length: it has to be below the length.
constexpr double kMostLengthSigma = 0.9;
/// Height of a car's camera above the axis about which its body rolls, metres: cameras are 1.2 to 1.7 m above the road,
/// the axis is near the road.
constexpr double kUsualRollHeight = 1.1;
constexpr double kUsualRollHeightSigma = 0.35;  ///< its standard deviation over cars and cameras, metres

/// Distance of the camera ahead of the point without lateral velocity.
struct LeverArm {
  double length = 0;     ///< L: from the rear axle forward to the camera, metres
  double side_slip = 0;  ///< c: the rear axle's slip angle per lateral acceleration, s^2/m; 0 is the paper's rigid car
  /// Height of the camera above the axis about which the body rolls, metres; 0: roll does not move the camera.
  double roll_height = 0;

  /// The effective lever arm at a speed (m/s, negative in reverse): L - c v |v|. The rear tyres slip outwards in a
  /// turn: the point without lateral velocity moves forward, in reverse backward. Negative beyond v = sqrt(L/c).
  double At(double speed) const { return length - side_slip * speed * std::abs(speed); }
};

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

/// A camera step in kinematic terms.
struct TurningMotion {
  double psi = 0;    ///< turning angle, rad, positive to the right
  double theta = 0;  ///< direction of travel in A's horizontal plane, rad, positive to the right (19)
  double step = 0;   ///< distance between the two camera centres, in the unit of the motion
};

/// Kinematic terms of a camera's `previous_from_current`; `vehicle_from_camera` is the paper's Q.
///
/// psi is the part of the rotation about the vehicle's y axis (twist), signed by that axis. (9) takes the whole angle,
/// by arccos of the trace: that loses half the digits near zero, counts pitching and rolling as turning, and has no
/// sign. theta is 0 for a step of length 0.
TurningMotion TurningMotionOf(const RigidTransform& previous_from_current,
                              const Eigen::Quaterniond& vehicle_from_camera);

/// The paper's scale observer (22), with L where the geometry requires it: metres between the two camera positions
/// in a step that turns by psi and goes towards theta (rad),
///   s = 2 L sin(psi) / (sin(theta) - sin(psi - theta)) = 2 L sin(psi/2) / sin(theta - psi/2).
/// The second form is used; theta - psi/2 is the signal. Not positive and finite if the angles are inconsistent with
/// the model: the step then carries no information.
double ObservedDistance(double psi, double theta, double lever_arm);

/// The same with side slip, the speed being the one that the distance gives over dt seconds (> 0). Equal to
/// ObservedDistance where the slip is 0.
double ObservedDistance(double psi, double theta, double dt, const LeverArm& lever_arm);

/// Derivatives of the observer at L = 1 m, s' = s/L, per radian (31). The paper prints half of the one by psi.
struct ScaleSensitivity {
  double by_psi = 0;
  double by_theta = 0;
};

ScaleSensitivity SensitivityOfScale(double psi, double theta);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/ackermann.h"

#include <cmath>

#include "turnscale/geometry/rotation.h"

namespace turnscale {

RigidTransform ConstrainedVehicleMotion(const AckermannStep& step) {
  const double gamma = 0.5 * step.psi;
  return {RotationFromVector({0, step.psi, 0}), {step.rho * std::sin(gamma), 0, step.rho * std::cos(gamma)}};
}

RigidTransform ConstrainedAuxiliaryMotion(const AckermannStep& step, double lever_arm) {
  const double gamma = 0.5 * step.psi;
  RigidTransform motion = ConstrainedVehicleMotion(step);
  motion.translation.x() += lever_arm * std::sin(step.psi);
  // L cos(psi) - L without the difference of two nearly equal numbers.
  motion.translation.z() -= 2.0 * lever_arm * std::sin(gamma) * std::sin(gamma);
  return motion;
}

RigidTransform ConstrainedCameraMotion(const AckermannStep& step, double lever_arm,
                                       const Eigen::Quaterniond& vehicle_from_camera) {
  const RigidTransform vehicle_axes_from_camera{vehicle_from_camera, Eigen::Vector3d::Zero()};
  return vehicle_axes_from_camera.inverse() * ConstrainedAuxiliaryMotion(step, lever_arm) * vehicle_axes_from_camera;
}

double CameraDistance(const AckermannStep& step, double lever_arm) {
  return std::hypot(step.rho, 2.0 * lever_arm * std::sin(0.5 * step.psi));
}

double DirectionOfTravel(const AckermannStep& step, double lever_arm) {
  // (23) is the tangent of a sum: half the turn, and the angle that the camera's swing adds to it.
  return 0.5 * step.psi + std::atan2(2.0 * lever_arm * std::sin(0.5 * step.psi), step.rho);
}

TurningMotion TurningMotionOf(const RigidTransform& previous_from_current,
                              const Eigen::Quaterniond& vehicle_from_camera) {
  const Eigen::Quaterniond turn =
      vehicle_from_camera * previous_from_current.rotation * vehicle_from_camera.conjugate();
  const Eigen::Vector3d travel = vehicle_from_camera * previous_from_current.translation;
  return {TwistAboutY(turn), std::atan2(travel.x(), travel.z()), travel.norm()};
}

double ObservedDistance(double psi, double theta, double lever_arm) {
  return 2.0 * lever_arm * std::sin(0.5 * psi) / std::sin(theta - 0.5 * psi);
}

double ObservedDistance(double psi, double theta, double dt, const LeverArm& lever_arm) {
  if (lever_arm.side_slip == 0) return ObservedDistance(psi, theta, lever_arm.length);
  // s sin(theta - psi/2) = 2 (L - c (s/dt)^2) sin(psi/2): quadratic in s, one root is positive. In reverse c has the
  // other sign, and the smaller of two positive roots is taken. Turned so that psi > 0.
  const double x = 2.0 * std::abs(std::sin(0.5 * psi));
  const double swing = std::copysign(1.0, psi) * std::sin(theta - 0.5 * psi);
  const double quadratic = std::copysign(lever_arm.side_slip * x / (dt * dt), std::cos(theta - 0.5 * psi));
  const double constant = lever_arm.length * x;
  return 2.0 * constant / (swing + std::sqrt(swing * swing + 4.0 * quadratic * constant));
}

ScaleSensitivity SensitivityOfScale(double psi, double theta) {
  const double swing = theta - 0.5 * psi;
  const double squared_sine = std::sin(swing) * std::sin(swing);
  return {std::sin(theta) / squared_sine, -2.0 * std::sin(0.5 * psi) * std::cos(swing) / squared_sine};
}

}  // namespace turnscale

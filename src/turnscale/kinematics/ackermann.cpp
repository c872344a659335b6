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

double TravelFromAngles(double psi, double theta, double lever_arm) {
  // The quotient of (21) with both sums of sines written as products: cot(theta - psi/2) is what is left of it.
  const double swing = theta - 0.5 * psi;
  return 2.0 * lever_arm * std::sin(0.5 * psi) * std::cos(swing) / std::sin(swing);
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/scale_observer.h"

#include <cmath>

namespace turnscale {

double ObservedDistance(double psi, double theta, double lever_arm) {
  return 2.0 * lever_arm * std::sin(0.5 * psi) / std::sin(theta - 0.5 * psi);
}

double ObservedDistance(double psi, double theta, double dt, const LeverArm& lever_arm) {
  if (lever_arm.side_slip == 0) return ObservedDistance(psi, theta, lever_arm.length);
  // s sin(theta - psi/2) = 2 (L - c (s/dt)^2) sin(psi/2): quadratic in s, one root is positive. Turned so that psi > 0.
  const double x = 2.0 * std::abs(std::sin(0.5 * psi));
  const double swing = std::copysign(1.0, psi) * std::sin(theta - 0.5 * psi);
  const double quadratic = lever_arm.side_slip * x / (dt * dt);
  const double constant = lever_arm.length * x;
  return 2.0 * constant / (swing + std::sqrt(swing * swing + 4.0 * quadratic * constant));
}

ScaleSensitivity SensitivityOfScale(double psi, double theta) {
  const double swing = theta - 0.5 * psi;
  const double squared_sine = std::sin(swing) * std::sin(swing);
  return {std::sin(theta) / squared_sine, -2.0 * std::sin(0.5 * psi) * std::cos(swing) / squared_sine};
}

double ObservedDistanceSigma(double psi, double theta, double lever_arm, double sigma_psi, double sigma_theta) {
  const ScaleSensitivity sensitivity = SensitivityOfScale(psi, theta);
  return lever_arm * std::hypot(sensitivity.by_psi * sigma_psi, sensitivity.by_theta * sigma_theta);
}

}  // namespace turnscale

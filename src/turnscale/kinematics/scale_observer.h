// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/kinematics/lever_arm.h"

namespace turnscale {

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

/// Standard deviation of ObservedDistance (metres) from those of psi and theta (rad), taken as independent and small.
double ObservedDistanceSigma(double psi, double theta, double lever_arm, double sigma_psi, double sigma_theta);

}  // namespace turnscale

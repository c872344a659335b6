// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/calibration/lever_arm_equation.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {

/// Error of the camera's sideways velocity, as the residuals of a drive show it: a part that is independent from step
/// to step, and one that is common to steps within some seconds, and so to a turn. It is about as large on straights as
/// in turns, so that the straights tell how much a single turn is off.
struct MotionNoise {
  double step_variance = 0;    ///< (m/s)^2
  double common_variance = 0;  ///< (m/s)^2; correlation exp(-t / kCommonSeconds) over t seconds
};

/// On the ground truth of KITTI, which is inertial, the correlation falls to 1/e in 1.5 to 2.5 s.
constexpr double kCommonSeconds = 2;
/// Usual standard deviation of the common part, m/s. It counts as one value among those of a drive, of which a short
/// one has few.
constexpr double kUsualCommonVelocity = 0.02;

/// The noise of the equations of one drive, to which so many unknowns were fitted: they take errors with them, most of
/// all those of a short drive.
MotionNoise FindMotionNoise(const std::vector<FittedEquation>& equations, double unknowns);

/// Covariance of the unknowns of a fit: the motion's noise, what turns and straights deviate from the kinematics
/// (turn_errors.h), and the height above the roll axis, which errs in all turns alike. If the steps, or the turns among
/// each other, scatter by more, theirs. `hessian` is that of the fit, `drives` is the number of drives, in each of
/// which the noise has its own size.
Eigen::MatrixXd CovarianceOfFit(const std::vector<FittedEquation>& equations, const Eigen::MatrixXd& hessian,
                                int drives, const LeverArm& lever_arm);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/kinematics/lever_arm.h"
#include "turnscale/kinematics/turning_motion.h"

namespace turnscale {

/// A step of a turn as the odometry measured it, in its own unit of length.
struct TurningStep {
  TurningMotion motion;
  double dt = 0;  ///< seconds; 0 where unknown
};

/// How the scales seen in a turn are made one.
enum class ScaleMethod {
  kPooledLine,  ///< one line through all steps
  kPerFrame,    ///< the paper's observer (22) for each step; their median speaks for the turn
};

struct PooledScaleOptions {
  ScaleMethod method = ScaleMethod::kPooledLine;
  /// Standard deviation of a step's direction of travel, rad: the least noise that is believed in, however well few
  /// steps agree with each other (0.5 deg, what monocular odometry shows over steps of 3 deg).
  double sigma_theta = 0.5 / 57.295779513082320877;
  /// Residuals beyond this many robust standard deviations have no say (Tukey's biweight). Wide, because a camera
  /// centre that is off sideways enters two steps with opposite sign: throwing out one of them alone does harm.
  double robust_threshold = 6.0;
  /// Least number of steps that must agree.
  int min_inliers = 3;
  /// Least sum of |psi| of the agreeing steps, rad (10 deg).
  double min_angle = 10.0 / 57.295779513082320877;
  /// Least share of the lever arm that must be seen. Below it the scale hangs on the side slip rather than on the tape
  /// measure, or the turn contradicts the model.
  double min_lever_share = 0.25;
  /// Greatest relative standard deviation of a scale worth having: the map carries the last one better than that over
  /// some hundred metres.
  double max_relative_sigma = 0.15;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// What a turn says of the unit of length.
struct PooledScale {
  double metres_per_unit = 0;      ///< lambda
  double sigma = 0;                ///< standard deviation of metres_per_unit
  int inliers = 0;                 ///< steps that agree
  double effective_lever_arm = 0;  ///< the one that the agreeing steps show at this scale, metres
};

struct PooledScaleResult {
  std::optional<PooledScale> scale;
  std::string reason;  ///< one line that says why there is no scale; empty where there is one
};

/// Metres per unit of the odometry from the steps of one turn.
///
/// Every step says lambda y = (L - c v^2) x with x = 2 sin(psi/2), the camera's sideways step y = step sin(theta -
/// psi/2) and v = lambda step / dt: a line through the origin whose slope is found by robust least squares, together
/// with the slip it implies. Multiplying all steps by k divides lambda by k, to rounding.
///
/// Noise is taken to be in y alone, of one size for all steps (position noise does not grow with the step) and
/// independent from step to step. Sigma comes from the residuals, and is at least what sigma_theta gives. It is too
/// large where the camera centres jitter independently (a centre's error enters two steps with opposite sign and
/// cancels along the turn); it does not cover what all steps share: errors of L, c and the camera's yaw.
///
/// Side slip needs dt > 0 in every step. Throws InputError when the lever arm makes no sense.
PooledScaleResult PoolScale(const std::vector<TurningStep>& steps, const LeverArm& lever_arm,
                            const PooledScaleOptions& options = {});

/// The effective lever arm (metres) that a turn shows at a known scale: the robust slope of the same line. Empty when
/// the steps do not turn.
std::optional<double> ObservedLeverArm(const std::vector<TurningStep>& steps, double metres_per_unit,
                                       const PooledScaleOptions& options = {});

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "turnscale/geometry/angle.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/vehicle_step.h"

namespace turnscale {

/// A point of a line through the origin; all noise is in y.
struct LinePoint {
  double x = 0;
  double y = 0;
};

/// A line y = slope x fitted to points.
struct RobustLine {
  double slope = 0;
  double sigma = 0;            ///< standard deviation of the slope
  std::vector<double> weight;  ///< one per point, in [0, 1]
};

/// Robust line through the origin: iterated least squares with Tukey's biweight, started at the weighted L1 line.
/// `noise_floor` is a lower bound of the standard deviation of y, in the unit of y; must be positive.
/// Residuals beyond `threshold` robust standard deviations have no weight. At least one x has to differ from 0.
RobustLine FitRobustLine(const std::vector<LinePoint>& points, double noise_floor, double threshold);

/// Lateral noise that a standard deviation of the direction of travel (rad) makes in a step of ordinary length,
/// odometry units. There has to be a step.
double LateralNoise(std::span<const VehicleStep> steps, double sigma_theta);

struct PooledLineOptions {
  /// Standard deviation of a step's direction of travel, rad: a lower bound of the noise, however well few
  /// steps agree with each other (0.25 deg, half of what monocular odometry shows over steps of 3 deg).
  double sigma_theta = 0.25 / kDegreesPerRadian;
  /// Residuals beyond this many robust standard deviations get no weight (Tukey's biweight). Wide, because a lateral
  /// error of a camera centre enters two steps with opposite sign: rejecting only one of them would bias the line.
  double robust_threshold = 6.0;
  /// Least number of inlier steps.
  int min_inliers = 3;
  /// Least sum of |psi| of the inlier steps, rad (10 deg).
  double min_angle = 10.0 / kDegreesPerRadian;
  /// Standard deviation of a step's turning angle, rad (0.05 deg): what the direction that a turn shows by itself is
  /// uncertain by where its curvature hardly changes.
  double sigma_psi = 0.05 / kDegreesPerRadian;
  /// A turn shows no direction if less than this share of the way forward (squares) is not proportional to x or roll.
  double min_forward_share = 0.003;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Robust line fit of one turn, which needs no scale: every step has a lateral displacement
/// y = VehicleStep::lateral() that is the effective lever arm times x = 2 sin(psi/2) (see the paper's (22)), and the
/// height of the camera above the axis of roll times VehicleStep::roll. The slope by x is the effective lever arm in
/// the odometry's unit of length.
struct PooledLine {
  double lever_arm = 0;  ///< effective lever arm, odometry units
  double sigma = 0;      ///< its standard deviation, from the scatter of the steps
  /// Derivative of `lever_arm` by an error of the direction of travel, to the right, odometry units per rad.
  double by_direction = 0;
  /// Derivative of `lever_arm` by the height of the camera above the axis of roll. Small over a whole turn, into which
  /// the body leans and out of which it comes up again.
  double by_roll_height = 0;
  /// Of the speed, weighted as the steps, (units/s)^2; 0 if times are unknown. Steps in reverse count negative: there
  /// the slip of the tyres has the opposite sign relative to psi.
  double mean_square_speed = 0;
  double mean_speed = 0;  ///< weighted likewise, units/s; steps in reverse count negative
  double angle = 0;       ///< sum of psi, rad
  int steps = 0;
  int inliers = 0;  ///< inlier steps
};

/// The line, or the reason why there is none, in one line.
struct PooledLineResult {
  std::optional<PooledLine> line;
  std::string reason;
};

/// Fits the line to the usable steps of a turn. Noise is assumed in y only, equal for all steps (position noise does
/// not grow with the step) and independent from step to step. Sigma is too large where the camera centres jitter
/// independently, since a centre's error enters two steps with opposite sign; it does not cover what all steps share:
/// the camera's yaw, the slip of the tyres. The part of the residuals that is proportional to the roll does not count
/// as noise; `lever_arm` is the slope with this part left in y.
PooledLineResult PoolTurn(std::span<const VehicleStep> steps, const PooledLineOptions& options);

/// Direction of travel on straights, as a turn shows it by itself: the part of the lateral displacements of its steps
/// that is proportional to the way forward, and neither to x nor to the roll. The curvature has to change in the turn.
struct DirectionInTurn {
  /// rad, positive to the right; the direction of travel less c lambda `by_slip`.
  double angle = 0;
  double sigma = 0;    ///< standard deviation of `angle`, from the scatter of the steps, rad
  double by_slip = 0;  ///< of a speed that changes in the turn, units/s^2
  double by_lag = 0;   ///< likewise: the derivative of `angle` by a lag of the camera's orientation, rad/s
};

/// Fits it to the usable steps of a turn; its error is independent of that of the line. Empty where the turn does not
/// show it: too few steps, or a curvature that hardly changes.
std::optional<DirectionInTurn> FitDirectionInTurn(std::span<const VehicleStep> steps, const PooledLineOptions& options);

/// The scale (metres per unit) lambda that gives this lever arm: the positive root, in reverse the smaller of two, of
///   lambda (lever_arm - direction by_direction) + c lambda^2 mean_square_speed = L + roll_height by_roll_height.
/// `direction` is the direction of travel on straights, rad: minus the yaw error of Q. Infinite if the camera does
/// not move outwards and there is no slip, or if it swings out by less than any scale allows with slip in reverse.
/// Multiplying all lengths of the turn by k divides lambda by k.
double MetresPerUnit(const PooledLine& line, const LeverArm& lever_arm, double direction = 0);

/// Ratio of the effective to the measured lever arm in the turn at this scale: (L - c v^2) / L. Negative beyond
/// v = sqrt(L/c), above 1 in reverse.
double LeverArmRatio(const PooledLine& line, const LeverArm& lever_arm, double metres_per_unit);

/// Median of the scales of single steps from the paper's observer (22), with slip. Steps inconsistent with the model
/// count as infinite scales.
struct MedianScale {
  double metres_per_unit = std::numeric_limits<double>::infinity();
  /// Robust standard deviation of a step's inverse scale, relative to the median's.
  double spread = std::numeric_limits<double>::infinity();
};
MedianScale MedianOfSteps(const std::vector<VehicleStep>& steps, const LeverArm& lever_arm);

}  // namespace turnscale

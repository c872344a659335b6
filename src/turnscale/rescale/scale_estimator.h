// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "turnscale/kinematics/lever_arm.h"
#include "turnscale/rescale/noise_fit.h"
#include "turnscale/rescale/scale_filter.h"
#include "turnscale/rescale/stretch.h"
#include "turnscale/rescale/sway_step.h"

namespace turnscale {

/// What is known of the car and its camera beforehand.
struct CarPrior {
  double lever_arm = 0;               ///< L: from the rear axle forward to the camera, metres
  double side_slip = kUsualSideSlip;  ///< c, s^2/m
  double side_slip_sigma = 0.0015;    ///< cars differ by a third of it; 0 where c is known
  /// Of the yaw that Q has wrong, rad (0.5 deg: what a camera mounted by eye or calibrated from motion has).
  double yaw_sigma = 0.5 / 57.295779513082320877;
  /// Of the camera above the axis that the body rolls about, metres.
  double height = 1.5;
  double height_sigma = 1.0;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

struct ScaleEstimatorOptions {
  bool drifting = true;  ///< the odometry's scale drifts; false for loop-closed inputs
  NoiseFitOptions noise;
  double huber = 2;               ///< steps that disagree by more than this many sigmas lose weight
  double degrees_of_freedom = 4;  ///< of Student's t, which the errors of whole turns follow: some turns are bad

  /// Least share of the lever arm that side slip may leave in a turn. In faster turns the scale hangs on the slip
  /// rather than on the tape measure.
  double min_lever_arm_ratio = 0.25;
  /// Of the log-scale where tracking was lost and began anew, carried across by the predicted motion.
  double gap_sigma = 0.3;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The drive's scale, stretch by stretch.
struct ScaleEstimate {
  ScaleProblem problem;  ///< as it was solved at last
  ScaleNoise noise;
  double sway_sigma = 0;         ///< of a step, odometry units
  std::vector<Belief> smoothed;  ///< from the whole drive
  std::vector<Belief> filtered;  ///< from what came before, but with the whole drive's noise and weights
  bool converged = false;
  bool side_slip_at_bound = false;  ///< the drive wants tyres that slip inwards: c is held at 0
};

/// Maximum a posteriori scale of a drive. Nothing where no turn is slow enough and swings the camera outwards.
/// Observations of turns that are too fast are marked as not turning. Time is linear in the number of steps.
std::optional<ScaleEstimate> EstimateScale(const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
                                           const CarPrior& car, const ScaleEstimatorOptions& options);

}  // namespace turnscale

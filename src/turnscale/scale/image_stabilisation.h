// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turnscale/kinematics/vehicle_step.h"
#include "turnscale/scale/drive_smoothing.h"
#include "turnscale/scale/path_segment.h"
#include "turnscale/scale/scale_filter.h"

namespace turnscale {

/// Lag of images that electronic stabilisation turns to a mean of the camera's orientations over time: the mean delay
/// of these. The faster a turn is driven, the more the camera seems to swing out.
struct ImageLag {
  double found = 0;  ///< s; negative: the mean is over later orientations
  double found_sigma = 0;
  /// Relative error of a scale from turns, where something else may look like the lag: what it changes. 0 where enough
  /// turns confirm it, or it was known beforehand.
  double scale_error = 0;
  bool is_used = true;  ///< by the estimate; else sigma allows for it

  bool is_confirmed() const { return scale_error == 0; }
};

/// Smoothing of images that electronic stabilisation turns to a mean of orientations before and after each: the images
/// begin to turn before the car does, and turn on after it.
struct ImageSmoothing {
  double variance = 0;        ///< of the times over which the mean is taken, s^2
  double variance_sigma = 0;  ///< standard deviation of `variance`, s^2, without the errors that steps of a turn share
  /// Relative error of a scale from turns, to first order, at even speed: in the images, turns are slower. That of the
  /// drive's estimate includes what a lag may change that the turns do not show for certain.
  double scale_error = 0;
};

/// When a drive counts as stabilised.
struct StabilisationOptions {
  /// Look for it. Not useful for steps with known errors, as from a wrong calibration: these may look like it.
  bool enabled = true;
  /// Least deviation of the lag from 0, standard deviations.
  double min_lag_deviation = 3;
  /// Least deviation where the turns scatter less with the lag: sigmas of turns are conservative.
  double min_lag_deviation_with_less_scatter = 1.5;
  /// Least significance of this reduction, standard deviations (ReductionSignificance).
  double min_reduction_significance = 3.5;
  /// Least change of the scale by the lag, relative.
  double min_scale_change = 0.05;
  /// Standard deviation of the lag of stabilised images, s.
  double lag_sigma = 0.2;
  /// Take a lag that the turns show into the estimate. If not, sigma allows for it, as where a wrong calibration may
  /// look like it.
  bool adopts_lag = true;
  /// Used turns from which on they confirm a lag, since it has to explain more of them than it has unknowns. With
  /// fewer, sigma covers the scale without it: a principal point that is a little off looks the same.
  int min_lag_turns = 4;
  /// Largest standard deviation of a lag that is found, s. Turns of similar speeds give a larger one.
  double max_lag_sigma = 0.05;
  /// Least smoothing, standard deviation of the times, s: transients of the tyres and of the body look like a little of
  /// it.
  double min_smoothing = 0.3;
  /// Least deviation of the smoothing's variance from 0, standard deviations.
  double min_smoothing_deviation = 4;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Whether the lag of an estimate with one (`with`) counts, beside the estimate without (`without`).
bool LagCounts(const SmoothedDrive& without, const SmoothedDrive& with, const StabilisationOptions& options);

/// The smoothing that the steps of a drive show, if it counts. `states` has one estimate per segment; `sigma_theta` is
/// the least standard deviation of a step's direction of travel, rad.
///
/// A mean over times of variance V turns the images by V/2 times the yaw acceleration, and the direction of travel in
/// them by as much the other way. V is fitted, robustly, to what the model of the car leaves of the lateral
/// displacements. With yaw rates w, the scale comes out too small by about the share V/2 sum((dw/dt)^2) / sum(w^2).
std::optional<ImageSmoothing> FindImageSmoothing(std::span<const VehicleStep> steps,
                                                 const std::vector<PathSegment>& segments,
                                                 const std::vector<ScaleBelief>& states, double sigma_theta,
                                                 const StabilisationOptions& options);

}  // namespace turnscale

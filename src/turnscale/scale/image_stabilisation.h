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

/// Electronic image stabilisation turns the images to the mean of the camera's orientations over some time. If this
/// mean lags behind, or looks ahead, the camera seems to swing out by more, or less, the faster the car turns.
struct ImageLag {
  double found = 0;  ///< time by which the orientation of the images lags behind the car's, s; negative: ahead
  double found_sigma = 0;
};

/// If it looks back and ahead, the images begin to turn before the car does, and turn on after it.
struct ImageSmoothing {
  double variance = 0;        ///< of the times over which the mean is taken, s^2
  double variance_sigma = 0;  ///< standard deviation of `variance`, s^2
  double scale_error = 0;     ///< relative, of the scale, to first order: the images turn more slowly than the car
};

/// Acceptance of a stabilisation that a drive shows.
struct StabilisationOptions {
  /// A lag counts if it is more than this many standard deviations.
  double max_lag_deviation = 3;
  /// The sigmas of turns are conservative. So a lag also counts if it is more than this many standard deviations,
  double min_lag_deviation = 1.5;
  /// and the turns scatter less with it, by more than this many (ReductionOfScatter).
  double max_scatter_deviation = 3.5;
  /// It has to change the scale by more than this, relative.
  double min_scale_change = 0.05;
  /// Standard deviation of the lag of stabilised images, s.
  double lag_sigma = 0.2;
  /// Smoothing counts from this standard deviation of the times on, s: transients of the tyres and of the body look
  /// like a little smoothing.
  double min_smoothing = 0.3;
  /// Smoothing also has to be more than this many standard deviations.
  double max_smoothing_deviation = 4;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Whether an estimate with a lag (`with`) shows one: the lag counts, beside the estimate without.
std::optional<ImageLag> FindImageLag(const SmoothedDrive& without, const SmoothedDrive& with,
                                     const StabilisationOptions& options);

/// Whether the steps of a drive show that its images are smoothed. `states` has one estimate per segment.
///
/// A mean over times of variance V rotates the images by -V/2 times the yaw acceleration, beside the yaw of the car. V
/// is fitted, robustly, to what the model of the car leaves of the lateral displacements. With yaw rates w, the scale
/// comes out wrong by about the share V/2 sum(dw/dt^2) / sum(w^2).
std::optional<ImageSmoothing> FindImageSmoothing(std::span<const VehicleStep> steps,
                                                 const std::vector<PathSegment>& segments,
                                                 const std::vector<ScaleBelief>& states,
                                                 const StabilisationOptions& options);

}  // namespace turnscale

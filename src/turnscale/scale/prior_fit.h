// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/scale/drive_evidence.h"
#include "turnscale/scale/drive_smoothing.h"
#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// Priors of the car that a drive contradicts. They are wide in its estimate.
struct FreedPriors {
  bool yaw = false;  ///< of the camera-to-vehicle rotation
  bool lag = false;  ///< of the images: the turns show that they are stabilised
};

/// A drive smoothed with priors of the car that it does not contradict.
struct PriorFit {
  CarPrior given;
  FreedPriors freed;
  CarPrior car;  ///< `given` with the freed priors: the prior of `drive`
  /// Empty if no turn is usable and no height is given.
  std::optional<SmoothedDrive> drive;
};

/// Smooths a drive, again with wider priors while it contradicts those of `car`. A lag changes the direction of travel
/// in turns, as a wrong yaw does: where the turns show one, the prior of the yaw is tested anew.
PriorFit FitPriors(const DriveEvidence& evidence, const CarPrior& car, const ScaleEstimatorOptions& options);

/// The prior of a car whose height is not given.
CarPrior WithoutHeight(CarPrior car);

/// Relative error of the scale by a lag that the turns do not show for certain, beyond the sigma of the scale. 0 where
/// the prior allows for a lag. `fit.drive` must not be empty.
double ErrorByLag(const DriveEvidence& evidence, const PriorFit& fit, const ScaleEstimatorOptions& options);

/// The unsmoothed problem of a drive, with the turns that are selected at the start.
ScaleProblem StartingProblem(const DriveEvidence& evidence, const CarPrior& car, const ScaleEstimatorOptions& options);

/// Deviation of c from its prior, in standard deviations of the prior; 0 where c is known exactly.
double SlipDeviation(const SmoothedDrive& drive, const CarPrior& car);

}  // namespace turnscale

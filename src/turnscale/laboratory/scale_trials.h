// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "turnscale/laboratory/parallel_runs.h"
#include "turnscale/laboratory/scale_trial.h"

namespace turnscale {

/// Standard deviations of the errors of the car's given parameters.
struct CarErrors {
  double lever_arm = 0;  ///< metres
  double side_slip = 0;  ///< s^2/m
  double yaw = 0;        ///< of the camera, rad
};

/// The paper's Monte-Carlo evaluation of the absolute scale recovery (V-B 2, Table I, Fig. 10).
struct ScaleTrials {
  ScaleDriveOptions drive;
  /// Estimators that are compared on the same drives.
  std::vector<ScaleEstimatorSettings> estimators = std::vector<ScaleEstimatorSettings>(1);
  /// Drawn once a run and added to what each estimator is told. A side slip below 0 is told as 0.
  CarErrors told_wrong;
  int runs = 100;
  int jobs = 1;
  std::uint64_t seed = 1;
  RunProgress progress;
};

/// An error and the standard deviation that the estimator states for it; infinite where it states none.
struct StatedError {
  double error = 0;
  double sigma = std::numeric_limits<double>::infinity();
};

/// What one run gives.
struct ScaleTrial {
  ScaleErrors odometry;                ///< of the paper's noisy odometry (ScaleDrive::odometry), for comparison
  ScaleErrors adjusted;                ///< of the map that the recovery starts from
  std::vector<ScaleErrors> recovered;  ///< one for each estimator
  std::vector<char> converged;         ///< one flag for each: the recovery ended at its minimum
  std::vector<StatedError> length;     ///< of the logarithm of the path length, one for each
  std::vector<StatedError> side_slip;  ///< s^2/m, against what `estimators` are told before errors are added
};

/// One entry per run; every run has points and noise of its own. Same options, same bits for any number of jobs. Empty
/// where `progress` stopped it. Throws as MakeScaleDrive, PointOdometry and RecoverScale do.
std::vector<ScaleTrial> RunScaleTrials(const ScaleTrials& trials);

/// Mean and standard deviation over the runs.
struct MeanAndSpread {
  double mean = 0;
  double spread = 0;
};
MeanAndSpread MeanAndSpreadOf(const std::vector<double>& values);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"
#include "turnscale/run/drive_facts.h"
#include "turnscale/run/path_summary.h"

namespace turnscale {

/// Relative standard deviation of the measured path's length up to which the scale of a drive is called known.
inline constexpr double kLargestKnownSigma = 0.15;

/// How well the path of a drive is known in metres, and by what. Sigmas are relative; ScaleSummaryOf makes them
/// infinite while the scale is pending.
struct ScaleSummary {
  ScaleState state = ScaleState::kPending;
  std::string pending_reason;   ///< why there is no scale; empty where there is
  double path_sigma = 0;        ///< of the path's length
  double sigma = 0;             ///< the same without the parts of the path that are not measured
  double worst_sigma = 0;       ///< the largest along the path
  double worst_sigma_time = 0;  ///< where that is, seconds
  std::string sigma_reason;     ///< why a sigma is large (SigmaReason); empty where none is
  int turns_found = 0;
  int turns_used = 0;
  TurnTest turn_test;                             ///< consistency of the turns
  int calibration_windows = 0;                    ///< parts of turns in which the intrinsics were tested
  bool calibration_in_doubt = false;              ///< RefinedScale's
  bool calibration_agrees = true;                 ///< with them, if there are any
  std::optional<ShutterReadout> readout;          ///< of a rolling shutter, if these show one
  std::optional<ImageLag> image_lag;              ///< of stabilised images, by the turns or known beforehand
  std::optional<ImageSmoothing> image_smoothing;  ///< of stabilised images, if the turns show it

  bool is_metric() const { return state != ScaleState::kPending; }
  /// In metres, and exactly enough for lengths and speeds to be relied on.
  bool is_known() const { return is_metric() && sigma <= kLargestKnownSigma; }
};

/// `frames`: refined, with this scale; `path`: of them.
ScaleSummary ScaleSummaryOf(const DriveFacts& drive, const std::vector<FrameResult>& frames, const RefinedScale& scale,
                            const PathSummary& path);

/// Relative standard deviation of the path's length by the scale alone; infinite while that is pending.
double LengthSigma(const RefinedScale& scale);

/// That the trajectory of a run with a measured length is up to scale all the same, and why.
std::string UpToScaleText(const std::string& pending_reason);

/// What the drive tells of the car.
struct CarSummary {
  /// Empty while the scale is pending, or where the trajectory does not use it: single-turn scales.
  std::optional<CarRefinement> refined;
  /// Empty likewise, and where lever arm and camera height disagree.
  std::optional<CarEvidence> evidence;
  /// Yaw of the camera that the drive shows and the trajectory uses, rad, where it contradicts what was given.
  std::optional<double> contradicting_yaw;
};

CarSummary CarSummaryOf(const DriveFacts& drive, const RefinedScale& scale);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/camera/camera_model.h"
#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"
#include "turnscale/odometry/self_calibration.h"
#include "turnscale/run/drive_facts.h"
#include "turnscale/run/path_summary.h"
#include "turnscale/run/run_cost.h"
#include "turnscale/run/scale_summary.h"

namespace turnscale {

/// Results of a run, for summary.json and for the screen.
struct RunSummary {
  DriveFacts drive;
  FrameCounts frames;
  PathSummary path;
  ScaleSummary scale;
  CarSummary car;
  std::vector<std::string> warnings;  ///< all of the run, one line each
  RunCost cost;
};

/// The summary of a drive with its refined frames and their scale, without its cost. What the scale says of the
/// calibration has to be in pixels of full size. Its warnings are those that follow from the results.
RunSummary SummaryOf(DriveFacts drive, const std::vector<FrameResult>& frames, const RefinedScale& scale);

/// The longest parts of the missing path, which a summary names.
inline constexpr std::size_t kShownMissingParts = 5;

/// Largest relative standard deviation that is shown as a percentage. It is one of the logarithm of the scale: above
/// this it means nothing as a share.
inline constexpr double kLargestShownSigma = 1;

/// The summary as JSON; all but its "cost" is the same for the same input.
std::string SummaryJson(const RunSummary& summary);

/// The summary for people, a few lines.
std::string SummaryText(const RunSummary& summary);

/// The side slip of a car as a drive gives it, with what was assumed before the drive: "0.0041 +-0.0003 s^2/m, refined
/// from the default 0.0045 +-0.0020 s^2/m". Says so where the drive does not refine it, or would make it negative.
std::string SideSlipText(const CarRefinement& car, double assumed, double assumed_sigma);

/// The focal length of an estimated camera with its standard deviation, pixels: "600.0 +-6.0"; both focal lengths where
/// they differ, as those of pixels that are not square do, and their ratio, with its sigma where it is estimated.
std::string FocalLengthText(const CameraModel& camera);

/// "pinhole", "radial-tangential" or "equidistant".
const char* LensModelName(LensModel lens);

/// An estimated camera as a file that ReadCameraFile reads, with its standard deviations. `readout`: what the whole
/// drive says of a rolling shutter; if it is empty and the drive has turns that test it, there is none.
std::string FoundCameraText(const FoundCamera& found, const std::optional<ShutterReadout>& readout, bool is_tested);

}  // namespace turnscale

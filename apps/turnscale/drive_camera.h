// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "drive_source.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/self_calibration.h"

namespace CLI {
class App;
}

namespace turnscale {

/// Adds the options that name, assume or refine the camera.
void AddCameraOptions(CLI::App& command, ImageArguments& arguments);

/// Estimates the camera from the images where it is not given or is to be refined (`--camera-refine`), and puts it
/// into `images`. Returns what was found; nothing where the camera is as given, where
/// the drive does not tell it, which a warning says, and where the user interrupts. `mask` as in CalibrateFromDrive.
std::optional<FoundCamera> EstimateCamera(const ImageArguments& arguments, DriveImages& images,
                                          const OdometryOptions& options, const cv::Mat& mask = {});

}  // namespace turnscale

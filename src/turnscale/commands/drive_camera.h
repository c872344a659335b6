// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "turnscale/commands/command_hooks.h"
#include "turnscale/commands/drive_source.h"
#include "turnscale/odometry/self_calibration.h"
#include "turnscale/run/settings.h"

namespace turnscale {

/// Field of view along the longer side of the image, degrees, from which the estimation of the intrinsics starts by
/// default.
constexpr double kUsualView = 70;

/// The camera as estimated from the images.
struct CameraEstimate {
  std::optional<FoundCamera> found;  ///< nothing where the camera is as given or the drive does not determine it
  std::string warning;               ///< what to know about it, one line; may be empty
};

/// Estimates the camera from the images where it is not given or is to be refined (`--camera-refine`), and puts it
/// into `images`. Where the drive does not determine it, an assumed one. `on_pass` is told what is done before each
/// pass over the images, with its number. Throws InputError where there is nothing to refine, Interruption.
CameraEstimate EstimateCamera(
    const ImageArguments& arguments, DriveImages& images, const Settings& settings, const CommandHooks& hooks,
    const std::function<void(const std::string&)>& on_pass = [](const std::string&) {});

}  // namespace turnscale

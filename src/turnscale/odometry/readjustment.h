// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "turnscale/mapping/local_bundle_adjustment.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/mount_calibration.h"

namespace turnscale {

/// Keyframes that have been adjusted once more.
struct ReadjustedKeyframes {
  int first = 0;
  int end = 0;           ///< the one after the last; those that follow have moved with it
  int final_before = 0;  ///< keyframes before this one will not be adjusted again during the drive
};

/// A copy of the latest part of a map, to be adjusted in one large window, usually in the background. The local windows
/// during the drive had fewer observations and a less accurate lens correction.
struct ReadjustmentWork {
  double radial_correction = 0;  ///< of the window's pixels
  int first = 0;                 ///< the first of the keyframes
  int end = 0;                   ///< the one after the last
  WindowProblem window;
  MountCalibration mount;           ///< the camera-to-vehicle rotation so far
  std::vector<Keyframe> unlearned;  ///< keyframes before `end` that it has not learned from, without observations
};

/// What has become of it.
struct ReadjustmentResult {
  double radial_correction = 0;         ///< as of the work
  int first = 0;                        ///< as of the work
  int end = 0;                          ///< as of the work
  std::optional<WindowProblem> window;  ///< adjusted; empty where it contains NaN
  MountCalibration mount;               ///< has learned from the keyframes before `end`
};

/// The keyframes of the map from `first` on. `mount` is the camera-to-vehicle rotation so far.
ReadjustmentWork WorkToReadjust(const LocalBundleOptions& options, const Map& map, const MountCalibration& mount,
                                int first);

/// Adjusts the window, and updates the camera-to-vehicle rotation.
ReadjustmentResult Readjusted(const LocalBundleOptions& options, ReadjustmentWork work);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/pinhole.h"
#include "turnscale/mapping/intrinsics_change.h"
#include "turnscale/mapping/intrinsics_estimate.h"
#include "turnscale/mapping/shutter_readout.h"
#include "turnscale/odometry/self_calibration.h"

namespace turnscale {

/// What a pass over the images of a drive tells of the camera that it was run with.
struct PassFindings {
  IntrinsicsEstimate estimate;  ///< the change of that camera
  double radius = 0;            ///< from the principal point, up to which the windows show the lens, pixels
  int windows = 0;
  std::optional<ShutterReadout> readout = std::nullopt;  ///< of a rolling shutter, if they show or know one
};

/// What the passes so far have found, and the camera for the next one.
struct CameraOfPasses {
  FoundCamera found;
  CameraModel next;
  bool is_last = false;  ///< no other pass is needed, or left
};

/// By how much a pass's thresholds in pixels are wider than usual: with a wrong lens, points near the edge, which show
/// most of it, fit worst. 1 from some pass on. `pass`: from 0.
double LooseBy(int pass);

/// The change of pinhole that leads from one to another; the ratio of the focal lengths is that of fx.
IntrinsicsChange::Vector ChangeBetween(const Pinhole& from, const Pinhole& to);

/// What follows from the pass with `camera` that was the last of so many. Nothing where the change of the camera leads
/// to none: a distortion that folds back, or windows that show hardly anything of the lens.
std::optional<CameraOfPasses> CameraFrom(const SelfCalibrationOptions& options, const CameraModel& camera,
                                         const PassFindings& findings, int passes);

}  // namespace turnscale

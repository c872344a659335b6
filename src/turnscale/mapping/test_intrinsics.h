// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/intrinsics_evidence.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// A change without the correction's higher terms.
inline IntrinsicsChange::Vector Change(double log_focal, double centre_x, double centre_y, double correction) {
  IntrinsicsChange::Vector change;
  change << log_focal, centre_x, centre_y, correction, 0, 0;
  return change;
}

/// The camera of a map whose lens has no distortion but the correction that is applied.
inline CameraModel CameraOf(const Map& map, double radial_correction = 0) {
  CameraModel camera;
  camera.pinhole = map.pinhole;
  camera.radial_correction = radial_correction;
  return camera;
}

}  // namespace turnscale

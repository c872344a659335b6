// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/camera/camera_model.h"

namespace turnscale {

/// How long a rolling shutter takes from the first row of the image as it was stored to the last one, seconds; below 0
/// if it begins with the last one.
struct ShutterReadout {
  double seconds = 0;
  double sigma = 0;
  ReadDirection direction = {};  ///< from the first row to the last one, in the image as it is used
  bool is_corrected = false;     ///< in the poses that go with it
};

/// The readout that a camera is known to have (CameraModel), if it is known; seconds.
struct GivenReadout {
  double seconds = 0;
  double sigma = 0;
};
inline std::optional<GivenReadout> ReadoutOf(const CameraModel& camera) {
  if (!camera.is_readout_known()) return std::nullopt;
  return GivenReadout{camera.readout, camera.readout_sigma};
}

}  // namespace turnscale

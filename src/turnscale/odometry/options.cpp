// SPDX-License-Identifier: MIT
#include "turnscale/odometry/options.h"

#include <cmath>

#include "turnscale/base/error.h"

namespace turnscale {

void VehicleOptions::Check() const {
  if (lever_arm && !(*lever_arm > 0 && std::isfinite(*lever_arm)))
    throw InputError("vehicle.lever_arm: has to be a positive number of metres");
  if (!(side_slip >= 0 && side_slip < 1)) throw InputError("vehicle.side_slip: has to be in 0...1 s^2/m");
  if (!(side_slip_sigma >= 0 && side_slip_sigma < 1))
    throw InputError("vehicle.side_slip_sigma: has to be in 0...1 s^2/m");
  if (!(std::abs(vehicle_from_camera.norm() - 1) < 1e-6))
    throw InputError("vehicle.vehicle_from_camera: has to be a rotation");
}

void KeyframeOptions::Check() const {
  if (!(min_rotation_deg > 0)) throw InputError("keyframes.min_rotation_deg: has to be positive");
  if (!(min_parallax_deg > 0)) throw InputError("keyframes.min_parallax_deg: has to be positive");
  if (!(min_tracked_share >= 0 && min_tracked_share <= 1))
    throw InputError("keyframes.min_tracked_share: has to be in 0...1");
  if (!(max_growth > 1)) throw InputError("keyframes.max_growth: has to be above 1");
}

void TrackingOptions::Check() const {
  if (min_inliers < 6) throw InputError("tracking.min_inliers: has to be at least 6");
  if (!(min_inlier_share >= 0 && min_inlier_share <= 1))
    throw InputError("tracking.min_inlier_share: has to be in 0...1");
  if (memory_keyframes < 1) throw InputError("tracking.memory_keyframes: has to be at least 1");
  if (max_lost_frames < 0) throw InputError("tracking.max_lost_frames: must not be negative");
}

void ScaleOptions::Check() const {
  recovery.Check();
  if (!(drift_per_root_metre >= 0)) throw InputError("scale.drift_per_root_metre: must not be negative");
  if (!(gap_sigma > 0)) throw InputError("scale.gap_sigma: has to be positive");
  if (!(max_sigma_ratio > 0)) throw InputError("scale.max_sigma_ratio: has to be positive");
}

void OdometryOptions::Check() const {
  vehicle.Check();
  corners.Check();
  flow.Check();
  alignment.Check();
  initialization.Check();
  pose.Check();
  keyframes.Check();
  landmarks.Check();
  local_bundle.Check();
  lens.Check();
  tracking.Check();
  turns.Check();
  pooled_scale.Check();
  scale.Check();
  if (threads < 1) throw InputError("threads: has to be at least 1");
}

}  // namespace turnscale

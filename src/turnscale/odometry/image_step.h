// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/features/optical_flow.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/odometry/feature_tracks.h"
#include "turnscale/odometry/motion_model.h"

namespace turnscale {

/// The last image in which all landmarks were tracked, and the next one; for the time of a call, as it refers to both.
struct ImageStep {
  const FlowImage& last_image;
  const RigidTransform& last_from_world;         ///< the camera's pose in it
  double last_time = 0;                          ///< of it, seconds
  const std::vector<FeatureTrack>& tracks;       ///< what the last image shows
  const std::vector<FeatureTrack>& lost_tracks;  ///< landmarks seen recently that are not in it
  const MotionModel& motion;                     ///< up to the last measured pose
  bool has_stood = false;                        ///< whether the camera had stood still for a while by then
  const FlowImage& image;                        ///< the next one
  double time = 0;                               ///< of it, seconds
};

}  // namespace turnscale

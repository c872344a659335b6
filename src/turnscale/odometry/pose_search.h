// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "turnscale/camera/camera_model.h"
#include "turnscale/features/optical_flow.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/feature_tracks.h"
#include "turnscale/odometry/motion_model.h"

namespace turnscale {

/// Where the camera is after a gap, `time` in seconds, by what landmarks look like: poses that the car may have reached
/// since the last measured one are compared with the image much reduced, and the best ones aligned from coarse to fine.
/// `tracks` are what the last image shows; those without a depth are left out. The result is correct within a few
/// pixels; empty where no pose explains the image.
std::optional<RigidTransform> SearchPose(const Map& map, const CameraModel& camera, const FlowImage& last_image,
                                         const FlowImage& image, const std::vector<FeatureTrack>& tracks,
                                         const MotionModel& motion, double time);

/// The same where the pose is roughly known: only `initial` is aligned. `last_from_world`: the pose of the last image.
std::optional<RigidTransform> AlignPose(const Map& map, const CameraModel& camera, const FlowImage& last_image,
                                        const FlowImage& image, const std::vector<FeatureTrack>& tracks,
                                        const RigidTransform& last_from_world, const RigidTransform& initial);

}  // namespace turnscale

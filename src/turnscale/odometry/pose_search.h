// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/image_step.h"

namespace turnscale {

/// The camera's pose in the next image after a gap, by what landmarks look like: poses that the car may have reached
/// since the last measured one are compared with the image much reduced, and the best ones aligned from coarse to fine.
/// Tracks without a depth are left out. The result is correct within a few pixels; empty where no pose explains the
/// image.
std::optional<RigidTransform> SearchPose(const Map& map, const ImageStep& step);

/// The same where the pose is roughly known: only `initial` is aligned.
std::optional<RigidTransform> AlignPose(const Map& map, const ImageStep& step, const RigidTransform& initial);

}  // namespace turnscale

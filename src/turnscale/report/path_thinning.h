// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Places of at most about `most` poses, ascending, with the first, the last and all in `kept`: as many per metre, per
/// radian of turning and per second as the drive's length, turning and duration allow, so that curves stay round and a
/// standing car has points too. All places if the trajectory has no more than `most` poses.
std::vector<int> ThinPath(const Trajectory& trajectory, int most, const std::vector<int>& kept = {});

}  // namespace turnscale

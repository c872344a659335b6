// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Associated estimated and ground-truth poses.
struct PosePair {
  int estimate_index = 0;  ///< place in the estimated trajectory
  int truth_index = 0;     ///< place in the true trajectory
  double time = 0;         ///< seconds, the estimate's; the frame's number where it has no times
  RigidTransform estimate;
  RigidTransform truth;
};

/// In the order of time.
using PosePairs = std::vector<PosePair>;

struct AssociationOptions {
  /// Two poses belong together when their times differ by no more than this, seconds. Unset: half the median interval
  /// of the truth and at most 0.02 s, in which a car at 50 km/h moves by 0.28 m.
  std::optional<double> tolerance;
};

/// Pairs each estimated pose with the true pose nearest in time; a true pose is used once.
/// Throws InputError when a trajectory is empty or its times go back, or when nothing pairs.
PosePairs AssociateByTime(const Trajectory& estimate, const Trajectory& truth, const AssociationOptions& options = {});

/// How many poses each of two trajectories has in the span of time that both cover.
struct CommonPoses {
  int estimated = 0;
  int in_truth = 0;
};
/// The times must not decrease.
CommonPoses PosesInCommonTime(const Trajectory& estimate, const Trajectory& truth);

/// Pairs the poses one by one, for trajectories of which one has no times.
/// Throws InputError when a trajectory is empty or their lengths differ.
PosePairs AssociateByFrame(const Trajectory& estimate, const Trajectory& truth);

/// Path length along the true (estimated) positions of the pairs, metres.
double TruePathLength(const PosePairs& pairs);
double EstimatedPathLength(const PosePairs& pairs);

}  // namespace turnscale

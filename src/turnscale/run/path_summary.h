// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "turnscale/frames/seen_images.h"
#include "turnscale/odometry/results.h"
#include "turnscale/run/impossible_direction.h"
#include "turnscale/run/impossible_motion.h"
#include "turnscale/run/missing_path.h"
#include "turnscale/run/uncertain_scale.h"
#include "turnscale/run/view_change.h"

namespace turnscale {

/// The frames of a drive by what became of them.
struct FrameCounts {
  int total = 0;
  int tracked = 0;
  int repeated = 0;
  int bridged = 0;
  int initializing = 0;
  int keyframes = 0;
};

FrameCounts FrameCountsOf(const std::vector<FrameResult>& frames);

/// The time before a path begins, if the car may have moved in it.
struct UnmappedBeginning {
  MissingPart part;
  double length = 0;  ///< that the path may lack, in the unit of the poses
  bool is_most_of_drive = false;
};

/// The path of a drive, and what is doubtful in it. Lengths are in metres where the scale is known, else in the
/// arbitrary unit of the poses.
struct PathSummary {
  double seconds = 0;                        ///< from the first frame to the last
  double distance = 0;                       ///< its length
  std::vector<MissingPart> missing;          ///< where it is not measured
  double missing_distance = 0;               ///< part of `distance` that lies there, interpolated or extrapolated
  std::vector<ImpossibleMotion> impossible;  ///< parts that no car has driven: by its speed
  std::vector<ImpossibleDirection> impossible_directions;  ///< the same, by its direction
  std::optional<UncertainScale> uncertain;                 ///< parts whose scale is hardly known
  std::vector<FrozenPart> frozen;                          ///< parts in which the picture is frozen
  std::optional<UnmappedBeginning> beginning;  ///< empty if the path begins with the drive, or the car waits
};

/// `frames`: refined. `repeated`: those that were taken for repeated images online, ascending. `seen`: the images
/// before the map. `lever_arm`: metres; 0 if it is unknown.
PathSummary PathSummaryOf(const std::vector<FrameResult>& frames, const std::vector<int>& repeated = {},
                          const SeenImages& seen = {}, double lever_arm = 0);

}  // namespace turnscale

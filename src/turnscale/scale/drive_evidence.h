// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/scale/scale_evidence.h"
#include "turnscale/scale/turn_selection.h"

namespace turnscale {

/// What the steps of a drive show, whatever car they are of.
struct DriveEvidence {
  std::vector<PathSegment> segments;
  std::vector<SegmentEvidence> of_segments;  ///< one per segment
  MeanTurnDirection of_turns;
  bool has_sparse_steps = false;  ///< some are not VehicleStep::dense

  bool has_turns() const;
};

DriveEvidence EvidenceOfDrive(const std::vector<VehicleStep>& steps, const PathSegmentOptions& segments,
                              const EvidenceOptions& options);

}  // namespace turnscale

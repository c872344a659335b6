// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "turnscale/scale/scale_evidence.h"
#include "turnscale/scale/turn_selection.h"

namespace turnscale {

/// What the steps of a drive show, whatever car they are of.
struct DriveEvidence {
  std::span<const VehicleStep> steps;  ///< those of the drive, which have to outlive it
  std::vector<PathSegment> segments;
  std::vector<SegmentEvidence> of_segments;  ///< one per segment
  MeanTurnDirection of_turns;
  bool has_sparse_steps = false;  ///< some are not VehicleStep::dense

  bool has_turns() const;
};

DriveEvidence EvidenceOfDrive(const std::vector<VehicleStep>& steps, const PathSegmentOptions& segments,
                              const EvidenceOptions& options);

}  // namespace turnscale

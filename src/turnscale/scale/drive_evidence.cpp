// SPDX-License-Identifier: MIT
#include "turnscale/scale/drive_evidence.h"

#include <algorithm>

namespace turnscale {

bool DriveEvidence::has_turns() const { return std::ranges::any_of(segments, &PathSegment::turning); }

DriveEvidence EvidenceOfDrive(const std::vector<VehicleStep>& steps, const PathSegmentOptions& segments,
                              const EvidenceOptions& options) {
  DriveEvidence evidence;
  evidence.steps = steps;
  evidence.segments = SplitIntoSegments(steps, segments);
  evidence.of_segments = GatherEvidence(steps, evidence.segments, options);
  evidence.of_turns = MeanDirectionOfTurns(evidence.of_segments, options);
  evidence.has_sparse_steps = !std::ranges::all_of(steps, &VehicleStep::dense);
  return evidence;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "turnscale/scale/scale_evidence.h"

namespace turnscale {

/// Mean direction of travel that the turns of a drive show by themselves, rad, slip aside.
struct MeanTurnDirection {
  double mean = 0;
  double variance = std::numeric_limits<double>::infinity();  ///< of the mean; infinite if no turn shows one
};

MeanTurnDirection MeanDirectionOfTurns(const std::vector<SegmentEvidence>& gathered, const EvidenceOptions& options);

/// The state with which turns are selected first: the prior's constants, its direction of travel combined with that of
/// the turns, since a wrong camera rotation makes turns seem unusable.
DriveState StartingState(const CarPrior& car, const MeanTurnDirection& turns);

/// The evidence of a drive without the turns in which the lever arm is not observable.
struct TurnSelection {
  std::vector<SegmentEvidence> evidence;  ///< SegmentEvidence::turn is empty where a turn is left out
  /// Of the turns that are left: single-turn log-scale and absolute angle (rad).
  std::vector<std::pair<double, double>> log_scales;
};

/// Leaves out turns that are not usable at `state` (WhyUnusable).
TurnSelection SelectTurns(const std::vector<SegmentEvidence>& gathered, const CarPrior& car, const DriveState& state,
                          const EvidenceOptions& options);

/// Initial value of the log-scale: the median of the single-turn scales, or of the scales that a known height gives on
/// the road. Empty where there is neither.
std::optional<double> StartingLogScale(const TurnSelection& selection, const CarPrior& car);

}  // namespace turnscale

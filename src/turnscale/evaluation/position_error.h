// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/evaluation/association.h"
#include "turnscale/evaluation/statistics.h"
#include "turnscale/geometry/similarity.h"

namespace turnscale {

/// Distances between the true positions and the estimated ones after an alignment (absolute trajectory error, ATE).
struct PositionErrors {
  Similarity truth_from_estimate;  ///< the alignment
  ErrorStatistics distance;        ///< metres; rms is what is called the ATE
};

/// Without alignment: only the first poses are laid on each other, so that the two files may start from different
/// world frames. Nothing changes for files that both start at identity.
PositionErrors MeasurePositionsFromFirstPose(const PosePairs& pairs);

/// After the alignment of all positions in the sense of least squares.
/// Throws InputError when the positions do not determine it (see AlignPoints).
PositionErrors MeasureAlignedPositions(const PosePairs& pairs, AlignmentModel model);

}  // namespace turnscale

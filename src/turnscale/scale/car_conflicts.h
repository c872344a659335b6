// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <optional>
#include <span>

#include "turnscale/scale/scale_evidence.h"
#include "turnscale/scale/scale_filter.h"

namespace turnscale {

/// The given camera height differs from the one that the turns of the drive show with the given lever arm: one of the
/// two lengths is wrong.
struct HeightConflict {
  double given = 0;  ///< metres
  double given_sigma = 0;
  double found = 0;  ///< from the turns, without the given height, metres
  double found_sigma = 0;
  /// With the given height the turns are inconsistent (TurnTest::contradicted), without it they are consistent: it is
  /// not used.
  bool contradicts_turns = false;

  /// Relative standard deviation of the scale, while either of the lengths may be the wrong one: the root mean square
  /// of its distances from what the two imply. It is between them, or follows the lever arm alone.
  double scale_sigma() const { return std::sqrt(contradicts_turns ? 0.5 : 0.25) * std::abs(std::log(found / given)); }
};

/// The yaw of Q differs from the one that straights and turns show: Q is not that of this camera on this car.
struct YawConflict {
  double given_sigma = 0;  ///< of the yaw error according to the prior, rad
  double found = 0;        ///< yaw error without that prior, rad; as CarRefinement::yaw_error
  double found_sigma = 0;
};

/// The turns show a side slip that is far from its prior, although they agree with each other: something else may act
/// like slip, such as wrong times.
struct SlipConflict {
  double given = 0;  ///< c of the prior, s^2/m
  double given_sigma = 0;
  double found = 0;  ///< s^2/m; may be negative
};

/// Whether the height that the turns give with the lever arm differs from the given one by more than `max_deviation`
/// standard deviations. `posterior` is the belief at the end of the drive. The given height is taken out of it, an
/// update with minus its variance; errors that it shares with L and c in the prior do not count as a difference.
/// To first order, about an estimate that a wrong height bends: what the turns show without it, and
/// `contradicts_turns`, are left to the caller.
std::optional<HeightConflict> CompareHeight(const ScaleBelief& posterior, const CarPrior& car, double max_deviation);

/// The direction of travel that a turn shows by itself, linearised at the estimate, and its robust weight there.
struct WeightedDirection {
  Measurement measurement;
  double weight = 1;
};

/// Whether the directions of travel that turns show by themselves contradict the one that all else gives: the posterior
/// without them. `shared_sigma` (rad): the part of their variances that is taken for an error of all turns in common.
bool TurnsContradictYaw(std::span<const WeightedDirection> directions, const ScaleBelief& posterior,
                        double shared_sigma, double max_deviation);

/// Whether the prior of the yaw contradicts the drive, which alone has the posterior's information less the prior's.
bool ContradictsYaw(const ScaleBelief& posterior, double prior_sigma, double max_deviation);

}  // namespace turnscale

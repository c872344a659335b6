// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turnscale/kinematics/turn_detector.h"
#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// Online scale: an iterated extended Kalman filter over the completed segments and the current turn.
/// Work per step is linear in the steps of no segment yet: those of the turn under way, or of a straight up to its
/// longest segment; it does not depend on the length of the drive before them.
class LiveScale {
 public:
  LiveScale(const CarPrior& car, const ScaleEstimatorOptions& options);

  /// Takes the next step. Returns whether it ended a turn.
  bool Add(const VehicleStep& step);

  /// The current belief, with the evidence of the current turn; empty until the scale is known to
  /// ScaleEstimatorOptions::max_sigma. A loss of tracking widens its sigma, also beyond that.
  std::optional<ScaleBelief> Now() const;

  /// The camera-to-vehicle rotation has changed: directions of travel are larger by `angle` rad from now on.
  void TurnCamera(double angle);

  /// Within a usable turn.
  bool turning() const { return turning_; }

  /// Whether the turn that ended last was usable.
  bool used_last_turn() const { return used_last_turn_; }

  /// The latest steps show the height above the road, and it is known in metres.
  bool on_road() const { return on_road_; }

 private:
  enum class End { kTurn, kStraight, kPartOfStraight };
  /// The pending steps up to `last` become a segment.
  void Commit(int last, End end);
  /// `road_part`: as PathSegment::road_part.
  void TakeDirection(std::span<const VehicleStep> steps, bool road_part, ScaleBelief& belief) const;
  void Advance(std::span<const VehicleStep> steps, ScaleBelief& belief) const;
  /// Of the belief, or a guess before it knows them; empty if the steps have no length or no duration.
  std::optional<double> MetresPerUnit(std::span<const VehicleStep> steps, const ScaleBelief& belief) const;
  /// With the height above the road. Returns whether the steps show it.
  bool TakeRoad(std::span<const VehicleStep> steps, ScaleBelief& belief) const;
  bool KnowsHeight(const ScaleBelief& belief) const;
  struct TurnUpdate {
    ScaleBelief belief;  ///< with what the turn shows
    bool used = false;   ///< also of the scale: the turn is usable
  };
  TurnUpdate WithTurn(const ScaleBelief& belief, std::span<const VehicleStep> steps) const;

  CarPrior car_;
  ScaleEstimatorOptions options_;
  TurnDetector detector_;
  int steps_ = 0;                     ///< taken so far
  std::vector<VehicleStep> pending_;  ///< those of no segment yet
  bool road_part_ = false;            ///< the pending steps continue a straight of which road parts have been cut
  ScaleBelief belief_;                ///< at the end of the last segment
  bool started_ = false;              ///< a turn, or the road with a known height, has given the scale
  ScaleBelief now_;
  bool known_ = false;
  bool turning_ = false;
  bool used_last_turn_ = false;
  bool on_road_ = false;
};

}  // namespace turnscale

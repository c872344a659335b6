// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turnscale/kinematics/turn_detector.h"
#include "turnscale/scale/scale_estimator.h"
#include "turnscale/scale/scale_state.h"

namespace turnscale {

/// Whether a step has ended a turn, and whether the turn shows the scale.
enum class TurnEnd { kNone, kNotUsed, kUsed };

/// What is known of the scale at a step.
struct LiveReading {
  ScaleBelief belief;  ///< with the evidence of the turn under way
  /// Observed: the step is within a usable turn. From the road: the latest steps show the height above it, which is
  /// known in metres. Else held.
  ScaleState state = ScaleState::kHeld;
};

/// Online scale: an iterated extended Kalman filter over the completed segments and the current turn.
/// Work per step is linear in the steps of no segment yet: those of the turn under way, or of a straight up to its
/// longest segment; it does not depend on the length of the drive before them.
class LiveScale {
 public:
  LiveScale(const CarPrior& car, const ScaleEstimatorOptions& options);

  /// Takes the next step.
  TurnEnd Add(const VehicleStep& step);

  /// At the latest step. Empty until the scale is known to ScaleEstimatorOptions::max_sigma. A loss of tracking widens
  /// its sigma, also beyond that.
  const std::optional<LiveReading>& Now() const { return now_; }

  /// The camera-to-vehicle rotation has changed: directions of travel are larger by `angle` rad from now on.
  void TurnCamera(double angle);

 private:
  /// The pending steps up to `last` become a straight, a part of one that goes on, or a turn, which may be usable.
  void EndStraight(int last);
  void CutStraight(int last);
  TurnEnd EndTurn(int last);
  /// Takes the pending steps up to `last` away; none if they are all later. The belief passes over them, with the
  /// height that they show.
  std::vector<VehicleStep> PassOver(int last);
  /// Renews the reading: the belief and what the pending steps add to it.
  void UpdateReading();
  /// At the end of a turn, the provisional belief becomes the belief, if there is no better one.
  void KeepProvisional(std::span<const VehicleStep> turn);
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
  bool road_part_ = false;            ///< the pending steps continue a straight of which a road part has been cut
  ScaleBelief belief_;                ///< at the end of the last segment
  /// With the usable part of the first turn, from which the reading is: the turn may get too fast to be used.
  std::optional<ScaleBelief> provisional_;
  bool started_ = false;  ///< a turn, or the road with a known height, has given the scale
  bool on_road_ = false;  ///< ScaleState::kFromRoad, also within a turn
  std::optional<LiveReading> now_;
};

}  // namespace turnscale

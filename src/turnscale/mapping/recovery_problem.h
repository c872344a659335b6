// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/bundle/bundle_problem.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// Keyframes first..last, between which tracking was never lost.
struct KeyframeRange {
  int first = 0;
  int last = 0;
};

/// Cuts the keyframes where tracking was lost: nothing that is seen before is seen after.
std::vector<KeyframeRange> SplitAtGaps(const Map& map);

/// The bundle problem (26), (27) of a range of keyframes, and where its parts stand in the map.
struct RecoveryProblem {
  BundleProblem bundle;
  std::vector<int> keyframe;          ///< of each camera; those of the range come first, in their order
  std::vector<int> landmark;          ///< of each point
  std::vector<int> left_out;          ///< the other landmarks in use
  std::vector<int> points_of_camera;  ///< how many points each camera sees
};

/// All keyframes of the range, the first one fixed; earlier keyframes that see the same landmarks, fixed too, so that
/// these stay where the earlier part of the map has them; valid landmarks with two observations among all of these, one
/// of them within the range.
RecoveryProblem MakeRecoveryProblem(const Map& map, const KeyframeRange& range, double pixel_sigma);

/// Adds the constraint (28) that keyframe j-1 and j are `distance` metres apart.
void HoldStep(int step, double distance, const KeyframeRange& range, RecoveryProblem& problem);

/// Adds it as a measurement of that relative standard deviation.
void MeasureStep(int step, double distance, double sigma, const KeyframeRange& range, RecoveryProblem& problem);

/// Writes the adjusted points back.
void WriteBackLandmarks(const RecoveryProblem& problem, Map& map);

}  // namespace turnscale

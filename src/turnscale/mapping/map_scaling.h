// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/mapping/map.h"

namespace turnscale {

/// Scale of the map from a turning region. Step j leads from keyframe j-1 to keyframe j.
struct TurnScale {
  int first_step = 0;
  int last_step = 0;
  double factor = 1;  ///< metres per unit that the map has now
  /// The paper's per-frame observer: metres of each step, first_step..last_step; not positive for steps without an
  /// observation. Empty for the line fit: factor times the map's lengths, so that the turn keeps its shape.
  std::vector<double> distances;
  /// Relative standard deviation of the factor: the turn's length is a measurement that the adjustment weighs against
  /// the images, independent of other turns' (of smoothed scales, which share what all turns say, that is an
  /// approximation). 0: it is held, as the paper does.
  double sigma = 0;
};

/// Camera centres of keyframes `first`... of the map, in W.
std::vector<Eigen::Vector3d> KeyframeCentres(const Map& map, int first = 0);

/// Moves keyframe centres, rotations staying as they are.
void SetKeyframeCentres(const std::vector<Eigen::Vector3d>& centres, Map& map);

/// Factor of each step (index is its later keyframe): a turn's own within the turn; between turns going evenly in the
/// logarithm over the path, but at a loss of tracking (`gaps`: the bridged steps) all at once; before the first and
/// after the last turn that turn's. Turns in the order of time, at least one.
std::vector<double> StepFactors(const std::vector<Eigen::Vector3d>& centres, const std::vector<TurnScale>& turns,
                                const std::vector<int>& gaps = {});

/// Centres with all steps made longer by their factors. The unit of the world changes: keyframe 0 moves about W's
/// origin, by the factor of the first step.
std::vector<Eigen::Vector3d> ScaleSteps(const std::vector<Eigen::Vector3d>& centres,
                                        const std::vector<double>& step_factors);

/// Factor at each keyframe, by which the lengths around it grew: 1 before `first`, the path's over two steps on either
/// side after it. `fallback` (a factor for each step) stands where the camera did not move.
std::vector<double> KeyframeFactors(const std::vector<Eigen::Vector3d>& before,
                                    const std::vector<Eigen::Vector3d>& after, int first,
                                    const std::vector<double>& fallback);

/// The keyframe that saw a landmark from closest by. Its observations must not be empty.
int ClosestObserver(const Landmark& landmark, const std::vector<Eigen::Vector3d>& centres);

/// Valid landmarks that somebody has seen.
std::vector<int> LandmarksInUse(const Map& map);

/// Moves landmarks with the keyframe that saw them from closest by, whose view of them changes fastest; their distance
/// from there grows by that keyframe's factor. Where that is a keyframe before `first` they stay.
void CarryLandmarks(const std::vector<Eigen::Vector3d>& before, const std::vector<Eigen::Vector3d>& after, int first,
                    const std::vector<double>& keyframe_factors, const std::vector<int>& landmarks, Map& map);

/// Makes the steps longer by their factors, and the landmarks go with them.
void ScaleMap(const std::vector<double>& step_factors, Map& map);

}  // namespace turnscale

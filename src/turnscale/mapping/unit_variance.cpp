// SPDX-License-Identifier: MIT
#include "turnscale/mapping/unit_variance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

// Median of the squared length of a vector of two normal variables of variance 1.
constexpr double kMedianSquare = 1.386;

// Under which a landmark is seen from two keyframes, as pixels at the image's centre.
double AngleInPixels(const Map& map, const Landmark& landmark, int from, int to) {
  const Eigen::Vector3d a = (Centre(map.keyframes[from]) - landmark.position).normalized();
  const Eigen::Vector3d b = (Centre(map.keyframes[to]) - landmark.position).normalized();
  return map.pinhole.fx * std::asin(std::min(1.0, a.cross(b).norm()));
}

}  // namespace

std::optional<double> UnitVariance(const Map& map, int keyframe) {
  if (keyframe <= 0 || map.keyframes[keyframe].after_gap) return std::nullopt;
  // Information of each landmark, for pixels with a variance of 1, times the keyframes that it spans: neighbouring
  // keyframes share landmarks, and over that span the unit changes by its variance once.
  double spanned = 0;
  std::vector<double> errors;
  for (const KeyframeObservation& seen : map.keyframes[keyframe].observations) {
    const Landmark& landmark = map.landmarks[seen.landmark];
    if (!landmark.valid) continue;
    const int first = landmark.observations.front().keyframe;
    const int last = landmark.observations.back().keyframe;
    const double before = AngleInPixels(map, landmark, first, keyframe);
    const double after = AngleInPixels(map, landmark, keyframe, last);
    if (!(before > 0 && after > 0)) continue;
    // Each angle has the errors of two pixels.
    const double information = 0.5 / (1 / (before * before) + 1 / (after * after));
    spanned += information * (last - first);
    for (const LandmarkObservation& observation : landmark.observations) {
      const Eigen::Vector3d x = map.keyframes[observation.keyframe].camera_from_world * landmark.position;
      const double error = (map.pinhole.Project(x) - observation.pixel).squaredNorm();
      if (std::isfinite(error)) errors.push_back(error);
    }
  }
  if (errors.empty()) return std::numeric_limits<double>::infinity();
  return Quantile(std::move(errors), 0.5) / kMedianSquare / spanned;
}

}  // namespace turnscale

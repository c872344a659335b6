// SPDX-License-Identifier: MIT
#include "turnscale/mapping/unit_variance.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "turnscale/base/quantiles.h"
#include "turnscale/geometry/triangulation.h"
#include "turnscale/mapping/landmarks.h"

namespace turnscale {
namespace {

bool IsWithinMap(const Map& map, int keyframe, int following) {
  if (keyframe <= 0 || keyframe + following >= CountKeyframes(map)) return false;
  for (int k = keyframe; k <= keyframe + following; ++k)
    if (map.keyframes[k].after_gap) return false;
  return true;
}

// Angle at which two keyframes are seen from a landmark, as pixels at the image's centre.
double AngleInPixels(const Map& map, const Landmark& landmark, int from, int to) {
  return map.camera.pinhole.fx *
         ParallaxAngle(map.keyframes[from].camera_from_world, map.keyframes[to].camera_from_world, landmark.position);
}

}  // namespace

std::optional<double> UnitVariance(const Map& map, int keyframe, int following) {
  if (!IsWithinMap(map, keyframe, following)) return std::nullopt;
  double information = 0;  // of a pixel variance of 1, times keyframes
  std::vector<double> squared_errors;
  for (const KeyframeObservation& seen : map.keyframes[keyframe].observations) {
    const Landmark& landmark = map.landmarks[seen.landmark];
    if (!landmark.valid) continue;
    const int first = landmark.observations.front().keyframe;
    const int last = landmark.observations.back().keyframe;
    if (first >= keyframe || last <= keyframe) continue;
    const double before = AngleInPixels(map, landmark, first, keyframe);
    const double after = AngleInPixels(map, landmark, keyframe, last);
    if (!(before > 0 && after > 0)) continue;
    information += (last - first) * 0.5 / (1 / (before * before) + 1 / (after * after));
    for (const LandmarkObservation& observation : landmark.observations) {
      const double error = ReprojectionError(map, seen.landmark, observation);
      if (std::isfinite(error)) squared_errors.push_back(error * error);
    }
  }
  if (squared_errors.empty()) return std::numeric_limits<double>::infinity();
  return Median(std::move(squared_errors)) / kMedianSquareInPlane / information;
}

}  // namespace turnscale

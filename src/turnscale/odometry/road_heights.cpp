// SPDX-License-Identifier: MIT
#include "turnscale/odometry/road_heights.h"

#include <algorithm>
#include <cmath>

namespace turnscale {

void SetStepHeight(const Map& map, const std::vector<MeasuredHeight>& heights, VehicleStep& step) {
  if (step.after_gap || !step.usable) return;
  double information = 0;
  double sum = 0;
  int count = 0;
  for (auto height = std::ranges::upper_bound(heights, step.first, {}, &MeasuredHeight::keyframe);
       height != heights.end() && height->keyframe <= step.last; ++height) {
    const double distance = (Centre(map.keyframes[height->keyframe]) - Centre(map.keyframes[height->reference])).norm();
    if (!(distance > 0) || !std::isfinite(distance)) continue;
    const double weight = 1 / (height->sigma * height->sigma);
    information += weight;
    sum += weight * std::log(height->ratio * distance);
    ++count;
  }
  if (count == 0) return;
  step.height = std::exp(sum / information);
  // Keyframes of one step share most of their errors.
  step.height_sigma = std::sqrt(count / information);
}

}  // namespace turnscale

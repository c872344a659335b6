// SPDX-License-Identifier: MIT
#include "turnscale/odometry/road_heights.h"

#include <algorithm>
#include <cmath>

#include "turnscale/kinematics/step_height.h"

namespace turnscale {

void SetStepHeight(const Map& map, const std::vector<MeasuredHeight>& heights, VehicleStep& step) {
  if (step.after_gap || !step.usable) return;
  StepHeight mean;
  for (auto height = std::ranges::upper_bound(heights, step.first, {}, &MeasuredHeight::keyframe);
       height != heights.end() && height->keyframe <= step.last; ++height) {
    const double distance = (Centre(map.keyframes[height->keyframe]) - Centre(map.keyframes[height->reference])).norm();
    if (distance > 0 && std::isfinite(distance)) mean.Add(height->ratio * distance, height->sigma);
  }
  mean.SetOn(step);
}

}  // namespace turnscale

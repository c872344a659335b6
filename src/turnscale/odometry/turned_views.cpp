// SPDX-License-Identifier: MIT
#include "turnscale/odometry/turned_views.h"

#include <utility>

#include "turnscale/geometry/angle.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Between the two keyframes: half of it moves far points by more than ten pixels even in small images.
constexpr double kTurnOfViews = 4 / kDegreesPerRadian;

}  // namespace

void TurnedViews::Add(const Map& map, const cv::Mat& gray) {
  const int keyframe = CountKeyframes(map) - 1;
  if (!later_.gray.empty() && TurnBetween(map, later_.keyframe, keyframe) < kTurnOfViews) return;
  earlier_ = std::exchange(later_, {keyframe, gray});
}

void TurnedViews::Clear() { earlier_ = later_ = {}; }

EarlierView TurnedViews::Before(const Map& map, const Eigen::Quaterniond& camera_from_world) const {
  for (const View& view : {later_, earlier_}) {
    if (view.gray.empty()) continue;
    const Eigen::Quaterniond turn =
        camera_from_world * map.keyframes[view.keyframe].camera_from_world.rotation.conjugate();
    if (RotationAngle(turn) >= kTurnOfViews / 2) return {view.gray, turn};
  }
  return {};
}

}  // namespace turnscale

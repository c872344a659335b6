// SPDX-License-Identifier: MIT
#include "turnscale/odometry/path_gaps.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace turnscale {
namespace {

// Standard deviation of the length over the time squared, m/s^2.
constexpr double kInterpolated = 0.15;
constexpr double kExtrapolated = 0.4;
// Bound of the error of a mean speed, m/s: a car's speed does not vary by more.
constexpr double kMostSpeedSigma = 10;
// A velocity is the mean over so many seconds, if the map goes on for that long.
constexpr double kVelocitySeconds = 0.5;

// Velocity of the camera after a keyframe, from the keyframes up to the next gap; empty if there are none.
std::optional<Eigen::Vector3d> VelocityAfter(const Map& map, const MetricPath& path, int keyframe) {
  const int count = static_cast<int>(map.keyframes.size());
  const auto seconds = [&](int k) { return map.keyframes[k].time - map.keyframes[keyframe].time; };
  int last = keyframe;
  while (last + 1 < count && !map.keyframes[last + 1].after_gap && seconds(last) < kVelocitySeconds) ++last;
  if (last == keyframe) return std::nullopt;
  return (path.centres[last] - path.centres[keyframe]) / seconds(last);
}

}  // namespace

double GapLengthSigma(double seconds, bool both_ends) {
  return seconds * std::min((both_ends ? kInterpolated : kExtrapolated) * seconds, kMostSpeedSigma);
}

double BridgeGaps(const Map& map, const std::vector<MeasuredEnd>& ends, double end_time, MetricPath& path) {
  double variance = ends.empty() ? 0 : std::pow(GapLengthSigma(end_time - ends.back().time, false), 2);
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  // of all keyframes behind the gaps so far
  for (int k = 0; k < static_cast<int>(map.keyframes.size()); ++k) {
    if (k > 0 && map.keyframes[k].after_gap) {
      const double seconds = map.keyframes[k].time - ends[k - 1].time;
      const std::optional<Eigen::Vector3d> after = VelocityAfter(map, path, k);
      const Eigen::Vector3d predicted = path.centres[k] + shift - path.InMetres(map, k - 1, ends[k - 1].centre);
      if (after) shift += 0.5 * (seconds * *after - predicted);
      variance += std::pow(GapLengthSigma(seconds, after.has_value()), 2);
    }
    path.centres[k] += shift;
  }
  return std::sqrt(variance);
}

}  // namespace turnscale

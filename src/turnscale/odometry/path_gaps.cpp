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
// What a corner costs over the time squared, m/s^2: per turn squared, and at most.
constexpr double kSlowing = 0.18;
constexpr double kMostSlowing = 0.25;
// A longer gap has more than the corner.
constexpr double kCornerSeconds = 5;
// Share of the way.
constexpr double kMostSlowingShare = 0.25;
// A velocity is the mean over so many seconds, if the map goes on for that long.
constexpr double kVelocitySeconds = 0.5;

// Velocity of the camera after a keyframe, from the keyframes up to the next gap; empty if there are none.
std::optional<Eigen::Vector3d> VelocityAfter(const Map& map, const MetricPath& path, int keyframe) {
  const int count = CountKeyframes(map);
  const auto seconds = [&](int k) { return map.keyframes[k].time - map.keyframes[keyframe].time; };
  int last = keyframe;
  while (last + 1 < count && !map.keyframes[last + 1].after_gap && seconds(last) < kVelocitySeconds) ++last;
  if (last == keyframe) return std::nullopt;
  return (path.centres[last] - path.centres[keyframe]) / seconds(last);
}

// By how much the variance of one side's relative scale exceeds that of the other; 0 while the scale is pending.
double Excess(double sigma, double other) {
  return std::isfinite(sigma) && std::isfinite(other) ? std::max(0.0, sigma * sigma - other * other) : 0.0;
}

// Two predictions of the motion across a gap, from the speeds on its sides. The common part of their scales' errors
// belongs to the whole path; what one has beyond the other makes it the worse prediction.
struct GapSides {
  double seconds = 0;
  double before_variance = 0;  ///< of the length, m^2, from the scale alone
  double after_variance = 0;

  double ShareOfAfter() const {
    const double speed_variance = std::pow(GapLengthSigma(seconds, false), 2);
    if (speed_variance == 0) return 0.5;
    return (speed_variance + before_variance) / (2 * speed_variance + before_variance + after_variance);
  }
  double LengthVariance() const {
    const double after = ShareOfAfter();
    const double both = GapLengthSigma(seconds, true);
    const double one = GapLengthSigma(seconds, false);
    return std::pow(both + (one - both) * std::abs(2 * after - 1), 2) + std::pow(1 - after, 2) * before_variance +
           after * after * after_variance;
  }
};

// What a corner takes from a way of such a length.
double SlowingAlong(double length, double seconds, double turn) {
  return std::min(CornerSlowing(seconds, turn), kMostSlowingShare * length);
}

// Variance of the length across a gap due to the uncertain turn in it, m^2: a car that turns more has braked more, and
// the two ends are closer to each other along an arc. Of a turn that is smaller or larger, what changes more.
double TurnVariance(double length, double seconds, double turn, double turn_sigma) {
  const auto lost = [&](double angle) {
    return SlowingAlong(length, seconds, angle) + length * std::min(angle * angle / 24, kMostSlowingShare);
  };
  const double of_more = lost(turn + turn_sigma) - lost(turn);
  const double of_less = lost(turn) - lost(std::max(turn - turn_sigma, 0.0));
  return std::pow(std::max(of_more, of_less), 2);
}

// The way across a gap, of which a `share` is driven as after it. Its direction is that of the prediction, which has
// the turn in the gap. A car that starts after it goes as it does then.
Eigen::Vector3d WayAcross(const Eigen::Vector3d& predicted, const Eigen::Vector3d& as_after, double share) {
  constexpr double kStands = 0.05;
  const double length = predicted.norm();
  if (length <= kStands * as_after.norm()) return (1 - share) * predicted + share * as_after;
  const double as_after_length = std::copysign(as_after.norm(), as_after.dot(predicted));
  return ((1 - share) + share * as_after_length / length) * predicted;
}

}  // namespace

double GapLengthSigma(double seconds, bool both_ends) {
  return seconds * std::min((both_ends ? kInterpolated : kExtrapolated) * seconds, kMostSpeedSigma);
}

double CornerSlowing(double seconds, double turn) {
  const double counted = std::min(seconds, kCornerSeconds);
  return counted * counted * std::min(kSlowing * turn * turn, kMostSlowing);
}

void BridgeGaps(const Map& map, const std::vector<MeasuredEnd>& ends, double end_time, RefinedScale& refined) {
  MetricPath& path = refined.path;
  double variance = ends.empty() ? 0 : std::pow(GapLengthSigma(end_time - ends.back().time, false), 2);
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  // of all keyframes behind the gaps so far
  for (int k = 0; k < CountKeyframes(map); ++k) {
    if (k > 0 && map.keyframes[k].after_gap) {
      const double seconds = map.keyframes[k].time - ends[k - 1].time;
      const std::optional<Eigen::Vector3d> after = VelocityAfter(map, path, k);
      const Eigen::Vector3d predicted = path.centres[k] + shift - path.InMetres(map, k - 1, ends[k - 1].centre);
      if (after) {
        const double sigma_before = refined.keyframes[k - 1].sigma;
        const double sigma_after = refined.keyframes[k].sigma;
        const GapSides sides{seconds, Excess(sigma_before, sigma_after) * predicted.squaredNorm(),
                             Excess(sigma_after, sigma_before) * (seconds * *after).squaredNorm()};
        Eigen::Vector3d way = WayAcross(predicted, seconds * *after, sides.ShareOfAfter());
        const double turn = TurnBetween(map, k - 1, k);
        const double length = way.norm();
        if (length > 0) way *= 1 - SlowingAlong(length, seconds, turn) / length;
        shift += way - predicted;
        variance += sides.LengthVariance() + TurnVariance(length, seconds, turn, map.keyframes[k].gap_turn_sigma);
      } else {
        variance += std::pow(GapLengthSigma(seconds, false), 2);
      }
    }
    path.centres[k] += shift;
  }
  refined.gap_sigma = std::sqrt(variance);
}

}  // namespace turnscale

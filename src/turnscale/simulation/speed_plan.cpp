// SPDX-License-Identifier: MIT
#include "turnscale/simulation/speed_plan.h"

#include <algorithm>
#include <cmath>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Share of what the car can do in curves that is planned with; the rest is for the follower's corrections.
constexpr double kCurveShare = 0.9;
// Accelerations change over this time, seconds.
constexpr double kSpeedSmoothingTime = 1.2;

/// Greatest speed at each sample of the path, its neighbours left out of account.
std::vector<double> SpeedLimits(const CarOptions& options, const ReferencePath& path) {
  const double steering_rate = kCurveShare * options.max_steering_rate_deg / kDegreesPerRadian;
  std::vector<double> limits = path.speed;
  for (std::size_t i = 0; i < limits.size(); ++i) {
    const double curvature = path.curvature[i];
    if (curvature != 0)
      limits[i] = std::min(limits[i], std::sqrt(kCurveShare * options.max_lateral_acceleration / std::abs(curvature)));
    if (i == 0 || i + 1 == limits.size()) continue;
    const double bend = options.wheelbase * curvature;
    const double steering_per_metre =
        options.wheelbase * (path.curvature[i + 1] - path.curvature[i - 1]) / (2 * path.spacing) / (1 + bend * bend);
    if (steering_per_metre != 0) limits[i] = std::min(limits[i], steering_rate / std::abs(steering_per_metre));
  }
  return limits;
}

/// Speeds every `interval` seconds from those at the samples of the path, the acceleration being even between these.
std::vector<double> SpeedsInTime(const std::vector<double>& speeds, double spacing, double interval) {
  std::vector<double> in_time;
  double start = 0;
  for (std::size_t i = 0; i + 1 < speeds.size(); ++i) {
    const double duration = 2 * spacing / (speeds[i] + speeds[i + 1]);
    for (double time; (time = static_cast<double>(in_time.size()) * interval) < start + duration;)
      in_time.push_back(speeds[i] + (time - start) / duration * (speeds[i + 1] - speeds[i]));
    start += duration;
  }
  in_time.push_back(speeds.back());
  return in_time;
}

}  // namespace

std::vector<double> PlanSpeeds(const CarOptions& options, const ReferencePath& path, const EndSpeeds& ends,
                               double interval) {
  std::vector<double> speeds = SpeedLimits(options, path);
  speeds.front() = std::min(speeds.front(), ends.start);
  speeds.back() = std::min(speeds.back(), ends.end);
  for (std::size_t i = 1; i < speeds.size(); ++i)
    speeds[i] =
        std::min(speeds[i], std::sqrt(speeds[i - 1] * speeds[i - 1] + 2 * options.max_acceleration * path.spacing));
  for (std::size_t i = speeds.size() - 1; i-- > 0;)
    speeds[i] =
        std::min(speeds[i], std::sqrt(speeds[i + 1] * speeds[i + 1] + 2 * options.max_deceleration * path.spacing));
  const std::vector<double> sharp = SpeedsInTime(speeds, path.spacing, interval);

  // A weighted mean over time keeps the limits of acceleration and, with rest on both sides, the distance.
  const int reach = static_cast<int>(std::lround(0.5 * kSpeedSmoothingTime / interval));
  std::vector<double> weights;
  for (int k = 0; k <= 2 * reach; ++k) weights.push_back((1 - std::cos(M_PI * k / reach)) / (2 * reach));
  const int last = static_cast<int>(sharp.size()) - 1;
  const int first_moment = speeds.front() > 0 ? 0 : -reach;
  const int last_moment = speeds.back() > 0 ? last : last + reach;
  std::vector<double> smooth;
  for (int i = first_moment; i <= last_moment; ++i) {
    double sum = 0;
    for (int k = -reach; k <= reach; ++k) sum += weights[k + reach] * sharp[std::clamp(i + k, 0, last)];
    smooth.push_back(sum);
  }
  if (speeds.front() == 0) smooth.front() = 0;
  if (speeds.back() == 0) smooth.back() = 0;
  return smooth;
}

}  // namespace turnscale

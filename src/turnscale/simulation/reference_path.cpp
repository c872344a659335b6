// SPDX-License-Identifier: MIT
#include "turnscale/simulation/reference_path.h"

#include <algorithm>
#include <cmath>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kSpacing = 0.05;
constexpr double kSmoothing = 0.5;               // metres, standard deviation
constexpr double kRecordingSmoothingTime = 0.2;  // seconds, standard deviation for recordings
constexpr double kCreepingSpeed = 0.2;           // m/s

// x, z and speed.
using Samples = std::vector<Eigen::Vector3d>;

/// Points about kSpacing apart along the polyline.
Samples Resample(const Samples& points, double& spacing) {
  std::vector<double> distance = {0};
  for (std::size_t i = 1; i < points.size(); ++i)
    distance.push_back(distance.back() + (points[i] - points[i - 1]).head<2>().norm());
  const int count = std::max(2, static_cast<int>(std::lround(distance.back() / kSpacing)));
  spacing = distance.back() / count;
  Samples samples;
  std::size_t next = 1;
  for (int i = 0; i < count; ++i) {
    const double at = i * spacing;
    while (next + 1 < points.size() && distance[next] <= at) ++next;
    const double piece = distance[next] - distance[next - 1];
    const double share = piece > 0 ? std::clamp((at - distance[next - 1]) / piece, 0.0, 1.0) : 0.0;
    samples.emplace_back(points[next - 1] + share * (points[next] - points[next - 1]));
  }
  samples.push_back(points.back());
  return samples;
}

/// Sample at an index; beyond an end the path is mirrored at the end's point, which keeps it there.
Eigen::Vector3d Mirrored(const Samples& samples, long index) {
  const long last = static_cast<long>(samples.size()) - 1;
  if (index < 0) return 2 * samples.front() - samples[std::min(-index, last)];
  if (index > last) return 2 * samples.back() - samples[std::max(2 * last - index, 0L)];
  return samples[index];
}

/// Half of the smoothing, in the sense of variances.
Samples Smooth(const Samples& samples, double spacing, bool recorded) {
  Samples smooth;
  smooth.reserve(samples.size());
  for (long i = 0; i < static_cast<long>(samples.size()); ++i) {
    const double sigma =
        M_SQRT1_2 * (recorded ? std::max(kSmoothing, kRecordingSmoothingTime * samples[i].z()) : kSmoothing);
    // Triweight, which ends smoothly: the curvature would show where a kernel that varies along the path is cut off.
    const double reach = 3 * sigma / spacing;
    Eigen::Vector3d sum = samples[i];
    double weights = 1;
    for (long k = 1; static_cast<double>(k) < reach; ++k) {
      const double share = static_cast<double>(k) / reach;
      const double weight = std::pow(1 - share * share, 3);
      sum += weight * (Mirrored(samples, i - k) + Mirrored(samples, i + k));
      weights += 2 * weight;
    }
    smooth.emplace_back(sum / weights);
  }
  return smooth;
}

/// Half the difference of a sample's neighbours, the whole one to the only neighbour at the ends.
template <typename T>
T Slope(const std::vector<T>& samples, std::size_t i) {
  const std::size_t before = i == 0 ? 0 : i - 1;
  const std::size_t after = std::min(i + 1, samples.size() - 1);
  return (samples[after] - samples[before]) / static_cast<double>(after - before);
}

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

ReferencePath MakeReferencePath(const RouteLeg& leg) {
  Samples points;
  for (std::size_t i = 0; i < leg.points.size(); ++i)
    points.emplace_back(leg.points[i].x(), leg.points[i].y(), leg.speeds.empty() ? leg.speed : leg.speeds[i]);
  ReferencePath path;
  // In two goes: the first one makes the points' distances uneven, and what evens them out leaves small kinks.
  for (int i = 0; i < 2; ++i) {
    points = Resample(points, path.spacing);
    points = Smooth(points, path.spacing, !leg.speeds.empty());
  }
  for (const Eigen::Vector3d& point : points) {
    path.position.emplace_back(point.head<2>());
    path.speed.push_back(leg.speeds.empty() ? leg.speed : std::max(point.z(), kCreepingSpeed));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d ahead = Slope(path.position, i);
    const double heading = std::atan2(ahead.x(), ahead.y());
    const double turns = i == 0 ? 0 : std::round((path.heading.back() - heading) / (2 * M_PI));
    path.heading.push_back(heading + 2 * M_PI * turns);
  }
  for (std::size_t i = 0; i < points.size(); ++i) path.curvature.push_back(Slope(path.heading, i) / path.spacing);
  return path;
}

PathPlace PlaceAt(const ReferencePath& path, double distance) {
  const double inside = std::clamp(distance, 0.0, path.Length());
  const std::size_t i = std::min(static_cast<std::size_t>(inside / path.spacing), path.position.size() - 2);
  const double share = inside / path.spacing - static_cast<double>(i);
  PathPlace place;
  place.position = path.position[i] + share * (path.position[i + 1] - path.position[i]);
  place.heading = path.heading[i] + share * (path.heading[i + 1] - path.heading[i]);
  place.curvature = path.curvature[i] + share * (path.curvature[i + 1] - path.curvature[i]);
  if (inside != distance) {
    place.position += (distance - inside) * Eigen::Vector2d(std::sin(place.heading), std::cos(place.heading));
    place.curvature = 0;
  }
  return place;
}

double Project(const ReferencePath& path, const Eigen::Vector2d& position, double guess) {
  double distance = guess;
  for (int i = 0; i < 2; ++i) {
    const PathPlace place = PlaceAt(path, distance);
    distance += (position - place.position).dot(Eigen::Vector2d(std::sin(place.heading), std::cos(place.heading)));
  }
  return distance;
}

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

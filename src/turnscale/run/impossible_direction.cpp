// SPDX-License-Identifier: MIT
#include "turnscale/run/impossible_direction.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "turnscale/base/quantiles.h"
#include "turnscale/geometry/angle.h"

namespace turnscale {
namespace {

// A direction is that of so many metres of the path: noise of the positions and of the car's pitching hardly count.
constexpr double kLength = 1;  // m
// The same where the unit is not known, in seconds at the speed of a car that moves.
constexpr double kUsualSeconds = 0.5;
constexpr double kLongest = 3;          // s
constexpr double kLongestInterval = 1;  // s
constexpr double kMostTurn = 40 / kDegreesPerRadian;
// Ramps begin and end within a car's length, and bumps lift an axle by 0.1 m: ten degrees over a metre at most.
constexpr double kMostUp = 20 / kDegreesPerRadian;
// Rear tyres slip by ten degrees at most, unless the car drifts; a camera without a lever arm swings out in turns.
constexpr double kMostAside = 45 / kDegreesPerRadian;

// How the car moves, in its own axes: forward, also where it reverses.
struct Direction {
  double from = 0;
  double to = 0;
  Eigen::Vector3d ahead = Eigen::Vector3d::UnitZ();
};

Eigen::Quaterniond WorldFromVehicle(const FrameResult& frame) {
  return frame.world_from_camera->rotation * frame.vehicle_from_camera.conjugate();
}

// At which half of the path is driven, in units of the poses per second: the noise of a car that waits does not count.
// 0 where no two frames in sequence are measured.
double MovingSpeed(const std::vector<FrameResult>& frames) {
  std::vector<std::pair<double, double>> steps;  // speed and length
  for (size_t i = 1; i < frames.size(); ++i) {
    if (!frames[i].is_measured() || !frames[i - 1].is_measured()) continue;
    const double length = DistanceBetween(frames[i - 1], frames[i]);
    steps.emplace_back(length / (frames[i].time - frames[i - 1].time), length);
  }
  return WeightedMedian(std::move(steps));
}

// Each is that of a part of the path of this length or a little more. Both lengths are in the unit of the poses.
std::vector<Direction> Directions(const std::vector<FrameResult>& frames, double length, double lever_arm) {
  std::vector<Direction> directions;
  size_t first = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].is_measured() || (i > 0 && frames[i].time - frames[i - 1].time > kLongestInterval)) {
      first = frames[i].is_measured() ? i : i + 1;
      continue;
    }
    while (frames[i].time - frames[first].time > kLongest) ++first;
    const Eigen::Vector3d moved = RearAxle(frames[i], lever_arm).position - RearAxle(frames[first], lever_arm).position;
    if (moved.norm() < length) continue;
    const Eigen::Quaterniond begin = WorldFromVehicle(frames[first]);
    const Eigen::Quaterniond end = WorldFromVehicle(frames[i]);
    const Eigen::Vector3d ahead = begin.slerp(0.5, end).conjugate() * moved.normalized();
    // Over a sharper turn, the chord of the path is no direction.
    if (begin.angularDistance(end) < kMostTurn)
      directions.push_back({frames[first].time, frames[i].time, ahead.z() < 0 ? -ahead : ahead});
    first = i;
  }
  return directions;
}

// The median of each coordinate: the rotation of the camera may be given wrong.
Eigen::Vector3d UsualDirection(const std::vector<Direction>& directions) {
  Eigen::Vector3d usual;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const Direction& direction : directions) values.push_back(direction.ahead[axis]);
    usual[axis] = Median(std::move(values));
  }
  return usual.normalized();
}

// By how many times the angles exceed what a car does; the larger of the two.
double Excess(double up, double aside) { return std::max(std::abs(up) / kMostUp, std::abs(aside) / kMostAside); }

double LengthBetween(const std::vector<FrameResult>& frames, double from, double to) {
  double length = 0;
  for (size_t i = 1; i < frames.size(); ++i)
    if (frames[i - 1].time >= from && frames[i].time <= to) length += DistanceBetween(frames[i - 1], frames[i]);
  return length;
}

}  // namespace

std::vector<ImpossibleDirection> FindImpossibleDirections(const std::vector<FrameResult>& frames, double lever_arm) {
  if (frames.empty()) return {};
  const bool is_metric = frames.back().scale_state != ScaleState::kPending;
  const double length = is_metric ? kLength : kUsualSeconds * MovingSpeed(frames);
  if (!(length > 0)) return {};
  const std::vector<Direction> directions = Directions(frames, length, is_metric ? lever_arm : 0);
  if (directions.empty()) return {};
  const auto ahead_from_usual =
      Eigen::Quaterniond::FromTwoVectors(UsualDirection(directions), Eigen::Vector3d::UnitZ());
  std::vector<ImpossibleDirection> parts;
  for (const Direction& direction : directions) {
    const Eigen::Vector3d ahead = ahead_from_usual * direction.ahead;
    const double up = std::asin(std::clamp(-ahead.y(), -1.0, 1.0));
    const double aside = std::atan2(ahead.x(), std::abs(ahead.z()));
    const double excess = Excess(up, aside);
    if (excess < 1) continue;
    const bool continues = !parts.empty() && parts.back().to == direction.from;
    if (!continues) parts.push_back({.from = direction.from});
    ImpossibleDirection& part = parts.back();
    part.to = direction.to;
    if (excess < Excess(part.up, part.aside)) continue;
    part.up = up;
    part.aside = aside;
  }
  if (is_metric)
    for (ImpossibleDirection& part : parts) part.distance = LengthBetween(frames, part.from, part.to);
  return parts;
}

std::string ImpossibleDirectionText(const std::vector<ImpossibleDirection>& parts, double first_time) {
  if (parts.empty()) return {};
  const auto longest = std::ranges::max_element(
      parts, {}, [](const ImpossibleDirection& part) { return part.distance ? *part.distance : part.to - part.from; });
  const bool is_steep = std::abs(longest->up) / kMostUp > std::abs(longest->aside) / kMostAside;
  const double angle = is_steep ? longest->up : longest->aside;
  const char* way = is_steep ? (angle > 0 ? "upwards" : "downwards") : (angle > 0 ? "to the right" : "to the left");
  return fmt::format(
      "the path goes {:.0f} degrees {} as seen from the car ({}from {:.1f} to {:.1f} s{}), as no car drives: "
      "probably a vehicle was tracked instead of the scene; look at the video there, and leave that part out (--start, "
      "--end) if what follows is tilted or rotated",
      InDegrees(std::abs(angle)), way, parts.size() > 1 ? fmt::format("{} places, the longest ", parts.size()) : "",
      longest->from - first_time, longest->to - first_time,
      longest->distance ? fmt::format(", {:.0f} m", *longest->distance) : "");
}

double LengthErrorOf(const std::vector<ImpossibleDirection>& parts) {
  double sum = 0;
  for (const ImpossibleDirection& part : parts) sum += part.distance.value_or(0);
  return sum;
}

}  // namespace turnscale

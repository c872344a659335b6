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
constexpr double kLength = 1;
constexpr double kLongest = 3;  // s
// Ramps begin and end within a car's length, and bumps lift an axle by 0.1 m: ten degrees over a metre at most.
constexpr double kMostUp = 20 / kDegreesPerRadian;
// Rear tyres slip by ten degrees at most, unless the car drifts; a camera without a lever arm swings out in turns.
constexpr double kMostAside = 45 / kDegreesPerRadian;

struct Direction {
  double from = 0;
  double to = 0;
  double up = 0;
  double aside = 0;
};

Eigen::Quaterniond WorldFromVehicle(const FrameResult& frame) {
  return frame.world_from_camera->rotation * frame.vehicle_from_camera.conjugate();
}

Eigen::Vector3d RearAxle(const FrameResult& frame, double lever_arm) {
  return frame.world_from_camera->translation - WorldFromVehicle(frame) * Eigen::Vector3d(0, 0, lever_arm);
}

// Of a car that moves by this vector, in its own axes. In reverse, up is up, too.
Direction DirectionOf(const Eigen::Vector3d& moved, double from, double to) {
  return {from, to, std::asin(std::clamp(-moved.y() / moved.norm(), -1.0, 1.0)),
          std::atan2(moved.x(), std::abs(moved.z()))};
}

std::vector<Direction> Directions(const std::vector<FrameResult>& frames, double lever_arm) {
  std::vector<Direction> directions;
  size_t first = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].is_measured()) {
      first = i + 1;
      continue;
    }
    while (frames[i].time - frames[first].time > kLongest) ++first;
    const Eigen::Vector3d moved = RearAxle(frames[i], lever_arm) - RearAxle(frames[first], lever_arm);
    if (moved.norm() < kLength) continue;
    const Eigen::Quaterniond vehicle_from_world = WorldFromVehicle(frames[(first + i) / 2]).conjugate();
    directions.push_back(DirectionOf(vehicle_from_world * moved, frames[first].time, frames[i].time));
    first = i;
  }
  return directions;
}

double MedianOf(const std::vector<Direction>& directions, double Direction::*angle) {
  std::vector<double> angles;
  for (const Direction& direction : directions) angles.push_back(direction.*angle);
  return Median(std::move(angles));
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
  if (frames.empty() || frames.back().scale_state == ScaleState::kPending) return {};
  const std::vector<Direction> directions = Directions(frames, lever_arm);
  if (directions.empty()) return {};
  // The rotation of the camera may be given wrong.
  const double usual_up = MedianOf(directions, &Direction::up);
  const double usual_aside = MedianOf(directions, &Direction::aside);
  std::vector<ImpossibleDirection> parts;
  for (const Direction& direction : directions) {
    const double up = direction.up - usual_up;
    const double aside = direction.aside - usual_aside;
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
  for (ImpossibleDirection& part : parts) part.distance = LengthBetween(frames, part.from, part.to);
  return parts;
}

std::string ImpossibleDirectionText(const std::vector<ImpossibleDirection>& parts, double first_time) {
  if (parts.empty()) return {};
  const auto longest = std::ranges::max_element(parts, {}, &ImpossibleDirection::distance);
  const bool is_steep = std::abs(longest->up) / kMostUp > std::abs(longest->aside) / kMostAside;
  const double angle = is_steep ? longest->up : longest->aside;
  const char* way = is_steep ? (angle > 0 ? "upwards" : "downwards") : (angle > 0 ? "to the right" : "to the left");
  return fmt::format(
      "the path goes {:.0f} degrees {} as seen from the car ({}from {:.1f} to {:.1f} s, {:.0f} m), as no car drives: "
      "the "
      "wrong things were tracked there; that part is wrong, and what follows may be tilted or rotated",
      InDegrees(std::abs(angle)), way, parts.size() > 1 ? fmt::format("{} places, the longest ", parts.size()) : "",
      longest->from - first_time, longest->to - first_time, longest->distance);
}

double LengthErrorOf(const std::vector<ImpossibleDirection>& parts) {
  double sum = 0;
  for (const ImpossibleDirection& part : parts) sum += part.distance;
  return sum;
}

}  // namespace turnscale

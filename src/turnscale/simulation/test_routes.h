// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "turnscale/simulation/vehicle.h"
#include "turnscale/simulation/world.h"

namespace turnscale {

constexpr double kHalfCarWidth = 0.9;

inline double FlatRoad(const Eigen::Vector2d&) { return 0; }

inline std::vector<Eigen::Vector2d> Arc(const Eigen::Vector2d& centre, double radius, double from, double to) {
  std::vector<Eigen::Vector2d> points;
  const int count = static_cast<int>(std::ceil(std::abs(to - from) * radius / 0.3));
  for (int i = 0; i <= count; ++i) {
    const double angle = from + (to - from) * i / count;
    points.emplace_back(centre + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

/// From the origin along z, then round and round to the right.
inline RouteLeg Circle(double radius, double speed, double turns) {
  RouteLeg leg;
  leg.points = Arc({radius, 0}, radius, M_PI, M_PI - 2 * M_PI * turns);
  leg.speed = speed;
  return leg;
}

inline RouteLeg Straight(double length, double speed) {
  RouteLeg leg;
  leg.points = {{0, 0}, {0, length}};
  leg.speed = speed;
  return leg;
}

/// No movement of the body but what the road asks for.
inline CarOptions StiffVehicle() {
  CarOptions options;
  options.pitch_deg_per_g = 0;
  options.roll_deg_per_g = 0;
  options.road_noise_deg = 0;
  return options;
}

inline VehicleMotion DriveFlat(const CarOptions& options, const std::vector<RouteLeg>& legs, unsigned seed = 1) {
  return Drive(options, legs, FlatRoad, 0.3, seed);
}

/// The drive that a world is made for.
inline VehicleMotion Driven(const World& world) { return Drive(CarOptions{}, world.legs, world.road, 0.3, 1); }

/// The moments of a drive, `interval` apart.
inline std::vector<VehicleState> Moments(const VehicleMotion& motion, double interval) {
  std::vector<VehicleState> states;
  const int count = static_cast<int>(std::floor(motion.duration() / interval + 1e-9));
  for (int i = 0; i <= count; ++i) states.push_back(motion.At(i * interval));
  return states;
}

inline double DistanceFromPath(const Eigen::Vector2d& point, const std::vector<Eigen::Vector2d>& path) {
  double least = (point - path.front()).norm();
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Eigen::Vector2d piece = path[i] - path[i - 1];
    const double share = std::clamp((point - path[i - 1]).dot(piece) / piece.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (point - path[i - 1] - share * piece).norm());
  }
  return least;
}

}  // namespace turnscale

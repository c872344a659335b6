// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "turnscale/base/random.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/vehicle_step.h"

namespace turnscale {

constexpr double kDegree = std::numbers::pi / 180;

/// Equal steps of a made-up drive, for tests.
struct StretchOfRoad {
  int steps = 0;
  double psi = 0;     ///< rad a step turns
  double length = 0;  ///< metres a step goes, along the way that the car faces half-way through it
  double speed = 0;   ///< metres per second
  double roll = 0;    ///< rad a rad of turning: the slope of a helical ramp
};

/// How a car and its odometry differ from the model; standard deviations, normal.
struct DriveErrors {
  double direction = 0;           ///< rad, of each step's direction of travel, for a step of ordinary length
  double lever_arm = 0;           ///< relative, one for each stretch
  double slip = 0;                ///< relative, one for each stretch
  double turn_direction = 0;      ///< rad, one for each stretch that turns
  double straight_direction = 0;  ///< rad, one for each that does not
  double per_100m = 0;            ///< of the log-scale's random walk
  double per_90deg = 0;
  double lag = 0;  ///< by which the orientation of the images lags behind the car's, s; no standard deviation
};

/// The car and the odometry of most tests: its lever arm, the metres of its unit, and its noise.
constexpr LeverArm kCar{1.5, 0.005};
constexpr double kUnit = 12;
constexpr DriveErrors kNoise{.direction = 0.2 * kDegree};

/// A drive in an arbitrary unit, whose truth is known.
struct SyntheticSteps {
  std::vector<VehicleStep> steps;
  std::vector<double> metres_per_unit;  ///< of each step
  double metres = 0;                    ///< of the whole path
};

/// Drives a road. `direction` is the direction of travel on straights as the odometry has it, `unit` the metres of its
/// unit of length at the start.
inline SyntheticSteps MakeSteps(const std::vector<StretchOfRoad>& road, const LeverArm& lever_arm, double direction,
                                double unit, const DriveErrors& errors = {}, std::uint64_t seed = 1) {
  constexpr double kTurning = 1.5 * kDegree;
  Random random(seed);
  SyntheticSteps drive;
  double log_scale = std::log(unit);
  int pose = 0;
  for (const StretchOfRoad& stretch : road) {
    const double swing = 1 + errors.lever_arm * random.Gaussian();
    const double slip = 1 + errors.slip * random.Gaussian();
    const bool turns = std::abs(stretch.psi) >= kTurning;
    const double off = direction + (turns ? errors.turn_direction : errors.straight_direction) * random.Gaussian();
    const double effective = lever_arm.length * swing - lever_arm.side_slip * slip * stretch.speed * stretch.speed +
                             errors.lag * stretch.speed;
    for (int i = 0; i < stretch.steps; ++i) {
      const double angle = off + errors.direction * random.Gaussian();
      const double roll = stretch.roll * stretch.psi;
      const double sideways =
          effective * 2 * std::sin(0.5 * stretch.psi) + lever_arm.roll_height * roll + angle * stretch.length;
      const double metres = std::hypot(sideways, stretch.length);
      const double quarter = std::numbers::pi / 2;
      log_scale += std::hypot(errors.per_100m * std::sqrt(metres / 100),
                              errors.per_90deg * std::sqrt(std::abs(stretch.psi) / quarter)) *
                   random.Gaussian();
      VehicleStep step;
      step.motion.psi = stretch.psi;
      step.motion.theta = 0.5 * stretch.psi + std::atan2(sideways, stretch.length);
      step.motion.step = metres * std::exp(-log_scale);
      step.duration = metres / stretch.speed;
      step.roll = roll;
      step.first = pose;
      step.last = ++pose;
      drive.steps.push_back(step);
      drive.metres_per_unit.push_back(std::exp(log_scale));
      drive.metres += metres;
    }
  }
  return drive;
}

/// Tracking is lost in place of this step, across which the unit of length may change by `sigma` (relative).
inline void LoseTracking(double sigma, VehicleStep& step) {
  VehicleStep gap;
  gap.first = step.first;
  gap.last = step.last;
  gap.usable = false;
  gap.after_gap = true;
  gap.gap_sigma = sigma;
  step = gap;
}

/// How the road shows the height of the camera; standard deviations, relative.
struct HeightErrors {
  double step = 0;     ///< of each step
  double road = 0;     ///< of an error that is exponentially correlated along the way
  double length = 60;  ///< over which it is, metres
};

/// Lets every step of a drive show a camera that is `height` metres above the road.
inline void ShowRoad(double height, const HeightErrors& errors, std::uint64_t seed, SyntheticSteps& drive) {
  Random random(seed);
  double error = random.Gaussian();
  for (std::size_t i = 0; i < drive.steps.size(); ++i) {
    VehicleStep& step = drive.steps[i];
    const double kept = std::exp(-step.motion.step * drive.metres_per_unit[i] / errors.length);
    error = kept * error + std::sqrt(1 - kept * kept) * random.Gaussian();
    step.height = height / drive.metres_per_unit[i] * std::exp(errors.road * error + errors.step * random.Gaussian());
    step.height_sigma = errors.step;
  }
}

/// Streets with `turns` corners to either side at 3 to 8 m/s, straights of some hundred metres between them.
inline std::vector<StretchOfRoad> TownRoad(int turns, std::uint64_t seed) {
  Random random(seed);
  std::vector<StretchOfRoad> road;
  const auto straight = [&] {
    const double speed = random.Uniform(7, 13);
    road.push_back({10 + random.Below(20), 0, 0.6 * speed, speed});
  };
  straight();
  for (int i = 0; i < turns; ++i) {
    const double angle = random.Uniform(50, 120) * kDegree;
    const double radius = random.Uniform(6, 25);
    const int steps = static_cast<int>(angle / 0.05);
    const double psi = (random.Chance(0.5) ? 1 : -1) * angle / steps;
    road.push_back({steps, psi, radius * angle / steps, random.Uniform(3, 8)});
    straight();
  }
  return road;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/paper_drive.h"

#include <array>
#include <numbers>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr std::array<int, 9> kTurns = {1, 1, -1, -1, 1, -1, 1, -1, 1};  // 1 to the right

// Metres that a turn of a right angle takes: it runs its ramps at half the curvature.
double TurnLength(const PaperDriveOptions& options) {
  return 0.5 * std::numbers::pi * options.turn_radius + options.ramp;
}

double StraightLength(const PaperDriveOptions& options) {
  return (options.length - static_cast<double>(kTurns.size()) * TurnLength(options)) /
         static_cast<double>(kTurns.size() + 1);
}

// Integral over the way into a turn of a curvature that ramps up, holds and ramps down, in units of the full curvature.
double Steered(double way, double turn_length, double ramp) {
  const auto ramped = [ramp](double x) { return x <= 0 ? 0.0 : x < ramp ? 0.5 * x * x / ramp : x - 0.5 * ramp; };
  return ramped(way) - ramped(way - (turn_length - ramp));
}

// Heading (rad, to the right) after so many metres.
double HeadingAt(double way, const PaperDriveOptions& options) {
  double heading = 0;
  double begin = StraightLength(options);
  for (const int side : kTurns) {
    heading += side * Steered(way - begin, TurnLength(options), options.ramp) / options.turn_radius;
    begin += TurnLength(options) + StraightLength(options);
  }
  return heading;
}

// A small rotation about each axis.
Eigen::Quaterniond Disturbance(double sigma, Random& random) {
  const double x = random.Gaussian();
  const double y = random.Gaussian();
  const double z = random.Gaussian();
  return RotationFromVector(sigma * Eigen::Vector3d(x, y, z));
}

}  // namespace

void PaperDriveOptions::Check() const {
  if (frames < 2) throw InputError("frames: must be at least 2");
  if (!(rate_hz > 0)) throw InputError("rate_hz: must be above 0");
  if (!(turn_radius > 0)) throw InputError("turn_radius: must be above 0 m");
  if (!(ramp > 0 && 2 * ramp < TurnLength(*this)))
    throw InputError("ramp: must be above 0 m and fit into a turn twice");
  if (!(StraightLength(*this) >= 0)) throw InputError("length: must hold nine turns");
  if (!(lever_arm >= 0)) throw InputError("lever_arm: must not be negative");
}

void OdometryNoise::Check() const {
  if (!(rotation >= 0)) throw InputError("rotation: must not be negative");
  if (!(direction >= 0)) throw InputError("direction: must not be negative");
}

std::vector<AckermannStep> PaperDriveSteps(const PaperDriveOptions& options) {
  options.Check();
  const double rho = options.length / (options.frames - 1);
  std::vector<AckermannStep> steps;
  for (int i = 1; i < options.frames; ++i) {
    steps.push_back({HeadingAt(i * rho, options) - HeadingAt((i - 1) * rho, options), rho});
  }
  return steps;
}

Trajectory NoisyCameraPath(const std::vector<AckermannStep>& steps, const PaperDriveOptions& drive,
                           const OdometryNoise& noise) {
  drive.Check();
  noise.Check();
  Random random(noise.seed);
  Trajectory path{StampedPose{}};
  for (const AckermannStep& step : steps) {
    RigidTransform motion = ConstrainedCameraMotion(step, drive.lever_arm, drive.vehicle_from_camera);
    motion.rotation = motion.rotation * Disturbance(noise.rotation, random);
    motion.translation = Disturbance(noise.direction, random) * motion.translation;
    path.push_back({static_cast<double>(path.size()) / drive.rate_hz, path.back().world_from_camera * motion});
  }
  return path;
}

}  // namespace turnscale

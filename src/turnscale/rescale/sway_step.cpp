// SPDX-License-Identifier: MIT
#include "turnscale/rescale/sway_step.h"

#include <algorithm>
#include <cmath>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/turning_motion.h"

namespace turnscale {
namespace {

RigidTransform Motion(const Trajectory& trajectory, int first, int last) {
  return trajectory[first].world_from_camera.inverse() * trajectory[last].world_from_camera;
}

double Distance(const Trajectory& trajectory, int first, int last) {
  return (trajectory[last].world_from_camera.translation - trajectory[first].world_from_camera.translation).norm();
}

double TwistAboutZ(const Eigen::Quaterniond& rotation) {
  return std::remainder(2 * std::atan2(rotation.z(), rotation.w()), 2 * M_PI);
}

double OrdinaryLength(const Trajectory& trajectory, int spacing) {
  std::vector<double> lengths;
  for (int last = spacing; last < static_cast<int>(trajectory.size()); last += spacing) {
    lengths.push_back(Distance(trajectory, last - spacing, last));
  }
  return HalfSumValue(lengths);
}

// A motion in vehicle axes, pitched so that it goes neither up nor down half-way.
struct LevelMotion {
  TurningMotion turning;
  double roll = 0;
  double off_forward = 0;  // rad, before it was levelled
};

LevelMotion LevelMotionOf(const RigidTransform& motion, const Eigen::Quaterniond& vehicle_from_camera) {
  const Eigen::Quaterniond half_back = RotationFromVector(-0.5 * VectorFromRotation(motion.rotation));
  const Eigen::Vector3d travel = vehicle_from_camera * (half_back * motion.translation);
  LevelMotion level;
  level.off_forward = std::atan2(std::hypot(travel.x(), travel.y()), travel.z());
  Eigen::Quaterniond level_from_camera = vehicle_from_camera;
  if (travel.z() > 0) {
    level_from_camera = RotationFromVector({std::atan2(travel.y(), travel.z()), 0, 0}) * vehicle_from_camera;
  }
  level.turning = TurningMotionOf(motion, level_from_camera);
  level.roll = TwistAboutZ(level_from_camera * motion.rotation * level_from_camera.conjugate());
  return level;
}

SwayStep StepBetween(const Trajectory& trajectory, const Eigen::Quaterniond& vehicle_from_camera, int first, int last,
                     bool timed, double max_direction) {
  const LevelMotion motion = LevelMotionOf(Motion(trajectory, first, last), vehicle_from_camera);
  const TurningMotion& turning = motion.turning;
  SwayStep step{first, last, turning.psi, turning.step};
  step.sway = turning.step * std::sin(turning.theta - 0.5 * turning.psi);
  step.roll = motion.roll;
  if (timed) step.speed = turning.step / (trajectory[last].time - trajectory[first].time);
  step.forward = step.usable = motion.off_forward <= max_direction;
  return step;
}

double Pace(const SwayStep& step) { return step.speed > 0 ? step.speed : step.length; }

void MarkJumps(std::vector<SwayStep>& steps, int spacing, const KeySpacingOptions& options) {
  if (steps.empty()) return;
  std::vector<double> paces;
  for (const SwayStep& step : steps) paces.push_back(Pace(step));
  const double brisk = Quantile(std::move(paces), 0.8);
  for (SwayStep& step : steps) {
    const bool late = step.last - step.first > options.max_late * spacing;
    if (late || Pace(step) > options.max_speed_ratio * brisk) step.usable = false;
  }
}

}  // namespace

void KeySpacingOptions::Check() const {
  if (!(step_angle > 0 && step_angle < 0.5)) throw InputError("keys.step_angle: has to be above 0 and below 0.5 rad");
  if (max_spacing < 1) throw InputError("keys.max_spacing: has to be at least 1");
  if (!(min_length_share >= 0 && min_length_share < 1)) throw InputError("keys.min_length_share: has to be in 0...1");
  if (!(max_speed_ratio > 1)) throw InputError("keys.max_speed_ratio: has to be above 1");
  if (max_late < 1) throw InputError("keys.max_late: has to be at least 1");
  if (!(max_direction > 0)) throw InputError("keys.max_direction: has to be positive");
}

int KeySpacing(const Trajectory& trajectory, const Eigen::Quaterniond& vehicle_from_camera,
               const KeySpacingOptions& options) {
  options.Check();
  std::vector<double> angles;
  for (int i = 1; i < static_cast<int>(trajectory.size()); ++i) {
    angles.push_back(std::abs(LevelMotionOf(Motion(trajectory, i - 1, i), vehicle_from_camera).turning.psi));
  }
  const double wanted = options.step_angle / std::max(HalfSumValue(angles), 1e-9);
  return static_cast<int>(std::lround(std::clamp(wanted, 1.0, static_cast<double>(options.max_spacing))));
}

std::vector<SwayStep> SwaySteps(const Trajectory& trajectory, const Eigen::Quaterniond& vehicle_from_camera,
                                int spacing, bool timed, const KeySpacingOptions& options,
                                const std::vector<int>& gaps) {
  options.Check();
  std::vector<SwayStep> steps;
  const auto step_to = [&](int key, int i) {
    return StepBetween(trajectory, vehicle_from_camera, key, i, timed, options.max_direction);
  };
  const double shortest = options.min_length_share * OrdinaryLength(trajectory, spacing);
  auto gap = gaps.begin();
  int key = 0;
  for (int i = 1; i < static_cast<int>(trajectory.size()); ++i) {
    if (gap != gaps.end() && *gap == i) {
      ++gap;
      if (key < i - 1) {
        steps.push_back(step_to(key, i - 1));
        steps.back().usable = false;
      }
      steps.push_back({.first = i - 1, .last = i, .usable = false, .after_gap = true});
      key = i;
      continue;
    }
    if (i - key < spacing) continue;
    const double length = Distance(trajectory, key, i);
    if (length < shortest || length == 0) continue;
    steps.push_back(step_to(key, i));
    key = i;
  }
  MarkJumps(steps, spacing, options);
  return steps;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/odometry/constrained_turns.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "turnscale/kinematics/ackermann.h"
#include "turnscale/mapping/absolute_scale_recovery.h"
#include "turnscale/odometry/drive_steps.h"

namespace turnscale {
namespace {

std::vector<VehicleStep> KeyframeSteps(const Map& map, const MountCalibration& mount, const TurnResult& turn) {
  std::vector<VehicleStep> steps;
  for (int k = turn.first_keyframe; k < turn.last_keyframe; ++k)
    steps.push_back({StepMotion(map, k, mount), map.keyframes[k + 1].time - map.keyframes[k].time});
  return steps;
}

// Relative deviation of a step's inverse scale beyond which it is left out: in standard deviations of its turn's steps,
// and bounds. Where they scatter by a third, three deviations would let in steps of any length.
constexpr double kMostDeviations = 3;
constexpr double kLeastDeviation = 0.1;
constexpr double kMostDeviation = 0.5;

// Every step at the length that its own angles give; 0 where they contradict the model or the other steps of the turn,
// or where the step turns too little to be of F_t: its length would be noise. The length is the inverse of a small
// angle: a few steps whose angle is nearly zero would make the whole turn too long.
std::vector<double> ObservedDistances(const std::vector<VehicleStep>& steps, const LeverArm& lever_arm,
                                      double min_step_angle, const MedianScale& median) {
  const double most = std::clamp(kMostDeviations * median.spread, kLeastDeviation, kMostDeviation);
  std::vector<double> distances;
  for (const VehicleStep& step : steps) {
    const double distance = ObservedDistance(step.motion.psi, step.motion.theta, step.duration, lever_arm);
    const double by_median = median.metres_per_unit * step.motion.step;
    const bool agrees = distance > 0 && std::abs(by_median / distance - 1) <= most;
    const bool turns = std::abs(step.motion.psi) >= min_step_angle;
    distances.push_back(turns && agrees && std::isfinite(distance) ? distance : 0.0);
  }
  return distances;
}

}  // namespace

std::vector<TurnScale> TurnsToConstrain(const Map& map, const MountCalibration& mount, const OdometryOptions& options,
                                        std::vector<TurnResult>& turns) {
  const LeverArm lever_arm{options.vehicle.lever_arm.value_or(0), options.vehicle.side_slip};
  std::vector<TurnScale> held;
  const auto leave_out = [](TurnResult& turn, const char* reason) {
    turn.used = false;
    turn.reason = reason;
  };
  for (TurnResult& turn : turns) {
    if (!turn.used) continue;
    if (!turn.used_singly) {
      leave_out(turn, "its scale is much less certain than other turns'");
      continue;
    }
    TurnScale scale{.first_step = turn.first_keyframe + 1,
                    .last_step = turn.last_keyframe,
                    .factor = turn.as_given,
                    .distances = {}};
    if (options.scale.method == ScaleMethod::kPaper) {
      const std::vector<VehicleStep> steps = KeyframeSteps(map, mount, turn);
      const MedianScale median = MedianOfSteps(steps, lever_arm);
      if (!std::isfinite(median.metres_per_unit)) {
        leave_out(turn, "most of its steps are inconsistent with the vehicle model");
        continue;
      }
      scale.factor = median.metres_per_unit;
      scale.distances =
          ObservedDistances(steps, lever_arm, options.scale.estimator.segments.turns.min_step_angle, median);
    }
    held.push_back(scale);
  }
  return held;
}

std::vector<double> ConstrainTurns(const OdometryOptions& options, const MountCalibration& mount, Map& map,
                                   RefinedScale& refined) {
  if (!refined.estimate) return {};
  // One pose that is none would spoil the lengths of the whole map.
  if (!std::ranges::all_of(map.keyframes, [](const Keyframe& k) { return k.camera_from_world.IsFinite(); })) {
    for (TurnResult& turn : refined.turns)
      if (turn.used) turn.unadjusted = "a pose of the map is not finite";
    return {};
  }
  const std::vector<TurnScale> held = TurnsToConstrain(map, mount, options, refined.turns);
  if (held.empty()) return {};
  const ScaleRecoveryResult recovered = RecoverAbsoluteScale(options.scale.recovery, held, map);
  for (TurnResult& turn : refined.turns) {
    for (const RangeRecovery& range : recovered.ranges) {
      const bool around = range.range.first <= turn.first_keyframe && turn.first_keyframe < range.range.last;
      if (turn.used && around && !range.adjusted) turn.unadjusted = range.reason;
    }
  }
  refined.constrained = true;
  refined.path = {KeyframeCentres(map), std::vector<double>(map.keyframes.size(), 1.0)};
  return recovered.factors;
}

double DifferenceFromInterpolated(const Map& map, const RefinedScale& adjusted, const RefinedScale& interpolated) {
  constexpr double kMostSigmas = 2;
  // Keyframes of a section: noise of the steps cancels.
  constexpr std::size_t kSection = 20;
  const std::vector<Eigen::Vector3d>& centres = interpolated.path.centres;
  const std::vector<Eigen::Vector3d>& others = adjusted.path.centres;
  double length = 0;
  double difference = 0;
  double of_section = 0;
  for (std::size_t k = 1; k < centres.size(); ++k) {
    if (!map.keyframes[k].after_gap) {
      const double step = (centres[k] - centres[k - 1]).norm();
      length += step;
      of_section += (others[k] - others[k - 1]).norm() - step;
    }
    if (k % kSection != 0 && k + 1 < centres.size()) continue;
    difference += std::abs(of_section);
    of_section = 0;
  }
  return difference > kMostSigmas * interpolated.estimate->length_sigma * length ? difference / length : 0.0;
}

}  // namespace turnscale

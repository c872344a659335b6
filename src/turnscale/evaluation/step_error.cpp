// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/step_error.h"

#include <algorithm>
#include <cmath>

namespace turnscale {
namespace {

constexpr double kSameTime = 1e-3;  // seconds; a table may print fewer digits than a trajectory

RigidTransform Motion(const RigidTransform& world_from_first, const RigidTransform& world_from_last) {
  return world_from_first.inverse() * world_from_last;
}

double TurningAngle(const RigidTransform& motion, const Eigen::Quaterniond& vehicle_from_camera) {
  return TwistAboutY(vehicle_from_camera * motion.rotation * vehicle_from_camera.conjugate());
}

}  // namespace

std::vector<Step> StepsAlongPath(const PosePairs& pairs, const StepErrorOptions& options) {
  std::vector<Step> steps;
  int first = 0;
  double travel = 0;
  for (int i = 1; i < static_cast<int>(pairs.size()); ++i) {
    travel += (pairs[i].truth.translation - pairs[i - 1].truth.translation).norm();
    if (travel < options.length) continue;
    const double psi = TurningAngle(Motion(pairs[first].truth, pairs[i].truth), options.vehicle_from_camera);
    steps.push_back({first, i, std::abs(psi) > options.turning_angle});
    first = i;
    travel = 0;
  }
  return steps;
}

std::vector<Step> StepsBetweenKeyframes(const PosePairs& pairs, const std::vector<KeyframeRow>& keyframes,
                                        KeyframeKey key) {
  std::vector<Step> steps;
  int previous = -1;
  for (const KeyframeRow& row : keyframes) {
    const double wanted = key == KeyframeKey::kTime ? row.time : row.frame;
    const double tolerance = key == KeyframeKey::kTime ? kSameTime : 0.0;
    const auto found = std::lower_bound(pairs.begin(), pairs.end(), wanted - tolerance,
                                        [](const PosePair& pair, double value) { return pair.time < value; });
    if (found == pairs.end() || found->time > wanted + tolerance) continue;
    const auto place = static_cast<int>(found - pairs.begin());
    if (previous >= 0 && place > previous) steps.push_back({previous, place, row.turning});
    previous = place;
  }
  return steps;
}

StepErrors MeasureSteps(const PosePairs& pairs, const std::vector<Step>& steps, bool turning_only, double scale,
                        const StepErrorOptions& options) {
  std::vector<double> scale_errors;
  std::vector<double> psi_errors;
  for (const Step& step : steps) {
    if (turning_only && !step.turning) continue;
    const RigidTransform motion = Motion(pairs[step.first].estimate, pairs[step.last].estimate);
    const RigidTransform true_motion = Motion(pairs[step.first].truth, pairs[step.last].truth);
    psi_errors.push_back(std::remainder(
        TurningAngle(motion, options.vehicle_from_camera) - TurningAngle(true_motion, options.vehicle_from_camera),
        2 * M_PI));
    const double true_length = true_motion.translation.norm();
    if (true_length < options.shortest_length) continue;
    scale_errors.push_back((scale * motion.translation.norm() - true_length) / true_length);
  }
  return {Summarize(std::move(scale_errors)), Summarize(std::move(psi_errors))};
}

}  // namespace turnscale

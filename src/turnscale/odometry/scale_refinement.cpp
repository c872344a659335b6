// SPDX-License-Identifier: MIT
#include "turnscale/odometry/scale_refinement.h"

#include <string>
#include <utility>

#include "turnscale/odometry/drive_steps.h"
#include "turnscale/scale/scale_estimator.h"
#include "turnscale/scale/scale_track.h"

namespace turnscale {
namespace {

// Leaves the turns.
void ForgetScale(const std::string& reason, ScaleEstimateResult& result) {
  result.estimate.reset();
  result.reason = reason;
  for (TurnEstimate& turn : result.detected_turns) {
    turn.used = turn.used_singly = false;
    turn.reason = reason;
    turn.own = turn.own_relative_sigma = turn.as_given = 0;
  }
}

MetricPath InOwnUnit(const Map& map) {
  MetricPath path;
  for (int k = 0; k < CountKeyframes(map); ++k) path.centres.push_back(KnownCentre(map, k));
  path.metres_per_unit.assign(map.keyframes.size(), 1.0);
  return path;
}

}  // namespace

RefinedScale RefineScale(const Map& map, const MountCalibration& mount, const std::vector<MeasuredHeight>& heights,
                         const OdometryOptions& options, CalibrationVerdict calibration) {
  RefinedScale refined;
  const int count = CountKeyframes(map);
  refined.path = InOwnUnit(map);
  refined.keyframes.resize(count);
  const std::vector<VehicleStep> steps = StepsAlong(map, mount, heights, options);
  if (steps.empty()) {
    refined.reason = "the trajectory has no usable step";
    return refined;
  }
  ScaleEstimatorOptions estimator = options.scale.estimator;
  estimator.uses_single_turns = estimator.uses_single_turns || calibration == CalibrationVerdict::kContradicted ||
                                options.scale.method != ScaleMethod::kSmoothed;
  StabilisationOptions& stabilisation = estimator.stabilisation;
  stabilisation.enabled = stabilisation.enabled && calibration != CalibrationVerdict::kContradicted;
  stabilisation.adopts_lag = stabilisation.adopts_lag && calibration == CalibrationVerdict::kNotContradicted;
  ScaleEstimateResult result = EstimateScale(steps, PriorOf(options.vehicle, mount.current()), estimator);
  if (!HasMetres(options.vehicle)) ForgetScale("no lever arm given", result);
  const auto frame_of = [&](int keyframe) { return map.keyframes[keyframe].frame; };
  for (const TurnEstimate& turn : result.estimate ? result.estimate->turns : result.detected_turns) {
    const TurnResult& described = refined.turns.emplace_back(TurnResultOf(turn, steps, frame_of));
    for (int k = described.first_keyframe + 1; k <= described.last_keyframe; ++k) refined.keyframes[k].turning = true;
  }
  refined.reason = result.reason;
  if (!result.estimate) return refined;
  const std::vector<PoseScale> scales = ScaleTrack(count, steps, *result.estimate);
  refined.path.centres = MetricPositions(refined.path.centres, scales);
  for (int k = 0; k < count; ++k) {
    refined.path.metres_per_unit[k] = scales[k].metres_per_unit;
    refined.keyframes[k].sigma = scales[k].sigma;
    refined.keyframes[k].state = scales[k].from_road ? ScaleState::kFromRoad : ScaleState::kHeld;
  }
  for (const TurnResult& turn : refined.turns)
    for (int k = turn.first_keyframe; turn.used && k <= turn.last_keyframe; ++k)
      refined.keyframes[k].state = ScaleState::kObserved;
  refined.estimate = std::move(result.estimate);
  return refined;
}

TurnResult TurnResultOf(const TurnEstimate& turn, const std::vector<VehicleStep>& steps,
                        const std::function<int(int keyframe)>& frame_of) {
  TurnResult result;
  result.first_keyframe = steps[turn.first_step].first;
  result.last_keyframe = steps[turn.last_step].last;
  result.first_frame = frame_of(result.first_keyframe);
  result.last_frame = frame_of(result.last_keyframe);
  result.angle = turn.angle;
  result.used = turn.used;
  result.reason = turn.reason;
  result.speed = turn.speed_units * turn.smoothed;
  result.own = turn.own;
  result.as_given = turn.as_given;
  result.used_singly = turn.used_singly;
  result.own_sigma = turn.own_relative_sigma * turn.own;
  result.smoothed = turn.smoothed;
  result.smoothed_sigma = turn.smoothed_relative_sigma * turn.smoothed;
  result.deviation = turn.deviation;
  result.effective_lever_arm = turn.lever_arm_units * turn.smoothed;
  return result;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/rescale/rescale.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "turnscale/base/error.h"
#include "turnscale/rescale/camera_mount.h"

namespace turnscale {
namespace {

void CheckTrajectory(const Trajectory& trajectory, bool timed) {
  if (trajectory.size() < 2) throw InputError("the trajectory has fewer than two poses");
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const RigidTransform& pose = trajectory[i].world_from_camera;
    if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite()) {
      throw InputError("pose " + std::to_string(i) + " is not finite");
    }
    if (timed && i > 0 && !(trajectory[i].time > trajectory[i - 1].time)) {
      throw InputError("the time of pose " + std::to_string(i) + " does not come after the one before");
    }
  }
}

CarPrior CarFor(const RescaleOptions& options) {
  CarPrior car = options.car;
  if (!options.timed) car.side_slip = car.side_slip_sigma = 0;
  return car;
}

/// Where a pose lies among the stretches, for interpolating between their middles.
struct Place {
  std::size_t before = 0;  // stretch
  std::size_t after = 0;
  double share = 0;       // of `after`
  std::size_t ended = 0;  // number of stretches that had ended by then
};

// Poses between two keys lie evenly between them; those behind the last key, at it.
std::vector<double> PlacesAlongPath(std::size_t poses, const std::vector<SwayStep>& steps) {
  std::vector<double> places(poses, 0);
  double length = 0;
  for (const SwayStep& step : steps) {
    for (int i = step.first; i <= step.last; ++i) {
      places[i] = length + step.length * (i - step.first) / (step.last - step.first);
    }
    length += step.length;
  }
  for (std::size_t i = steps.back().last + 1; i < poses; ++i) places[i] = length;
  return places;
}

std::vector<Place> PlacesAmong(const std::vector<Stretch>& stretches, const std::vector<double>& along) {
  std::vector<Place> places;
  places.reserve(along.size());
  std::size_t next = 0;  // first stretch whose middle is not passed
  std::size_t ended = 0;
  for (const double at : along) {
    while (next < stretches.size() && stretches[next].middle <= at) ++next;
    while (ended < stretches.size() && stretches[ended].middle + 0.5 * stretches[ended].length <= at) ++ended;
    Place place{next == 0 ? 0 : next - 1, std::min(next, stretches.size() - 1), 0, ended};
    if (place.after != place.before) {
      const double gap = stretches[place.after].middle - stretches[place.before].middle;
      place.share = (at - stretches[place.before].middle) / gap;
    }
    places.push_back(place);
  }
  return places;
}

class Results {
 public:
  Results(const RescaleOptions& options, const Trajectory& trajectory, const std::vector<SwayStep>& steps,
          const std::vector<Stretch>& stretches, const ScaleEstimate& estimate)
      : options_(options), trajectory_(trajectory), steps_(steps), stretches_(stretches), estimate_(estimate) {}

  void ScalePoses(RescaleResult& result) const {
    std::size_t first_turn = 0;
    while (!stretches_[first_turn].turning) ++first_turn;
    for (const Place& place : PlacesAmong(stretches_, PlacesAlongPath(trajectory_.size(), steps_))) {
      const Belief& before = estimate_.smoothed[place.before];
      const Belief& after = estimate_.smoothed[place.after];
      const auto between = [&](double a, double b) { return (1 - place.share) * a + place.share * b; };
      PoseScale scale;
      scale.metres_per_unit = std::exp(between(before.mean[kLogScale], after.mean[kLogScale]));
      scale.sigma = std::hypot(between(SigmaOf(before), SigmaOf(after)), options_.lever_arm_sigma);
      if (place.ended > first_turn) {
        const Belief& live = estimate_.causal[place.ended - 1];
        scale.live_metres_per_unit = std::exp(live.mean[kLogScale]);
        scale.live_sigma = std::hypot(SigmaOf(live), options_.lever_arm_sigma);
      }
      result.poses.push_back(scale);
    }
  }

  void DescribeTurns(RescaleResult& result) const {
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      if (stretches_[i].turning) result.turns.push_back(Describe(i));
    }
  }

  void DescribeCar(RescaleResult& result) const {
    const Belief& last = estimate_.smoothed.back();
    const auto sigma = [&](DriveUnknown unknown) { return std::sqrt(last.covariance(unknown, unknown)); };
    result.yaw_error = -last.mean[kTravel];
    result.yaw_error_sigma = sigma(kTravel);
    result.side_slip = std::max(last.mean[kSlip], 0.0);
    result.side_slip_sigma = options_.timed ? sigma(kSlip) : 0;
    result.height = last.mean[kHeight];
    result.height_sigma = sigma(kHeight);
    result.noise = estimate_.noise;
    result.sway_sigma = estimate_.sway_sigma * std::exp(last.mean[kLogScale]);
  }

 private:
  static double SigmaOf(const Belief& belief) { return std::sqrt(belief.covariance(kLogScale, kLogScale)); }

  RescaledTurn Describe(std::size_t i) const {
    const Stretch& stretch = stretches_[i];
    const StretchObservation& observation = estimate_.problem.observations[i];
    const DriveState& state = estimate_.smoothed[i].mean;
    const double lever_arm = estimate_.problem.lever_arm;
    RescaledTurn turn;
    turn.first_pose = steps_[stretch.first].first;
    turn.last_pose = steps_[stretch.last].last;
    turn.angle = stretch.angle;
    turn.smoothed = std::exp(state[kLogScale]);
    turn.smoothed_sigma = std::hypot(SigmaOf(estimate_.smoothed[i]), options_.lever_arm_sigma);
    turn.metres_per_unit = ScaleOfStretch(observation.pooled, state, lever_arm).value_or(0);
    const ScaleEvidence evidence = EvidenceAt(observation, state, lever_arm, estimate_.noise.stretch);
    turn.used = observation.turning;
    if (turn.used) turn.sigma = 1 / std::sqrt(evidence.information(kLogScale, kLogScale));
    const Eigen::Matrix4d& pooled = observation.pooled.information;
    const Eigen::Vector4d coefficients = SwayCoefficients(state, lever_arm);
    const double lever_part =
        observation.pooled.target[0] - pooled(0, 2) * coefficients[2] - pooled(0, 3) * coefficients[3];
    turn.effective_lever_arm = turn.smoothed * lever_part / pooled(0, 0);
    turn.speed = turn.smoothed * std::sqrt(MeanSquareSpeed(observation.pooled));
    turn.weight = observation.lever_weight;
    return turn;
  }

  const RescaleOptions& options_;
  const Trajectory& trajectory_;
  const std::vector<SwayStep>& steps_;
  const std::vector<Stretch>& stretches_;
  const ScaleEstimate& estimate_;
};

// Steps, each at the mean of its ends' scales, put together again.
Trajectory MetricTrajectory(const Trajectory& trajectory, const std::vector<PoseScale>& scales) {
  Trajectory metric = trajectory;
  metric[0].world_from_camera.translation *= scales[0].metres_per_unit;
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    const Eigen::Vector3d step =
        trajectory[i].world_from_camera.translation - trajectory[i - 1].world_from_camera.translation;
    const double scale = 0.5 * (scales[i - 1].metres_per_unit + scales[i].metres_per_unit);
    metric[i].world_from_camera.translation = metric[i - 1].world_from_camera.translation + scale * step;
  }
  return metric;
}

double BestSigma(const std::vector<PoseScale>& poses) {
  return std::min_element(poses.begin(), poses.end(), [](const auto& a, const auto& b) { return a.sigma < b.sigma; })
      ->sigma;
}

std::string UncertainReason(double sigma, double max_sigma) {
  char text[160];
  std::snprintf(text, sizeof text, "its turns leave the scale uncertain by %.0f %%, more than %.0f", 100 * sigma,
                100 * max_sigma);
  return text;
}

// Leaves the reason why there is none.
bool FindMount(const RescaleOptions& options, const Trajectory& trajectory, RescaleResult& result) {
  try {
    result.vehicle_from_camera =
        options.vehicle_from_camera ? *options.vehicle_from_camera : FindCameraMount(trajectory, options.timed);
    return true;
  } catch (const InputError& error) {
    result.reason = error.what();
    return false;
  }
}

bool GoesForward(const std::vector<SwayStep>& steps) {
  const auto forward = std::count_if(steps.begin(), steps.end(), [](const SwayStep& step) { return step.forward; });
  return 2 * forward >= static_cast<std::ptrdiff_t>(steps.size());
}

}  // namespace

void RescaleOptions::Check() const {
  car.Check();
  keys.Check();
  stretches.Check();
  estimator.Check();
  if (!(lever_arm_sigma >= 0 && lever_arm_sigma < 1)) throw InputError("lever_arm_sigma: has to be from 0 to below 1");
  if (!(max_scale_sigma > 0)) throw InputError("max_scale_sigma: has to be positive");
}

RescaleResult RescaleTrajectory(const RescaleOptions& options, const Trajectory& trajectory) {
  options.Check();
  CheckTrajectory(trajectory, options.timed);
  RescaleResult result;
  if (!FindMount(options, trajectory, result)) return result;
  result.key_spacing = KeySpacing(trajectory, result.vehicle_from_camera, options.keys);
  const std::vector<SwayStep> steps =
      SwaySteps(trajectory, result.vehicle_from_camera, result.key_spacing, options.timed, options.keys);
  if (!GoesForward(steps)) {
    result.reason = "most of its steps go sideways, up, down or backwards: its axes are not x right, y down, z forward";
    return result;
  }
  const std::vector<Stretch> stretches = SplitIntoStretches(steps, options.stretches);
  if (std::none_of(stretches.begin(), stretches.end(), [](const Stretch& stretch) { return stretch.turning; })) {
    result.reason = "it has no turn";
    return result;
  }
  const auto estimate = EstimateScale(steps, stretches, CarFor(options), options.estimator);
  if (!estimate) {
    result.reason = "in no turn slow enough the camera swings outwards as its lever arm demands";
    return result;
  }
  const Results results(options, trajectory, steps, stretches, *estimate);
  results.DescribeTurns(result);
  results.DescribeCar(result);
  results.ScalePoses(result);
  if (const double sigma = BestSigma(result.poses); !(sigma <= options.max_scale_sigma)) {
    result.poses.clear();
    result.reason = UncertainReason(sigma, options.max_scale_sigma);
    return result;
  }
  result.metric = MetricTrajectory(trajectory, result.poses);
  for (const SwayStep& step : steps) result.length += step.length * result.poses[step.last].metres_per_unit;
  result.observable = true;
  return result;
}

}  // namespace turnscale

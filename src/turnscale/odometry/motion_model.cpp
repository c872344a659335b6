// SPDX-License-Identifier: MIT
#include "turnscale/odometry/motion_model.h"

#include <algorithm>
#include <cmath>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// A speed is the mean over at least so many seconds: that of one short step is noisy.
constexpr double kSpeedSeconds = 0.2;
// A speed that falls below this share of itself from one measurement to the next has broken off.
constexpr double kBreak = 0.5;
// Below this share of the speed kept already, what breaks off is the noise of standing still.
constexpr double kNoise = 0.1;
// A car that brakes is slower than this share of its speed so many seconds before, when it stops.
constexpr double kBraking = 0.5;
constexpr double kBrakingSeconds = 2;
// Deviation from the expected turn after which little of what was seen is left in the image, radians.
constexpr double kMostTurnReach = 0.5;
// A prediction is put together from at most so many steps.
constexpr double kMostSteps = 1000;

// The seconds that motion which decays goes on for, out of those that pass.
double Effective(double steady, double decay, double seconds) {
  return seconds <= steady ? seconds : steady + decay * -std::expm1(-(seconds - steady) / decay);
}

// The seconds in which motion that decays goes on for so many.
double SecondsFor(double steady, double decay, double effective) {
  return effective <= steady ? effective : steady - decay * std::log1p(-(effective - steady) / decay);
}

}  // namespace

void MotionModelOptions::Check() const {
  if (!(steady_seconds >= 0)) throw InputError("steady_seconds: must not be negative");
  if (!(turn_seconds > 0)) throw InputError("turn_seconds: has to be positive");
  if (!(turn_acceleration >= 0)) throw InputError("turn_acceleration: must not be negative");
  if (!(swing_seconds >= 0)) throw InputError("swing_seconds: must not be negative");
  if (!(travel_seconds > 0)) throw InputError("travel_seconds: has to be positive");
  if (!(speed_sigma > 0)) throw InputError("speed_sigma: has to be positive");
  if (!(speed_sigma_per_second >= 0)) throw InputError("speed_sigma_per_second: must not be negative");
  if (!(acceleration_in_depths >= 0)) throw InputError("acceleration_in_depths: must not be negative");
  if (!(gap_turn_on_straights > 0)) throw InputError("gap_turn_on_straights: has to be positive");
  if (!(gap_turn_in_turns >= 0)) throw InputError("gap_turn_in_turns: must not be negative");
  if (!(gap_corner >= 0)) throw InputError("gap_corner: must not be negative");
  if (!(gap_corner_speed > 0)) throw InputError("gap_corner_speed: has to be positive");
  if (!(max_gap_turn > 0)) throw InputError("max_gap_turn: has to be positive");
  if (!(max_gap_corner >= 0)) throw InputError("max_gap_corner: must not be negative");
}

double GapTurnSigma(const MotionModelOptions& options, double seconds, double rate, std::optional<double> speed) {
  const double squared = seconds * seconds;
  const double usual = squared * std::hypot(options.gap_turn_on_straights, options.gap_turn_in_turns * rate);
  const double slowness = options.gap_corner_speed / std::max(speed.value_or(0), options.gap_corner_speed);
  const double corner = squared * options.gap_corner * slowness * slowness;
  return std::hypot(std::min(usual, options.max_gap_turn), std::min(corner, options.max_gap_corner));
}

// Step by step of the length measured, so that a turn bends the path as it goes on.
RigidTransform MotionModel::Extrapolate(const Step& step, double seconds) const {
  const double steps = std::clamp(std::ceil(seconds / step.seconds - 1e-6), 1.0, kMostSteps);
  Rates rates = {VectorFromRotation(step.current_from_previous.rotation) / step.seconds,
                 step.current_from_previous.translation / step.seconds};
  RigidTransform pose = camera_from_world_;
  double turned = 0;
  double swung = 0;
  double travelled = 0;
  for (int i = 1; i <= static_cast<int>(steps); ++i) {
    const double passed = seconds * i / steps;
    const double turning = Effective(options_.steady_seconds, options_.turn_seconds, passed);
    const double swinging = i == 1 ? turning : std::max(swung, std::min(turning, options_.swing_seconds));
    const double travelling = Effective(options_.steady_seconds, options_.travel_seconds, passed);
    const Eigen::Vector3d upright = vertical_.dot(rates.turn) * vertical_;
    const Eigen::Vector3d turn = (turning - turned) * upright + (swinging - swung) * (rates.turn - upright);
    pose = RigidTransform{RotationFromVector(turn), (travelling - travelled) * rates.velocity} * pose;
    turned = turning;
    swung = swinging;
    travelled = travelling;
    rates = step.mean;
  }
  return pose;
}

// Faster about the vertical by `rate`, rad/s.
MotionModel::Step MotionModel::Turning(Step step, double rate) const {
  step.current_from_previous.rotation =
      RotationFromVector(VectorFromRotation(step.current_from_previous.rotation) + rate * step.seconds * vertical_);
  step.mean.turn += rate * vertical_;
  return step;
}

RigidTransform MotionModel::Predict(double time) const {
  return step_ ? Extrapolate(*step_, time - last_measured_time_) : camera_from_world_;
}

std::vector<RigidTransform> MotionModel::OtherPredictions(double time) const {
  std::vector<RigidTransform> others;
  if (step_) others.push_back(camera_from_world_);
  if (broken_off_) others.push_back(Extrapolate(broken_off_->step, time - last_measured_time_));
  if (!step_ || options_.turn_acceleration == 0) return others;
  for (const double share : {-1.0, 1.0, -0.5, 0.5}) {
    others.push_back(Extrapolate(Turning(*step_, share * options_.turn_acceleration * (time - last_measured_time_)),
                                 time - last_measured_time_));
  }
  return others;
}

double MotionModel::TurnReach(double time) const {
  return step_ ? std::min(options_.turn_acceleration * (time - last_measured_time_) * (time - last_measured_time_),
                          kMostTurnReach)
               : 0.0;
}

RigidTransform MotionModel::PredictOtherwise(double time, double turn, double speed_share) const {
  if (!step_) return camera_from_world_;
  const double turning = Effective(options_.steady_seconds, options_.turn_seconds, time - last_measured_time_);
  Step step = Turning(*step_, turn / turning);
  step.Scale(speed_share);
  return Extrapolate(step, time - last_measured_time_);
}

RigidTransform MotionModel::PredictAcross(double time, double rate, std::optional<double> turn) const {
  const double seconds = time - last_measured_time_;
  if (!step_ || !(seconds > 0)) return camera_from_world_;
  const auto turning = [&](double passed) { return Effective(options_.steady_seconds, options_.turn_seconds, passed); };
  const double before = turning_rate();
  // Each rate lasts for half of the gap, or for less where the car has turned less.
  double lasting = 0.5 * seconds;
  if (turn && before + rate != 0) {
    const double effective = std::clamp(*turn / (before + rate), 0.0, turning(lasting));
    lasting = std::min(SecondsFor(options_.steady_seconds, options_.turn_seconds, effective), lasting);
  }
  const double rest = turn ? *turn - (before + rate) * turning(lasting) : 0.0;
  const auto heading = [&](double passed) {
    return before * turning(std::min(passed, lasting)) +
           rate * (turning(lasting) - turning(std::min(seconds - passed, lasting))) + rest * passed / seconds;
  };
  const double steps = std::clamp(std::ceil(seconds / step_->seconds), 1.0, kMostSteps);
  RigidTransform pose = camera_from_world_;
  double turned = 0;
  double travelled = 0;
  for (int i = 1; i <= static_cast<int>(steps); ++i) {
    const double passed = seconds * i / steps;
    const double travelling = Effective(options_.steady_seconds, options_.travel_seconds, passed);
    const Eigen::Vector3d turns = (heading(passed) - turned) * vertical_;
    pose = RigidTransform{RotationFromVector(turns), (travelling - travelled) * step_->mean.velocity} * pose;
    turned = heading(passed);
    travelled = travelling;
  }
  return pose;
}

double MotionModel::TurnSigmaAcross(double time, double rate, std::optional<double> metres_per_unit) const {
  const auto metric = metres_per_unit ? std::optional(*metres_per_unit * speed()) : std::nullopt;
  return GapTurnSigma(options_, time - last_measured_time_, std::max(std::abs(rate), std::abs(turning_rate())), metric);
}

void MotionModel::Update(double time, const RigidTransform& camera_from_world, bool after_repeats) {
  if (started_ && time > last_measured_time_) {
    Step step{camera_from_world * camera_from_world_.inverse(), time - last_measured_time_, {}};
    // After a restart, the step is one from before it: what it was compared with would be a change across the gap, and
    // speed() is 0, as no speed of the new map is known yet.
    if (step_ && !recent_.empty() && step.speed() < kBreak * step_->speed() &&
        !(broken_off_ && step_->speed() < kNoise * broken_off_->past.speed))
      broken_off_ = {*step_,
                     {speed(), last_measured_time_},
                     after_repeats && step.speed() < kNoise * speed() && speed() > kBraking * peak_speed_};
    const Eigen::Vector3d& translation = step.current_from_previous.translation;
    Remember({translation.norm(), step.seconds, VectorFromRotation(step.current_from_previous.rotation), translation});
    peak_speed_ = std::max(speed(), peak_speed_ * std::exp(-step.seconds / kBrakingSeconds));
    const Travel recent = Recent();
    step.mean = {recent.turn / recent.seconds, recent.translation / recent.seconds};
    step_ = step;
    if (broken_off_ && broken_off_->past.time < last_measured_time_) {
      // It moves again.
      broken_off_->at_once = broken_off_->at_once && step.speed() <= kNoise * broken_off_->past.speed;
      if (step.speed() > kBreak * broken_off_->past.speed) broken_off_.reset();
    }
  }
  started_ = true;
  last_measured_time_ = time;
  camera_from_world_ = camera_from_world;
}

void MotionModel::Remember(const Travel& travel) {
  recent_.push_back(travel);
  double seconds = 0;
  for (const Travel& each : recent_) seconds += each.seconds;
  for (; seconds - recent_.front().seconds > 0.999 * kSpeedSeconds; recent_.pop_front())
    seconds -= recent_.front().seconds;
}

void MotionModel::Restart(double time, const RigidTransform& camera_from_world) {
  recent_.clear();
  peak_speed_ = 0;
  broken_off_.reset();
  started_ = true;
  last_measured_time_ = time;
  camera_from_world_ = camera_from_world;
}

void MotionModel::Stop() {
  step_.reset();
  recent_.clear();
}

std::optional<double> MotionModel::StoppedAtOnce() const {
  return broken_off_ && broken_off_->at_once ? std::optional(broken_off_->past.time) : std::nullopt;
}

void MotionModel::GoOn() {
  Ensure(broken_off_.has_value(), "the motion has not broken off");
  recent_.clear();
  step_ = broken_off_->step;
  last_measured_time_ = broken_off_->past.time;
}

void MotionModel::Correct(const RigidTransform& camera_from_world, double factor) {
  camera_from_world_ = camera_from_world;
  peak_speed_ *= factor;
  if (step_) step_->Scale(factor);
  for (Travel& travel : recent_) {
    travel.length *= factor;
    travel.translation *= factor;
  }
  if (!broken_off_) return;
  broken_off_->step.Scale(factor);
  broken_off_->past.speed *= factor;
}

MotionModel::Travel MotionModel::Recent() const {
  Travel sum;
  for (const Travel& travel : recent_) {
    sum.length += travel.length;
    sum.seconds += travel.seconds;
    sum.turn += travel.turn;
    sum.translation += travel.translation;
  }
  return sum;
}

double MotionModel::speed() const {
  const Travel recent = Recent();
  return recent.seconds > 0 ? recent.length / recent.seconds : 0.0;
}

std::vector<PastSpeed> MotionModel::PastSpeeds() const {
  std::vector<PastSpeed> speeds;
  if (speed() > 0) speeds.push_back({speed(), last_measured_time_});
  if (broken_off_) speeds.push_back(broken_off_->past);
  return speeds;
}

double MotionModel::SpeedSigma(const PastSpeed& past, double time, double depth) const {
  const double growth = std::max(options_.speed_sigma_per_second, options_.acceleration_in_depths * depth / past.speed);
  return std::hypot(options_.speed_sigma, growth * (time - past.time));
}

}  // namespace turnscale

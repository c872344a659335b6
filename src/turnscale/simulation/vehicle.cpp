// SPDX-License-Identifier: MIT
#include "turnscale/simulation/vehicle.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/range_check.h"
#include "turnscale/simulation/reference_path.h"

namespace turnscale {
namespace {

// Of the suspension; it rests at a thousandth of a pixel to a camera of 1000 pixels.
constexpr double kDamping = 0.4;
constexpr double kRestAngle = 1e-6;
constexpr double kRestRate = 1e-5;

// Of the road's unevenness, metres.
constexpr int kWaves = 24;
constexpr double kShortestWave = 2;
constexpr double kLongestWave = 25;

constexpr double kGravity = 9.81;
constexpr double kInterval = 0.002;
constexpr double kTrackWidth = 1.5;
// The wheels follow the driver's wish with this delay, seconds.
constexpr double kSteeringDelay = 0.08;
// Share of the speed by which a metre ahead of or behind the plan is made up for, and its bound.
constexpr double kProgressGain = 0.2;
constexpr double kMaxProgressGain = 0.03;
// Beyond this many metres from the path it has not been followed.
constexpr double kMaxStray = 1.0;
constexpr double kMaxLegGap = 0.5;

/// A drive in the making.
class Driver {
 public:
  Driver(const CarOptions& options, const RoadHeight& road, double axle_height, unsigned seed)
      : options_(options),
        road_(road),
        axle_height_(axle_height),
        pitch_noise_(2ULL * seed),
        roll_noise_(2ULL * seed + 1) {}

  /// Puts the car on the path's start.
  void Start(const ReferencePath& path, double direction, double speed) {
    const PathPlace start = PlaceAt(path, 0);
    state_.position = start.position;
    state_.heading = std::remainder(start.heading + (direction < 0 ? M_PI : 0), 2 * M_PI);
    state_.speed = direction * speed;
    state_.steering = std::atan(options_.wheelbase * direction * start.curvature);
    SetDependents();
    state_.heading -= state_.slip;
    SetPose();
    states_.push_back(state_);
  }

  /// Drives along the path at the planned speeds. Returns how far along it the car loses it, metres; nothing where it
  /// comes to the end.
  std::optional<double> Follow(const ReferencePath& path, double direction, const std::vector<double>& speeds) {
    double planned = 0;
    double progress = Project(path, state_.position, 0);
    for (std::size_t i = 1; i < speeds.size(); ++i) {
      const double behind = std::clamp(kProgressGain * (planned - progress), -kMaxProgressGain, kMaxProgressGain);
      const double steering = Steer(path, progress, direction);
      Advance(direction * speeds[i] * (1 + behind), steering);
      planned += 0.5 * kInterval * (speeds[i - 1] + speeds[i]);
      progress = Project(path, state_.position, progress + speeds[i] * kInterval);
      if ((PlaceAt(path, progress).position - state_.position).norm() >= kMaxStray) return progress;
    }
    return std::nullopt;
  }

  void Wait(double seconds) {
    const double steps = std::round(seconds / kInterval);
    for (double i = 0; i < steps; ++i) Advance(state_.speed, state_.steering);
  }

  std::vector<VehicleState> TakeStates() { return std::move(states_); }

 private:
  /// Steering angle at the end of a step: the way's curvature ahead, corrected by where the car is off.
  double Steer(const ReferencePath& path, double progress, double direction) const {
    const double speed = std::abs(state_.speed);
    if (speed == 0) return state_.steering;
    const PathPlace place = PlaceAt(path, progress);
    const Eigen::Vector2d right(std::cos(place.heading), -std::sin(place.heading));
    const double offset = (state_.position - place.position).dot(right);
    // Slip turns the line of travel outwards of the heading; what the heading has to do is therefore what the way does
    // a little further on.
    const double slip_length = options_.SideSlip() * state_.speed * state_.speed;
    const double heading = state_.heading - (direction < 0 ? M_PI : 0);
    const double heading_error = std::remainder(heading - (place.heading + slip_length * place.curvature), 2 * M_PI);
    const double curvature = PlaceAt(path, progress + slip_length + speed * kSteeringDelay).curvature;
    // Errors die away over this length, critically damped; it leaves the wheels time to turn.
    const double length = 1.0 + 0.3 * speed;
    const double wish = curvature - 2 * heading_error / length - offset / (length * length);
    const double limit = options_.max_steering_deg / kDegreesPerRadian;
    const double target = std::clamp(std::atan(options_.wheelbase * direction * wish), -limit, limit);
    const double rate = options_.max_steering_rate_deg / kDegreesPerRadian;
    return state_.steering + kInterval * std::clamp((target - state_.steering) / kSteeringDelay, -rate, rate);
  }

  /// Moves the car to the next moment, at which it has this speed and steering angle.
  void Advance(double speed, double steering) {
    const VehicleState before = state_;
    state_.time = static_cast<double>(states_.size()) * kInterval;
    state_.speed = speed;
    state_.steering = steering;
    SetDependents();
    state_.heading += 0.5 * kInterval * (before.yaw_rate + state_.yaw_rate);
    state_.position += 0.5 * kInterval * (Velocity(before) + Velocity(state_));
    distance_ += 0.5 * kInterval * std::abs(before.speed + speed);

    const double forward = (speed - before.speed) / kInterval;
    const double sideways = speed * state_.yaw_rate;
    const double radians_per_degree_and_g = 1 / (kDegreesPerRadian * kGravity);
    pitch_.Step(options_.pitch_deg_per_g * radians_per_degree_and_g * forward, options_.suspension_hz, kInterval);
    roll_.Step(-options_.roll_deg_per_g * radians_per_degree_and_g * sideways, options_.suspension_hz, kInterval);
    SetPose();
    states_.push_back(state_);
  }

  void SetDependents() {
    state_.yaw_rate = state_.speed * std::tan(state_.steering) / options_.wheelbase;
    state_.slip = -std::atan(options_.SideSlip() * std::abs(state_.speed) * state_.yaw_rate);
  }

  static Eigen::Vector2d Velocity(const VehicleState& state) {
    const Eigen::Vector2d ahead(std::sin(state.heading), std::cos(state.heading));
    const Eigen::Vector2d right(ahead.y(), -ahead.x());
    return state.speed * (ahead + std::tan(state.slip) * right);
  }

  void SetPose() {
    const Eigen::Vector2d& here = state_.position;
    const Eigen::Vector2d ahead(std::sin(state_.heading), std::cos(state_.heading));
    const Eigen::Vector2d right(ahead.y(), -ahead.x());
    const double height = road_(here);
    const double front = road_(here + options_.wheelbase * ahead);
    const double right_side = road_(here + 0.5 * kTrackWidth * right);
    const double left_side = road_(here - 0.5 * kTrackWidth * right);
    const double noise = options_.road_noise_deg / kDegreesPerRadian * RoadNoiseGain(state_.speed);
    YawPitchRoll angles;
    angles.yaw = state_.heading;
    angles.pitch = std::atan2(front - height, options_.wheelbase) + pitch_.angle + noise * pitch_noise_.At(distance_);
    angles.roll = std::atan2(left_side - right_side, kTrackWidth) + roll_.angle + noise * roll_noise_.At(distance_);
    state_.world_from_vehicle.rotation = RotationFromYawPitchRoll(angles);
    state_.world_from_vehicle.translation = {here.x(), -(height + axle_height_), here.y()};
  }

  const CarOptions& options_;
  const RoadHeight& road_;
  double axle_height_;
  RoadNoise pitch_noise_;
  RoadNoise roll_noise_;
  Suspension pitch_;
  Suspension roll_;
  double distance_ = 0;
  VehicleState state_;
  std::vector<VehicleState> states_;
};

void CheckLegs(const std::vector<RouteLeg>& legs) {
  Ensure(!legs.empty(), "a drive has a leg at least");
  for (std::size_t i = 0; i < legs.size(); ++i) {
    legs[i].Check();
    Ensure(i == 0 || (legs[i].points.front() - legs[i - 1].points.back()).norm() <= kMaxLegGap,
           "a leg starts where the one before ends");
  }
}

}  // namespace

VehicleMotion::VehicleMotion(std::vector<VehicleState> states, double interval)
    : states_(std::move(states)), interval_(interval) {
  Ensure(!states_.empty(), "a motion has states");
  Ensure(interval > 0, "states of a motion are some time apart");
}

double VehicleMotion::duration() const { return static_cast<double>(states_.size() - 1) * interval_; }

VehicleState VehicleMotion::At(double time) const {
  const double inside = std::clamp(time, 0.0, duration());
  const std::size_t index = std::min(static_cast<std::size_t>(inside / interval_), states_.size() - 1);
  const VehicleState& a = states_[index];
  const VehicleState& b = states_[std::min(index + 1, states_.size() - 1)];
  const double share = std::clamp(inside / interval_ - static_cast<double>(index), 0.0, 1.0);
  // Of this form equal ends give the same bits for every share, so that a car at rest does not move.
  const auto between = [share](const auto& from, const auto& to) { return from + share * (to - from); };
  VehicleState state;
  state.time = inside;
  state.position = a.position + share * (b.position - a.position);
  state.heading = between(a.heading, b.heading);
  state.speed = between(a.speed, b.speed);
  state.yaw_rate = between(a.yaw_rate, b.yaw_rate);
  state.steering = between(a.steering, b.steering);
  state.slip = between(a.slip, b.slip);
  const Eigen::Vector3d& from = a.world_from_vehicle.translation;
  state.world_from_vehicle.translation = from + share * (b.world_from_vehicle.translation - from);
  const Eigen::Vector4d start = a.world_from_vehicle.rotation.coeffs();
  const Eigen::Vector4d end = b.world_from_vehicle.rotation.coeffs();
  const double sign = start.dot(end) < 0 ? -1 : 1;
  state.world_from_vehicle.rotation.coeffs() = (start + share * (sign * end - start)).normalized();
  return state;
}

void Suspension::Step(double target, double frequency, double dt) {
  const double omega = 2 * M_PI * frequency;
  rate += dt * (omega * omega * (target - angle) - 2 * kDamping * omega * rate);
  angle += dt * rate;
  if (target == 0 && std::abs(angle) < kRestAngle && std::abs(rate) < kRestRate) *this = {};
}

RoadNoise::RoadNoise(unsigned long long seed) {
  Random random(seed);
  for (int i = 0; i < kWaves; ++i) {
    const double length = kShortestWave * std::pow(kLongestWave / kShortestWave, (i + random.Uniform()) / kWaves);
    waves_.push_back({2 * M_PI / length, 2 * M_PI * random.Uniform()});
  }
}

double RoadNoise::At(double distance) const {
  double sum = 0;
  for (const Wave& wave : waves_) sum += std::cos(wave.frequency * distance + wave.phase);
  return sum * std::sqrt(2.0 / kWaves);
}

double RoadNoiseGain(double speed) { return 2 * std::abs(speed) / (std::abs(speed) + 10); }

void CarOptions::Check() const {
  CheckRange("vehicle.wheelbase", wheelbase, 0.5, 10);
  CheckRange("vehicle.max_steering_deg", max_steering_deg, 5, 80);
  CheckRange("vehicle.max_steering_rate_deg", max_steering_rate_deg, 1, 1000);
  CheckRange("vehicle.slip_deg_per_g", slip_deg_per_g, 0, 20);
  CheckRange("vehicle.max_acceleration", max_acceleration, 0.05, 20);
  CheckRange("vehicle.max_deceleration", max_deceleration, 0.05, 20);
  CheckRange("vehicle.max_lateral_acceleration", max_lateral_acceleration, 0.05, 20);
  CheckRange("vehicle.pitch_deg_per_g", pitch_deg_per_g, 0, 30);
  CheckRange("vehicle.roll_deg_per_g", roll_deg_per_g, 0, 30);
  CheckRange("vehicle.suspension_hz", suspension_hz, 0.2, 20);
  CheckRange("vehicle.road_noise_deg", road_noise_deg, 0, 5);
}

double CarOptions::SideSlip() const { return slip_deg_per_g / (kDegreesPerRadian * kGravity); }

VehicleMotion Drive(const CarOptions& options, const std::vector<RouteLeg>& legs, const RoadHeight& road,
                    double axle_height, unsigned seed) {
  options.Check();
  CheckLegs(legs);
  Driver driver(options, road, axle_height, seed);
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const RouteLeg& leg = legs[i];
    const ReferencePath path = MakeReferencePath(leg);
    EndSpeeds ends;
    if (i == 0 && !leg.speeds.empty()) ends.start = leg.speeds.front();
    if (i + 1 == legs.size() && !leg.speeds.empty() && leg.wait == 0) ends.end = leg.speeds.back();
    const std::vector<double> speeds = PlanSpeeds(options, path, ends, kInterval);
    const double direction = leg.reverse ? -1 : 1;
    if (i == 0) driver.Start(path, direction, speeds.front());
    if (const std::optional<double> lost = driver.Follow(path, direction, speeds)) {
      throw InputError(fmt::format(
          "legs: {:.1f} m along number {}, the path is too curved for the car; smooth or shorten it, or give the "
          "car a shorter wheelbase or more max_steering_deg",
          *lost, i));
    }
    driver.Wait(leg.wait);
  }
  return {driver.TakeStates(), kInterval};
}

}  // namespace turnscale

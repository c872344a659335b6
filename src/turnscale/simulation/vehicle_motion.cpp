// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/simulation/vehicle.h"

namespace turnscale {

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

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/turn_detector.h"

#include <cmath>

#include "turnscale/base/check_part.h"

namespace turnscale {

void TurnDetectorOptions::Check() const {
  Require(std::isfinite(min_step_angle) && min_step_angle > 0, "min_step_angle_deg: has to be positive");
  Require(min_steps >= 1, "min_steps: has to be at least 1");
  Require(std::isfinite(min_region_angle) && min_region_angle >= 0, "min_region_angle_deg: must not be negative");
  Require(max_weak_steps >= 0, "max_weak_steps: must not be negative");
}

TurnDetector::TurnDetector(const TurnDetectorOptions& options) : options_(options) { options_.Check(); }

std::optional<TurningRegion> TurnDetector::Add(double psi) {
  const int step = steps_++;
  const bool strong = std::abs(psi) >= options_.min_step_angle;
  std::optional<TurningRegion> closed;
  if (strong) {
    const bool to_right = psi > 0;
    if (strong_steps_ > 0 && to_right != to_right_) closed = Finish();
    to_right_ = to_right;
    if (strong_steps_ == 0) candidate_ = {step, step, 0};
    candidate_.last = step;
    candidate_.angle += weak_angle_ + psi;
    ++strong_steps_;
    weak_steps_ = 0;
    weak_angle_ = 0;
  } else if (strong_steps_ > 0) {
    weak_angle_ += psi;
    if (++weak_steps_ > options_.max_weak_steps) closed = Finish();
  }
  return closed;
}

std::optional<TurningRegion> TurnDetector::AddUnmeasured() {
  ++steps_;
  return Finish();
}

std::optional<TurningRegion> TurnDetector::open() const {
  const bool long_enough =
      strong_steps_ >= options_.min_steps && std::abs(candidate_.angle) >= options_.min_region_angle;
  return long_enough ? std::optional(candidate_) : std::nullopt;
}

std::optional<TurningRegion> TurnDetector::Finish() {
  const std::optional<TurningRegion> closed = open();
  strong_steps_ = 0;
  weak_steps_ = 0;
  weak_angle_ = 0;
  return closed;
}

}  // namespace turnscale

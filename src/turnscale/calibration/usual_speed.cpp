// SPDX-License-Identifier: MIT
#include "turnscale/calibration/usual_speed.h"

#include <algorithm>
#include <cmath>

namespace turnscale {
namespace {

// Speeds within 5 % are counted together.
constexpr double kSame = 0.05;

}  // namespace

UsualSpeed::UsualSpeed(double memory) : memory_(memory) {}

void UsualSpeed::Add(double way, double seconds) {
  if (!(way > 0)) return;
  const double speed = way / seconds;
  if (!reference_) reference_ = speed;
  if (std::isfinite(memory_) && value_ > 0) {
    // By the way driven, so that no time of standing makes the driving forgotten.
    const double kept = std::exp(-way / (memory_ * value_));
    for (auto& [ratio, driven] : by_speed_) driven = {kept * driven.way, kept * driven.seconds};
    way_ *= kept;
    constexpr double kNothing = 1e-6;
    std::erase_if(by_speed_, [this](const auto& entry) { return entry.second.way < kNothing * way_; });
  }
  constexpr double kMostApart = 1000;
  const double apart = std::clamp(std::log(speed / *reference_) / kSame, -kMostApart, kMostApart);
  Driven& driven = by_speed_[static_cast<int>(std::floor(apart))];
  driven.way += way;
  driven.seconds += seconds;
  way_ += way;
  double faster = 0;
  for (const auto& [place, speed_class] : by_speed_) {
    faster += speed_class.way;
    value_ = speed_class.way / speed_class.seconds;
    if (faster >= 0.5 * way_) break;
  }
}

}  // namespace turnscale

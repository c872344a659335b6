// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <limits>
#include <map>
#include <optional>

namespace turnscale {

/// Typical speed of a car: half of its path length is driven at this speed or faster. Weighted by path length, not by
/// frames, so that odometry noise at standstill has almost no influence. In bounded memory; any unit.
class UsualSpeed {
 public:
  /// Speeds seen longer ago than about so many seconds of driving are forgotten.
  explicit UsualSpeed(double memory = std::numeric_limits<double>::infinity());

  /// Takes a way and the seconds (above 0) that it took.
  void Add(double way, double seconds);

  /// 0 while nothing has moved.
  double value() const { return value_; }

 private:
  struct Driven {
    double way = 0;
    double seconds = 0;
  };

  double memory_;
  std::optional<double> reference_;                 ///< the first speed; others are sorted by their ratio to it
  std::map<int, Driven, std::greater<>> by_speed_;  ///< fastest first
  double way_ = 0;
  double value_ = 0;
};

}  // namespace turnscale

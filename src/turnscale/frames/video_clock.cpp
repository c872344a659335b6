// SPDX-License-Identifier: MIT
#include "turnscale/frames/video_clock.h"

#include <cmath>

namespace turnscale {
namespace {

constexpr double kNewStart = 1.0;            // s; a larger step back is no jitter
constexpr int kMostLate = 8;                 // frames
constexpr double kUsualInterval = 1 / 30.0;  // s; used only while nothing tells

}  // namespace

double VideoClock::Interval() const { return rate_ > 0 ? 1 / rate_ : step_ > 0 ? step_ : kUsualInterval; }

double VideoClock::TimeOf(double stamp) const {
  const double time = stamp - origin_;
  if (rate_ <= 0) return time;
  const double even = std::round(time * rate_) / rate_;
  return std::abs(even - time) <= tick_ && even > time_ ? even : time;
}

double VideoClock::Next(std::optional<double> stamp) {
  const bool first = frames_++ == 0;
  if (stamp && !has_origin_) {
    // Frames before the first stamp have been counted.
    origin_ = *stamp - (first ? 0.0 : time_ + Interval());
    has_origin_ = true;
  }
  if (first) return time_;
  if (!stamp) {
    ++unstamped_;
    // No sum of intervals where the rate alone tells: it would collect rounding errors.
    time_ = has_origin_ || rate_ <= 0 ? time_ + Interval() : (frames_ - 1) / rate_;
    return time_;
  }
  const double time = TimeOf(*stamp);
  // Different stamps differ by a tick; less is rounding.
  if (time - time_ > tick_ / 4) {
    if (unstamped_ == 0 && late_ == 0) step_ = time - time_;
    unstamped_ = late_ = 0;
    return time_ = time;
  }
  if (time <= time_ - kNewStart || late_ >= kMostLate) {
    time_ += Interval();
    origin_ = *stamp - time_;
    return time_;
  }
  ++late_;
  return time_ += Interval() / 2;
}

}  // namespace turnscale

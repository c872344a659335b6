// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

namespace turnscale {

/// Times of a video's frames, in seconds after its first frame, from their stamps. The times increase strictly.
///
/// * Stamps are rounded to the ticks of the container. A stamp within a tick of a multiple of the frame interval counts
///   as that multiple, so that a constant rate gives evenly spaced times.
/// * A frame without a stamp comes one frame interval after the frame before.
/// * A frame whose stamp repeats or goes back comes half an interval after the frame before, until the stamps have
///   caught up. If they go back by a second or more, or do not catch up within eight frames, they are counted anew from
///   one interval after the frame before.
class VideoClock {
 public:
  /// `rate`: frames per second, 0 if unknown; `tick`: resolution of the stamps, seconds.
  VideoClock(double rate, double tick) : rate_(rate), tick_(tick) {}

  /// Time of the next frame; `stamp` is its stamp in seconds, if it has one.
  double Next(std::optional<double> stamp);

  /// Time of the latest frame.
  double time() const { return time_; }
  /// The frame interval: that of the rate, else the latest one.
  double Interval() const;

 private:
  double TimeOf(double stamp) const;

  double rate_;
  double tick_;
  double time_ = 0;
  double step_ = 0;    // latest interval between two good stamps
  double origin_ = 0;  // stamp at time 0
  bool has_origin_ = false;
  int frames_ = 0;
  int unstamped_ = 0;  // frames since the latest one whose time is from its stamp
  int late_ = 0;       // of them, those with a stamp that is not later
};

}  // namespace turnscale

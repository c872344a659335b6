// SPDX-License-Identifier: MIT
#pragma once

#include <limits>

namespace turnscale {

/// Counts the frames of a drive, and refuses times that cannot be theirs.
class FrameCounter {
 public:
  /// Throws InputError if a next frame cannot have been taken at `time` (seconds): where it is not finite or not after
  /// the frame before, or when many frames are so far apart that times cannot be seconds.
  void Check(double time) const;

  /// Takes the next frame, whose time has been checked. Returns its number.
  int Add(double time);

  /// Of the latest frame, whatever it showed, seconds; -infinity before the first.
  double last_frame_time() const { return last_frame_time_; }

 private:
  double last_frame_time_ = -std::numeric_limits<double>::infinity();
  double least_interval_ = std::numeric_limits<double>::infinity();  ///< between two frames, seconds
  int frames_ = 0;
};

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

namespace turnscale {

/// What becomes of a camera's frames on the way to its card.
struct RecorderOptions {
  bool video = false;               ///< an MP4 video with a variable frame rate rather than a folder of PNG images
  double megabits_per_second = 12;  ///< of the video; 10 to 16 are usual for 1920x1080 pixels at 30 frames/s
  bool clock = false;               ///< date and time are burnt into the images
  double stalls_per_minute = 0;     ///< of the card, on average; frames are lost in each
  int stalled_frames = 3;           ///< lost in a stall, at most; one at least
  double stamp_jitter_ms = 0;       ///< standard deviation of the video's time stamps from the times of exposure

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// A frame that is recorded.
struct CapturedFrame {
  int number = 0;    ///< among all that the sensor exposes, from 0
  double stamp = 0;  ///< what the camera says of its time, seconds; at least half an interval after the one before
};

/// The frames of a drive that are recorded out of `count` exposed at a constant rate: the first one always. Depends on
/// the arguments alone; the first frames do not depend on the count.
std::vector<CapturedFrame> CapturedFrames(const RecorderOptions& options, int count, double rate_hz,
                                          std::uint64_t seed);

}  // namespace turnscale

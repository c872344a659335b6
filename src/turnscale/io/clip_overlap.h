// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// Clips that overlap by more are not recognised, seconds.
inline constexpr double kLongestOverlap = 5;

/// What a clip has in common with the one before.
struct ClipOverlap {
  size_t images = 0;  ///< at the beginning of the clip
  double time = 0;    ///< of the first of them, as it was added to the ClipTail
};

/// The last images of a clip. Many recorders begin the next file before they close one, so that a clip begins with the
/// last images of the clip before. These are the same images, compressed once more.
class ClipTail {
 public:
  /// Images of one size, in the order of their times (seconds).
  void Add(double time, const cv::Mat& gray);
  void Clear() { images_.clear(); }

  /// Whether the images of the next clip repeat the last ones added, from one of them to the end. `next` gives the
  /// images of that clip from its beginning, empty ones after its end. Nothing if they do not, for less than 0.3 s, or
  /// if too little moves to tell.
  std::optional<ClipOverlap> RepeatedBy(const std::function<cv::Mat()>& next) const;

 private:
  struct Image {
    double time;
    std::vector<uint8_t> samples;
  };

  std::deque<Image> images_;
};

}  // namespace turnscale

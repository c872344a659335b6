// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// Clips that overlap by more are not recognised, seconds.
inline constexpr double kLongestOverlap = 5;

/// An image of a clip.
struct ClipImage {
  double time = 0;  ///< seconds, by a clock of the clip
  cv::Mat gray;
};

/// The last images of a clip. Many recorders begin the next file before they close one, so that a clip begins with the
/// last images of the clip before. These are the same images, compressed once more.
class ClipTail {
 public:
  /// Images of one size, in the order of their times.
  void Add(const ClipImage& image);
  void Clear() { images_.clear(); }

  /// Whether the images change by so much within the tail that a repetition would be recognised.
  bool IsMoving() const;

  /// Whether the images of the next clip repeat the last ones added, from one of them to the end. `next` gives the
  /// images of that clip from its beginning; nothing after its end. Returns the time of the first of the repeated
  /// images by the clock of this clip: that of the beginning of the next. Nothing if they are no repetition, if it is
  /// shorter than 0.3 s, or if too little moves to tell.
  std::optional<double> RepeatedBy(const std::function<std::optional<ClipImage>()>& next) const;

  /// Whether images are missing between the last one and `first`, the first one of the next clip: these two differ by
  /// much more than those of the tail do that are consecutive or a moment apart. Where images are known to be missing
  /// as likely as not (`likely`), by a little more. Some gaps remain undetected, among them those of a car that stands.
  /// False if the tail has too few images to tell.
  bool JumpsTo(const cv::Mat& first, bool likely = false) const;

 private:
  struct Image {
    double time;
    std::vector<uint8_t> samples;
  };

  std::deque<Image> images_;
};

}  // namespace turnscale

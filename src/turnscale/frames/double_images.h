// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "turnscale/frames/blended_frames.h"

namespace turnscale {

/// A point of the scene in an image and in the one before, pixels.
struct MovedPoint {
  cv::Point2f before;
  cv::Point2f now;
};

/// Finds out whether each image is mixed with the one before, as blending of frames and strong temporal noise reduction
/// of a camera do it: what has moved is still seen, weaker, where the image before had it. An image is then more
/// similar to itself when it is shifted by the motion of its points than when it is shifted by more or by less. No
/// image of a single moment is, be it sharp or blurred by the motion, unless most of it repeats after about the motion,
/// as railings may. It supplements BlendedFrames, which needs weights that change from image to image.
class DoubleImages {
 public:
  /// The next image, 8-bit gray, at `time` seconds, and points that were tracked into it from the image before. Most of
  /// them have to be of the scene.
  void Add(const cv::Mat& gray, double time, const std::vector<MovedPoint>& points);

  /// What the images so far show; empty where they are as they should be, or show too little motion. The period is 0.
  std::optional<FrameBlending> Find() const;

 private:
  // An image whose points move far enough.
  struct Measured {
    double time = 0;    // seconds
    double excess = 0;  // of the similarity at the motion of its points over that at other shifts
  };
  std::vector<Measured> images_;
};

}  // namespace turnscale

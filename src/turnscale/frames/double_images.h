// SPDX-License-Identifier: MIT
#pragma once

#include <array>
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

/// Finds out whether each image shows two moments: it is mixed with the one before, as strong temporal noise reduction
/// of a camera does it, or is the mean of two frames of a video of twice the rate, as blending of frames makes it. What
/// has moved is then seen twice, apart by the motion of its points since the image before or by half of it, and the
/// image is more similar to itself when it is shifted by that than when it is shifted by more or by less. No image of a
/// single moment is, be it sharp or blurred by the motion, unless most of it repeats after about that shift, as
/// railings may. It supplements BlendedFrames, which needs weights that change from image to image.
class DoubleImages {
 public:
  /// The next image, 8-bit gray, at `time` seconds, and points that were tracked into it from the image before. Most of
  /// them have to be of the scene.
  void Add(const cv::Mat& gray, double time, const std::vector<MovedPoint>& points);

  /// What the images so far show; empty where they are as they should be, or show too little motion.
  std::optional<FrameBlending> Find() const;

 private:
  // An image whose points move far enough.
  struct Measured {
    double time = 0;    // seconds
    double excess = 0;  // of the similarity at the shift between the two moments over that at other shifts
  };
  struct Tested {
    FrameBlending::Kind kind;
    std::vector<Measured> images;
  };
  std::array<Tested, 2> tested_{Tested{FrameBlending::Kind::kImageBefore, {}},
                                Tested{FrameBlending::Kind::kHalfInterval, {}}};
};

}  // namespace turnscale

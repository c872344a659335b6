// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// Images of a drive that are mixtures of two views, as conversion to another frame rate makes them by blending
/// (BlendedFrames, DoubleImages), or strong temporal noise reduction (DoubleImages).
struct FrameBlending {
  /// Relative standard deviation of lengths that it causes, chosen from conversions (docs/blended.md). The whole video
  /// is blended, even if it shows only in a part: where the car is slow, less of the path is.
  static constexpr double kScaleSigma = 0.25;

  /// How it shows.
  enum class Kind {
    kRhythm,        ///< the sharpness rises and falls from image to image
    kImageBefore,   ///< each image contains a copy of the one before
    kHalfInterval,  ///< each image is the mean of two moments, half of the interval between images apart
  };

  double from = 0;  ///< time, seconds, where it begins
  double to = 0;    ///< time, seconds, where it ends
  Kind kind = Kind::kRhythm;
  double period = 0;  ///< of kRhythm: images from one that is sharp to the next, at least 2; else 0
};

/// The warning, one line. `consequence`: such as "the scale may be wrong".
std::string FrameBlendingText(const FrameBlending& blending, const std::string& consequence);

/// Finds out whether images are such mixtures. If a conversion makes an image of two that follow one another, detail
/// that moves between them is shown twice, each time at less contrast. Their weights change periodically from image to
/// image, and so does the contrast of fine detail. It does so at a constant rate, and all over the image, unlike what
/// vibration, exposure, wipers, or vehicles that pass do. Video compression pulsates, too, but hardly where
/// images are reduced. Light that flashes takes away contrast as well, but changes the brightness, as blending does
/// not.
class BlendedFrames {
 public:
  /// `pixel_width`: of the images' pixels, in pixels of the video, where they have been reduced or enlarged
  /// (ImageScaling).
  explicit BlendedFrames(double pixel_width = 1);

  /// The next image, 8-bit gray.
  void Add(const cv::Mat& gray, double time);

  /// What the images so far show; empty where they are as they should be, or stand still.
  std::optional<FrameBlending> Find() const;

 private:
  // Of an image by tile, as logarithms.
  struct Tiles {
    std::vector<float> brightness;
    std::vector<float> detail;
  };

  static Tiles TilesOf(const cv::Mat& image);

  int halvings_;
  cv::Size size_;                 // of the images
  std::array<cv::Mat, 2> small_;  // the image, halved once and more
  std::array<Tiles, 3> tiles_;    // of the last images, the oldest first
  std::vector<float> changes_;    // by how much an image has more detail than those beside it
  std::vector<double> times_;     // of these images
  double last_time_ = 0;          // of the last image
};

}  // namespace turnscale

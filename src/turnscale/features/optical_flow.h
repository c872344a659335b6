// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <opencv2/core.hpp>

namespace turnscale {

struct FlowOptions {
  /// Side of the square patch that is compared, pixels. Odd, at most 31.
  int window = 15;
  /// The same in dark images, whose texture is as weak as their noise.
  int dark_window = 23;
  /// Halvings of the image above the full size; each doubles the motion that is found without a prediction. Of an image
  /// about 1280 pixels wide; one more for every doubling of that, so that the same motion of the car is found.
  int levels = 3;
  /// A point tracked forth and back has to return to within this many pixels.
  double max_return_error = 0.7;
  /// Mean gray level below which an image counts as taken at night: it is brightened and smoothed. 0: none is.
  double min_brightness = 32;
  /// Images are made equally bright if their brightness differs by more than this share.
  double max_brightness_change = 0.1;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// An image with what optical flow needs of it.
struct FlowImage {
  cv::Mat gray;                  ///< 8 bit, full size, a copy with a border around it; brightened if it was dark
  bool dark = false;             ///< its mean gray level was below FlowOptions::min_brightness
  std::vector<cv::Mat> pyramid;  ///< 8 bit, with a border; the first one is `gray`; empty: not built
};

/// The image without its pyramid.
FlowImage CopyFlowImage(const FlowOptions& options, const cv::Mat& gray);

/// Builds the pyramid of an image that has none.
void BuildPyramid(const FlowOptions& options, FlowImage& image);

/// The image with its pyramid.
FlowImage BuildFlowImage(const FlowOptions& options, const cv::Mat& gray);

/// The first image as bright as the second, where the brightness has jumped from one to the other (exposure control,
/// flickering light): optical flow takes the same place to have the same gray level. Where it has not, the first image
/// itself.
FlowImage MatchBrightness(const FlowOptions& options, const FlowImage& first, const FlowImage& second);

struct FlowResult {
  std::vector<cv::Point2f> points;  ///< where each point is in the second image; meaningless where not found
  std::vector<uchar> found;         ///< one flag per point
};

/// Finds points of the first image again in the second by pyramidal Lucas-Kanade, starting at `guesses` (same size as
/// `points`). Guesses are rounded to 1/16 pixel: a prediction that differs in its last digits then finds the very same
/// pixels. `levels`: halvings of the image to start with; by default all.
FlowResult TrackPoints(const FlowOptions& options, const FlowImage& first, const FlowImage& second,
                       const std::vector<cv::Point2f>& points, const std::vector<cv::Point2f>& guesses,
                       std::optional<int> levels = {});

/// Gives up those found points that do not track back to where they came from, or look different there. `flags`: one
/// per point; where it is 0, the point is not checked.
void CheckReturn(const FlowOptions& options, const FlowImage& first, const FlowImage& second,
                 const std::vector<cv::Point2f>& points, const std::vector<uchar>& flags, FlowResult& result);

/// The same for all points.
void CheckReturn(const FlowOptions& options, const FlowImage& first, const FlowImage& second,
                 const std::vector<cv::Point2f>& points, FlowResult& result);

}  // namespace turnscale

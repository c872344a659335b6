// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <opencv2/core.hpp>

namespace turnscale {

struct KeypointOptions {
  /// Strongest keypoints of an image that are described.
  int max_keypoints = 3000;
  /// Least contrast of a keypoint: OpenCV's contrastThreshold, by default half of its default, for images of little
  /// texture.
  double min_contrast = 0.02;
  /// Largest distance of the descriptors of a match, as a share of that of the second best match.
  double max_distance_ratio = 0.8;
  /// Larger images are halved until they are no wider, pixels: for the sake of time and memory.
  int max_width = 1300;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Keypoints of an image with their descriptors.
struct DescribedKeypoints {
  std::vector<cv::Point2f> pixels;
  cv::Mat descriptors;  ///< one row per keypoint
  double scale = 1;     ///< pixels of the image per pixel of what was described
};

/// A point that two images show, pixels.
struct KeypointMatch {
  cv::Point2f first;
  cv::Point2f second;
};

/// SIFT keypoints of an 8-bit gray image (Lowe 2004, Distinctive image features from scale-invariant keypoints). None
/// lies where `mask` (8 bit, of the image's size; empty: no mask) is 0.
DescribedKeypoints DescribeKeypoints(const KeypointOptions& options, const cv::Mat& gray, const cv::Mat& mask);

/// Points that two images have in common, also if they differ much in viewpoint and size: mutual nearest neighbours
/// with the ratio test. Some of the matches are wrong.
std::vector<KeypointMatch> MatchKeypoints(const KeypointOptions& options, const DescribedKeypoints& first,
                                          const DescribedKeypoints& second);

}  // namespace turnscale

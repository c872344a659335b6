// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <opencv2/core.hpp>

namespace turnscale {

struct KeypointOptions {
  /// Strongest keypoints of an image that are described.
  int max_keypoints = 4000;
  /// Least contrast of a keypoint, as a share of the full range: half of SIFT's usual one, for images of little
  /// texture.
  double min_contrast = 0.02;
  /// Largest distance of the descriptors of a match, as a share of that of the second best match.
  double max_distance_ratio = 0.8;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// A point that two images show, pixels.
struct KeypointMatch {
  cv::Point2f first;
  cv::Point2f second;
};

/// Points that two 8-bit gray images have in common, also if they differ much in viewpoint and size: SIFT keypoints and
/// descriptors, mutual nearest neighbours with the ratio test (Lowe 2004, Distinctive image features from
/// scale-invariant keypoints). Some of the matches are wrong. None lies where `mask` (8 bit, of the images' size;
/// empty: no mask) is 0.
std::vector<KeypointMatch> MatchKeypoints(const KeypointOptions& options, const cv::Mat& first, const cv::Mat& second,
                                          const cv::Mat& mask);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace turnscale {

struct PatchAlignmentOptions {
  /// Half the side of the square patch, pixels: the side is 2 * half_size + 1.
  int half_size = 5;
  int max_iterations = 10;
  /// Steps shorter than this end the search, pixels.
  double tolerance = 0.01;
  /// The search ends without a result farther than this from where it started, pixels.
  double max_distance = 3.0;
  /// Correlation that the patch has to reach with what it is found to lie on.
  double min_correlation = 0.7;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Where an image shows a patch of a reference image: found to a fraction of a pixel by the inverse compositional
/// method (Baker and Matthews 2004) on the full-size images, with gain and offset of the brightness free.
///
/// The patch is `reference_from_current` (2x2) times the pixel offsets of a square around `reference_pixel`: a landmark
/// that has come nearer is compared at its present size, which is what keeps a long track from drifting.
/// `guess` is within a few pixels of the answer. Empty where the search leaves the image, does not settle, or settles
/// on something that looks different.
std::optional<Eigen::Vector2d> AlignPatch(const PatchAlignmentOptions& options, const cv::Mat& reference,
                                          const Eigen::Vector2d& reference_pixel,
                                          const Eigen::Matrix2d& reference_from_current, const cv::Mat& current,
                                          const Eigen::Vector2d& guess);

/// Prefetches the pixels of a reference image that AlignPatch will read (approximately). Changes no result.
void PrefetchPatch(const PatchAlignmentOptions& options, const cv::Mat& reference,
                   const Eigen::Vector2d& reference_pixel);

}  // namespace turnscale

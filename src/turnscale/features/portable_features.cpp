// SPDX-License-Identifier: MIT
// The sources of TrackPatch and AlignPatch, in a namespace of their own, with OpenCV's universal intrinsics in plain
// C++.
#define CV_FORCE_SIMD128_CPP 1
#define turnscale turnscale_portable
#include "turnscale/features/lucas_kanade.cpp"     // NOLINT(bugprone-suspicious-include)
#include "turnscale/features/patch_alignment.cpp"  // NOLINT(bugprone-suspicious-include)
#include "turnscale/features/patch_sums.cpp"       // NOLINT(bugprone-suspicious-include)
#include "turnscale/features/patch_template.cpp"   // NOLINT(bugprone-suspicious-include)
#undef turnscale

#include "turnscale/features/portable_features.h"

namespace turnscale {

std::optional<cv::Point2f> TrackPatchPortably(int window, const cv::Mat& first, const cv::Point2f& point,
                                              const cv::Mat& second, const cv::Point2f& guess) {
  return turnscale_portable::TrackPatch({.window = window}, first, point, second, guess);
}

std::optional<Eigen::Vector2d> AlignPatchPortably(const cv::Mat& reference, const Eigen::Vector2d& reference_pixel,
                                                  const Eigen::Matrix2d& reference_from_current, const cv::Mat& current,
                                                  const Eigen::Vector2d& guess) {
  return turnscale_portable::AlignPatch({}, reference, reference_pixel, reference_from_current, current, guess);
}

}  // namespace turnscale

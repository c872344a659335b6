// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace turnscale {

/// TrackPatch and AlignPatch with their default options, with OpenCV's emulation of the intrinsics in plain C++.
std::optional<cv::Point2f> TrackPatchPortably(int window, const cv::Mat& first, const cv::Point2f& point,
                                              const cv::Mat& second, const cv::Point2f& guess);
std::optional<Eigen::Vector2d> AlignPatchPortably(const cv::Mat& reference, const Eigen::Vector2d& reference_pixel,
                                                  const Eigen::Matrix2d& reference_from_current, const cv::Mat& current,
                                                  const Eigen::Vector2d& guess);

}  // namespace turnscale

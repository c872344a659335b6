// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <opencv2/core.hpp>

namespace turnscale {

struct CornerOptions {
  /// Corners wanted over the whole image. More cost time, fewer cost accuracy in turns, where half the view is new
  /// every second.
  int target = 1200;
  /// Gray levels by which the ring of a FAST corner has to differ; low, since the ranking below keeps the best. Less in
  /// an image of little contrast or with few corners.
  int fast_threshold = 10;
  /// No new corner nearer than this to a tracked one, pixels.
  double min_distance = 12;
  /// No corner nearer than this to the image border, pixels.
  int border = 12;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// FAST corners of an 8-bit gray image, all of them: the candidates for DetectCorners. `dark`: the image was dark, and
/// has been brightened and smoothed (FlowImage); half the threshold finds its corners.
std::vector<cv::KeyPoint> FindCandidates(const CornerOptions& options, const cv::Mat& gray, bool dark = false);

/// Corners of an 8-bit gray image spread evenly: the image is divided into about `target` square cells, and each cell
/// gives, away from the `occupied` pixels, its FAST corner with the largest smaller eigenvalue of the gradient
/// matrix (Shi and Tomasi 1994), which is what optical flow can hold on to in both directions. None lies where `mask`
/// (8 bit, of the image's size; empty: no mask) is 0.
std::vector<cv::Point2f> DetectCorners(const CornerOptions& options, const cv::Mat& gray,
                                       const std::vector<cv::Point2f>& occupied, const cv::Mat& mask = {});

/// The same out of the image's candidates.
std::vector<cv::Point2f> DetectCorners(const CornerOptions& options, const cv::Mat& gray,
                                       const std::vector<cv::KeyPoint>& candidates,
                                       const std::vector<cv::Point2f>& occupied, const cv::Mat& mask);

}  // namespace turnscale

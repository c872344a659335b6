// SPDX-License-Identifier: MIT
#include "turnscale/features/corners.h"

#include <algorithm>
#include <cmath>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

constexpr int kScoreWindow = 5;

// Marks which pixels are too near to one that is taken.
cv::Mat FreePixels(const CornerOptions& options, const cv::Size& size, const std::vector<cv::Point2f>& occupied) {
  cv::Mat free(size, CV_8U, cv::Scalar(0));
  const cv::Rect inside(options.border, options.border, size.width - 2 * options.border,
                        size.height - 2 * options.border);
  if (inside.width <= 0 || inside.height <= 0) return free;
  free(inside).setTo(255);
  for (const cv::Point2f& point : occupied)
    cv::circle(free, cv::Point(cvRound(point.x), cvRound(point.y)), cvRound(options.min_distance), cv::Scalar(0),
               cv::FILLED);
  return free;
}

}  // namespace

void CornerOptions::Check() const {
  if (target < 50) throw InputError("corners.target: has to be at least 50");
  if (fast_threshold < 1 || fast_threshold > 255) throw InputError("corners.fast_threshold: has to be in 1...255");
  if (!(min_distance >= 1)) throw InputError("corners.min_distance: has to be at least 1 pixel");
  if (border < 4) throw InputError("corners.border: has to be at least 4 pixels");
}

std::vector<cv::Point2f> DetectCorners(const CornerOptions& options, const cv::Mat& gray,
                                       const std::vector<cv::Point2f>& occupied) {
  const cv::Mat free = FreePixels(options, gray.size(), occupied);
  std::vector<cv::KeyPoint> candidates;
  cv::FAST(gray, candidates, options.fast_threshold, true);
  cv::Mat score;
  cv::cornerMinEigenVal(gray, score, kScoreWindow);

  const double cell = std::max(options.min_distance, std::sqrt(static_cast<double>(gray.total()) / options.target));
  const int columns = static_cast<int>(gray.cols / cell) + 1;
  const int rows = static_cast<int>(gray.rows / cell) + 1;
  std::vector<const cv::KeyPoint*> best(static_cast<size_t>(columns) * rows, nullptr);
  const auto score_of = [&](const cv::KeyPoint& k) { return score.at<float>(cv::Point(k.pt)); };
  for (const cv::KeyPoint& candidate : candidates) {
    if (free.at<uchar>(cv::Point(candidate.pt)) == 0) continue;
    const int column = static_cast<int>(candidate.pt.x / cell);
    const int row = static_cast<int>(candidate.pt.y / cell);
    const cv::KeyPoint*& slot = best[static_cast<size_t>(row) * columns + column];
    if (slot == nullptr || score_of(candidate) > score_of(*slot)) slot = &candidate;
  }

  std::vector<cv::Point2f> corners;
  for (const cv::KeyPoint* corner : best)
    if (corner != nullptr) corners.push_back(corner->pt);
  return corners;
}

}  // namespace turnscale

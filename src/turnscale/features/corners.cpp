// SPDX-License-Identifier: MIT
#include "turnscale/features/corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

// Half the side of the window over which gradients are summed, pixels. With the gradient's own pixel it stays within
// the least border.
constexpr int kScoreHalfWindow = 2;

// The smaller eigenvalue of the gradient matrix around a pixel, but for a constant factor. Computed where it is asked
// for: in a tracked image, that is at few of the pixels.
double SmallerEigenvalue(const cv::Mat& gray, const cv::Point& at) {
  int xx = 0;
  int xy = 0;
  int yy = 0;
  for (int row = at.y - kScoreHalfWindow; row <= at.y + kScoreHalfWindow; ++row) {
    const uchar* above = gray.ptr<uchar>(row - 1);
    const uchar* here = gray.ptr<uchar>(row);
    const uchar* below = gray.ptr<uchar>(row + 1);
    for (int column = at.x - kScoreHalfWindow; column <= at.x + kScoreHalfWindow; ++column) {
      // Sobel's gradient.
      const int diagonal = below[column + 1] - above[column - 1];
      const int antidiagonal = above[column + 1] - below[column - 1];
      const int dx = diagonal + antidiagonal + 2 * (here[column + 1] - here[column - 1]);
      const int dy = diagonal - antidiagonal + 2 * (below[column] - above[column]);
      xx += dx * dx;
      xy += dx * dy;
      yy += dy * dy;
    }
  }
  return 0.5 * (xx + yy - std::hypot(static_cast<double>(xx - yy), 2.0 * xy));
}

constexpr int kLeastThreshold = 4;  // below is noise

// In fog, corners are as faint as the whole image. The smoothing of a dark image makes its corners fainter, too.
int ThresholdFor(const CornerOptions& options, const cv::Mat& gray, bool dark) {
  constexpr double kUsualContrast = 18;  // standard deviation of the gray levels; that of most drives is above 25
  constexpr double kDarkShare = 0.5;
  cv::Scalar mean;
  cv::Scalar contrast;
  cv::meanStdDev(gray, mean, contrast);
  const double share = std::min(contrast[0] / kUsualContrast, dark ? kDarkShare : 1.0);
  if (share >= 1) return options.fast_threshold;
  return std::min(options.fast_threshold, std::max(kLeastThreshold, cvRound(options.fast_threshold * share)));
}

// Square cells that the image is divided into.
struct Grid {
  double cell;
  int columns;
  int rows;

  size_t size() const { return static_cast<size_t>(columns) * rows; }
  size_t IndexOf(const cv::Point2f& point) const {
    return static_cast<size_t>(static_cast<int>(point.y / cell)) * columns + static_cast<int>(point.x / cell);
  }
};

Grid MakeGrid(const CornerOptions& options, const cv::Mat& gray) {
  const double cell = std::max(options.min_distance, std::sqrt(static_cast<double>(gray.total()) / options.target));
  return {cell, static_cast<int>(gray.cols / cell) + 1, static_cast<int>(gray.rows / cell) + 1};
}

size_t FilledCells(const Grid& grid, const std::vector<cv::KeyPoint>& candidates) {
  std::vector<char> filled(grid.size(), 0);
  for (const cv::KeyPoint& candidate : candidates) filled[grid.IndexOf(candidate.pt)] = 1;
  return static_cast<size_t>(std::count(filled.begin(), filled.end(), 1));
}

// FAST corners of horizontal bands, on as many threads as OpenCV is set to use: those of the whole image, in its order.
std::vector<cv::KeyPoint> FindFast(const cv::Mat& gray, int threshold) {
  constexpr int kBands = 4;
  // The radius of the ring, and a row for the comparison with neighbours.
  constexpr int kMargin = 4;
  std::array<std::vector<cv::KeyPoint>, kBands> found;
  cv::parallel_for_(cv::Range(0, kBands), [&](const cv::Range& range) {
    for (int band = range.start; band < range.end; ++band) {
      const int first = gray.rows * band / kBands;
      const int last = gray.rows * (band + 1) / kBands;
      const int top = std::max(0, first - kMargin);
      cv::FAST(gray.rowRange(top, std::min(gray.rows, last + kMargin)), found[band], threshold, true);
      for (cv::KeyPoint& corner : found[band]) corner.pt.y += static_cast<float>(top);
      std::erase_if(found[band], [&](const cv::KeyPoint& corner) {
        return corner.pt.y < static_cast<float>(first) || corner.pt.y >= static_cast<float>(last);
      });
    }
  });
  std::vector<cv::KeyPoint> corners;
  for (const std::vector<cv::KeyPoint>& of_band : found) corners.insert(corners.end(), of_band.begin(), of_band.end());
  return corners;
}

// Marks which pixels are in the mask and not too near to one that is taken.
cv::Mat FreePixels(const CornerOptions& options, const cv::Size& size, const std::vector<cv::Point2f>& occupied,
                   const cv::Mat& mask) {
  cv::Mat free(size, CV_8U, cv::Scalar(0));
  const cv::Rect inside(options.border, options.border, size.width - 2 * options.border,
                        size.height - 2 * options.border);
  if (inside.width <= 0 || inside.height <= 0) return free;
  free(inside).setTo(255);
  for (const cv::Point2f& point : occupied)
    cv::circle(free, cv::Point(cvRound(point.x), cvRound(point.y)), cvRound(options.min_distance), cv::Scalar(0),
               cv::FILLED);
  if (!mask.empty()) free.setTo(0, mask == 0);
  return free;
}

}  // namespace

void CornerOptions::Check() const {
  if (target < 50) throw InputError("target: has to be at least 50");
  if (fast_threshold < 1 || fast_threshold > 255) throw InputError("fast_threshold: has to be in 1...255");
  if (!(min_distance >= 1)) throw InputError("min_distance: has to be at least 1 pixel");
  if (border < 4) throw InputError("border: has to be at least 4 pixels");
}

std::vector<cv::KeyPoint> FindCandidates(const CornerOptions& options, const cv::Mat& gray, bool dark) {
  // Share of the cells. Most drives fill half of them or more, bare streets and walls a fifth, and fog before a bright
  // sky less than a tenth.
  constexpr double kFewest = 0.25;
  const Grid grid = MakeGrid(options, gray);
  const int threshold = ThresholdFor(options, gray, dark);
  std::vector<cv::KeyPoint> candidates = FindFast(gray, threshold);
  const auto filled = static_cast<double>(FilledCells(grid, candidates));
  if (threshold > kLeastThreshold && filled < kFewest * static_cast<double>(grid.size()))
    candidates = FindFast(gray, kLeastThreshold);
  return candidates;
}

std::vector<cv::Point2f> DetectCorners(const CornerOptions& options, const cv::Mat& gray,
                                       const std::vector<cv::Point2f>& occupied, const cv::Mat& mask) {
  return DetectCorners(options, gray, FindCandidates(options, gray), occupied, mask);
}

std::vector<cv::Point2f> DetectCorners(const CornerOptions& options, const cv::Mat& gray,
                                       const std::vector<cv::KeyPoint>& candidates,
                                       const std::vector<cv::Point2f>& occupied, const cv::Mat& mask) {
  const cv::Mat free = FreePixels(options, gray.size(), occupied, mask);
  const Grid grid = MakeGrid(options, gray);
  struct Slot {
    double score = 0;
    std::optional<cv::Point2f> corner;
  };
  std::vector<Slot> best(grid.size());
  for (const cv::KeyPoint& candidate : candidates) {
    const cv::Point pixel(candidate.pt);
    if (free.at<uchar>(pixel) == 0) continue;
    Slot& slot = best[grid.IndexOf(candidate.pt)];
    const double score = SmallerEigenvalue(gray, pixel);
    if (!slot.corner || score > slot.score) slot = {score, candidate.pt};
  }

  std::vector<cv::Point2f> corners;
  for (const Slot& slot : best)
    if (slot.corner) corners.push_back(*slot.corner);
  return corners;
}

}  // namespace turnscale

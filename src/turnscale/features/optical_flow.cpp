// SPDX-License-Identifier: MIT
#include "turnscale/features/optical_flow.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

const cv::TermCriteria kTermination(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.03);
constexpr double kMinEigenvalue = 1e-4;
// The way back starts at the right place, so it needs no coarse levels.
constexpr int kReturnLevels = 1;

float RoundedGuess(float coordinate) { return std::round(coordinate * 16.0F) / 16.0F; }

// Halvings of an image of this width.
int LevelsOf(const FlowOptions& options, int width) {
  constexpr double kUsualWidth = 1280;
  return options.levels + std::max(0, static_cast<int>(std::lround(std::log2(width / kUsualWidth))));
}

// A dark image has little contrast beside its noise: four times the brightness, smoothed before it is rounded.
cv::Mat Brightened(const cv::Mat& gray) {
  constexpr double kGain = 4;
  constexpr double kSigma = 1.2;    // pixels
  constexpr double kFraction = 64;  // of a gray level
  cv::Mat fine;
  gray.convertTo(fine, CV_16U, kGain * kFraction);
  cv::GaussianBlur(fine, fine, {}, kSigma);
  cv::Mat bright;
  fine.convertTo(bright, CV_8U, 1 / kFraction);
  return bright;
}

FlowImage WithPyramid(const FlowOptions& options, const cv::Mat& gray) {
  FlowImage image;
  image.gray = gray;
  cv::buildOpticalFlowPyramid(image.gray, image.pyramid, cv::Size(options.window, options.window),
                              LevelsOf(options, image.gray.cols));
  return image;
}

// Brightness of the second image over that of the first: the median over blocks, since parts of an image change by
// themselves.
double BrightnessRatio(const FlowImage& first, const FlowImage& second) {
  const cv::Size blocks(16, 8);
  cv::Mat a;
  cv::Mat b;
  cv::resize(first.pyramid[first.pyramid.size() - 2], a, blocks, 0, 0, cv::INTER_AREA);
  cv::resize(second.pyramid[second.pyramid.size() - 2], b, blocks, 0, 0, cv::INTER_AREA);
  std::vector<double> ratios;
  for (int row = 0; row < blocks.height; ++row)
    for (int column = 0; column < blocks.width; ++column)
      ratios.push_back((b.at<uchar>(row, column) + 1.0) / (a.at<uchar>(row, column) + 1.0));
  return Median(std::move(ratios));
}

bool Inside(const cv::Point2f& point, const cv::Size& size) {
  return point.x >= 0 && point.y >= 0 && point.x <= static_cast<float>(size.width - 1) &&
         point.y <= static_cast<float>(size.height - 1);
}

}  // namespace

void FlowOptions::Check() const {
  if (window < 5 || window % 2 == 0) throw InputError("flow.window: has to be odd and at least 5 pixels");
  if (levels < 0 || levels > 8) throw InputError("flow.levels: has to be in 0...8");
  if (!(max_return_error > 0)) throw InputError("flow.max_return_error: has to be positive");
  if (!(min_brightness >= 0 && min_brightness <= 255)) throw InputError("flow.min_brightness: has to be in 0...255");
  if (!(max_brightness_change > 0)) throw InputError("flow.max_brightness_change: has to be positive");
}

FlowImage BuildFlowImage(const FlowOptions& options, const cv::Mat& gray) {
  if (cv::mean(gray)[0] < options.min_brightness) return WithPyramid(options, Brightened(gray));
  // Tracks keep images as references; the caller may read the next one into the same memory.
  return WithPyramid(options, gray.clone());
}

FlowImage MatchBrightness(const FlowOptions& options, const FlowImage& first, const FlowImage& second) {
  const double gain = BrightnessRatio(first, second);
  // A jump by more is no exposure control: the second image shows something else, or nothing.
  constexpr double kMostGain = 4;
  if (std::abs(gain - 1) <= options.max_brightness_change || gain > kMostGain || gain * kMostGain < 1) return first;
  cv::Mat gray;
  first.gray.convertTo(gray, CV_8U, gain);
  return WithPyramid(options, gray);
}

FlowResult TrackPoints(const FlowOptions& options, const FlowImage& first, const FlowImage& second,
                       const std::vector<cv::Point2f>& points, const std::vector<cv::Point2f>& guesses) {
  FlowResult result;
  if (points.empty()) return result;
  result.points.reserve(points.size());
  for (const cv::Point2f& guess : guesses) result.points.emplace_back(RoundedGuess(guess.x), RoundedGuess(guess.y));
  cv::calcOpticalFlowPyrLK(first.pyramid, second.pyramid, points, result.points, result.found, cv::noArray(),
                           cv::Size(options.window, options.window), LevelsOf(options, first.gray.cols), kTermination,
                           cv::OPTFLOW_USE_INITIAL_FLOW, kMinEigenvalue);
  for (size_t i = 0; i < points.size(); ++i)
    if (!Inside(result.points[i], second.gray.size())) result.found[i] = 0;
  return result;
}

void CheckReturn(const FlowOptions& options, const FlowImage& first, const FlowImage& second,
                 const std::vector<cv::Point2f>& points, FlowResult& result) {
  std::vector<size_t> index;
  std::vector<cv::Point2f> forth;
  std::vector<cv::Point2f> back;
  for (size_t i = 0; i < points.size(); ++i) {
    if (result.found[i] == 0) continue;
    index.push_back(i);
    forth.push_back(result.points[i]);
    back.push_back(points[i]);
  }
  if (index.empty()) return;
  std::vector<uchar> found;
  cv::calcOpticalFlowPyrLK(second.pyramid, first.pyramid, forth, back, found, cv::noArray(),
                           cv::Size(options.window, options.window), kReturnLevels, kTermination,
                           cv::OPTFLOW_USE_INITIAL_FLOW, kMinEigenvalue);
  for (size_t k = 0; k < index.size(); ++k) {
    const cv::Point2f off = back[k] - points[index[k]];
    if (found[k] == 0 || std::hypot(off.x, off.y) > options.max_return_error) result.found[index[k]] = 0;
  }
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/features/optical_flow.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/features/lucas_kanade.h"

namespace turnscale {
namespace {

// The way back starts at the right place, so it needs no coarse levels.
constexpr int kReturnLevels = 1;

// What is compared of a patch and of the place where it was found, pixels, and the least correlation of the two. A
// wrong place in random texture has less.
constexpr int kComparedSide = 9;
constexpr float kLeastCorrelation = 0.5F;

float RoundedGuess(float coordinate) { return std::round(coordinate * 16.0F) / 16.0F; }

// Halvings of an image of this width.
int LevelsOf(const FlowOptions& options, int width) {
  constexpr double kUsualWidth = 1280;
  return options.levels + std::max(0, static_cast<int>(std::lround(std::log2(width / kUsualWidth))));
}

// A dark image has little contrast beside its noise: four times the brightness, smoothed before it is rounded.
cv::Mat Brightened(const cv::Mat& gray) {
  constexpr double kGain = 4;
  constexpr double kSigma = 1.4;    // pixels
  constexpr double kFraction = 64;  // of a gray level
  cv::Mat fine;
  gray.convertTo(fine, CV_16U, kGain * kFraction);
  cv::GaussianBlur(fine, fine, {}, kSigma);
  cv::Mat bright;
  fine.convertTo(bright, CV_8U, 1 / kFraction);
  return bright;
}

// A copy that is part of a larger image, in which the border repeats what is inside, even if `gray` is part of one,
// too.
cv::Mat WithBorder(const cv::Mat& gray) {
  cv::Mat whole;
  cv::copyMakeBorder(gray, whole, kFlowBorder, kFlowBorder, kFlowBorder, kFlowBorder,
                     cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
  return whole(cv::Rect(kFlowBorder, kFlowBorder, gray.cols, gray.rows));
}

// Brightness of the second image over that of the first: the median over blocks, since parts of an image change by
// themselves.
double BrightnessRatio(const FlowImage& first, const FlowImage& second) {
  const cv::Size blocks(16, 8);
  cv::Mat a;
  cv::Mat b;
  cv::resize(first.pyramid.back(), a, blocks, 0, 0, cv::INTER_AREA);
  cv::resize(second.pyramid.back(), b, blocks, 0, 0, cv::INTER_AREA);
  std::vector<double> ratios;
  for (int row = 0; row < blocks.height; ++row)
    for (int column = 0; column < blocks.width; ++column)
      ratios.push_back((b.at<uchar>(row, column) + 1.0) / (a.at<uchar>(row, column) + 1.0));
  return Median(std::move(ratios));
}

// Tracks one point from the coarsest of the levels to the full image. A patch that is flat on a coarse level may have
// texture on a finer one.
std::optional<cv::Point2f> TrackThroughLevels(const FlowOptions& options, const FlowImage& first,
                                              const FlowImage& second, const cv::Point2f& point,
                                              const cv::Point2f& guess, int levels) {
  const LucasKanadeOptions patch{.window = first.dark || second.dark ? options.dark_window : options.window};
  cv::Point2f found = guess;
  for (int level = levels; level > 0; --level) {
    const float scale = 1.0F / static_cast<float>(1 << level);
    const std::optional<cv::Point2f> nearer =
        TrackPatch(patch, first.pyramid[level], scale * point, second.pyramid[level], scale * found);
    if (nearer) found = *nearer / scale;
  }
  return TrackPatch(patch, first.pyramid[0], point, second.pyramid[0], found);
}

int MostLevels(const FlowImage& first, const FlowImage& second) {
  return static_cast<int>(std::min(first.pyramid.size(), second.pyramid.size())) - 1;
}

// For many points, on as many threads as OpenCV is set to use.
void TrackAll(const FlowOptions& options, const FlowImage& first, const FlowImage& second,
              const std::vector<cv::Point2f>& points, int wanted_levels, FlowResult& result) {
  const int levels = std::min(wanted_levels, MostLevels(first, second));
  cv::parallel_for_(cv::Range(0, static_cast<int>(points.size())), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      const std::optional<cv::Point2f> found =
          TrackThroughLevels(options, first, second, points[i], result.points[i], levels);
      result.found[i] = found ? 1 : 0;
      if (found) result.points[i] = *found;
    }
  });
}

// Gray levels around a point, between pixels, less their mean.
using SmallPatch = Eigen::Matrix<float, kComparedSide * kComparedSide, 1>;
SmallPatch GrayAround(const cv::Mat& gray, const cv::Point2f& point) {
  const int left = cvFloor(point.x);
  const int top = cvFloor(point.y);
  const float x = point.x - static_cast<float>(left);
  const float y = point.y - static_cast<float>(top);
  SmallPatch patch;
  for (int row = 0; row < kComparedSide; ++row) {
    // The border is in the same memory.
    const uchar* above =
        gray.data + static_cast<std::ptrdiff_t>(gray.step) * (top + row - kComparedSide / 2) + left - kComparedSide / 2;
    const uchar* below = above + gray.step;
    for (int column = 0; column < kComparedSide; ++column) {
      const auto mix = [&](const uchar* pixels) {
        return (1 - x) * static_cast<float>(pixels[column]) + x * static_cast<float>(pixels[column + 1]);
      };
      patch[row * kComparedSide + column] = (1 - y) * mix(above) + y * mix(below);
    }
  }
  return patch.array() - patch.mean();
}

bool LooksTheSame(const cv::Mat& first, const cv::Point2f& point, const cv::Mat& second, const cv::Point2f& found) {
  const SmallPatch a = GrayAround(first, point);
  const SmallPatch b = GrayAround(second, found);
  return a.dot(b) > kLeastCorrelation * a.norm() * b.norm();
}

bool Inside(const cv::Point2f& point, const cv::Size& size) {
  return point.x >= 0 && point.y >= 0 && point.x <= static_cast<float>(size.width - 1) &&
         point.y <= static_cast<float>(size.height - 1);
}

}  // namespace

void FlowOptions::Check() const {
  const auto is_window = [](int side) { return side >= 5 && side <= kMostFlowWindow && side % 2 == 1; };
  if (!is_window(window)) throw InputError("window: has to be odd and in 5...31 pixels");
  if (!is_window(dark_window)) throw InputError("dark_window: has to be odd and in 5...31 pixels");
  if (levels < 0 || levels > 8) throw InputError("levels: has to be in 0...8");
  if (!(max_return_error > 0)) throw InputError("max_return_error: has to be positive");
  if (!(min_brightness >= 0 && min_brightness <= 255)) throw InputError("min_brightness: has to be in 0...255");
  if (!(max_brightness_change > 0)) throw InputError("max_brightness_change: has to be positive");
}

FlowImage CopyFlowImage(const FlowOptions& options, const cv::Mat& gray) {
  const bool dark = cv::mean(gray)[0] < options.min_brightness;
  // Tracks keep images as references, which are copies: the caller may read the next one into the same memory.
  return {.gray = WithBorder(dark ? Brightened(gray) : gray), .dark = dark, .pyramid = {}};
}

void BuildPyramid(const FlowOptions& options, FlowImage& image) {
  const int levels = LevelsOf(options, image.gray.cols);
  const int window = image.dark ? options.dark_window : options.window;
  image.pyramid = {image.gray};
  for (int level = 0; level < levels; ++level) {
    const cv::Mat& halved = image.pyramid.back();
    if (std::min(halved.cols, halved.rows) / 2 <= window) break;
    cv::Mat half;
    cv::pyrDown(halved, half);
    image.pyramid.push_back(WithBorder(half));
  }
}

FlowImage BuildFlowImage(const FlowOptions& options, const cv::Mat& gray) {
  FlowImage image = CopyFlowImage(options, gray);
  BuildPyramid(options, image);
  return image;
}

FlowImage MatchBrightness(const FlowOptions& options, const FlowImage& first, const FlowImage& second) {
  const double gain = BrightnessRatio(first, second);
  // A jump by more is no exposure control: the second image shows something else, or nothing.
  constexpr double kMostGain = 4;
  if (std::abs(gain - 1) <= options.max_brightness_change || gain > kMostGain || gain * kMostGain < 1) return first;
  cv::Mat gray;
  first.gray.convertTo(gray, CV_8U, gain);
  FlowImage matched = {.gray = WithBorder(gray), .dark = first.dark, .pyramid = {}};
  BuildPyramid(options, matched);
  return matched;
}

FlowResult TrackPoints(const FlowOptions& options, const FlowImage& first, const FlowImage& second,
                       const std::vector<cv::Point2f>& points, const std::vector<cv::Point2f>& guesses,
                       std::optional<int> levels) {
  FlowResult result;
  if (points.empty()) return result;
  result.points.reserve(points.size());
  for (const cv::Point2f& guess : guesses) result.points.emplace_back(RoundedGuess(guess.x), RoundedGuess(guess.y));
  result.found.assign(points.size(), 1);
  TrackAll(options, first, second, points, levels.value_or(LevelsOf(options, first.gray.cols)), result);
  for (size_t i = 0; i < points.size(); ++i)
    if (!Inside(result.points[i], second.gray.size())) result.found[i] = 0;
  return result;
}

void CheckReturn(const FlowOptions& options, const FlowImage& first, const FlowImage& second,
                 const std::vector<cv::Point2f>& points, FlowResult& result) {
  CheckReturn(options, first, second, points, std::vector<uchar>(points.size(), 1), result);
}

void CheckReturn(const FlowOptions& options, const FlowImage& first, const FlowImage& second,
                 const std::vector<cv::Point2f>& points, const std::vector<uchar>& flags, FlowResult& result) {
  if (points.empty()) return;
  const int levels = std::min(kReturnLevels, MostLevels(first, second));
  cv::parallel_for_(cv::Range(0, static_cast<int>(points.size())), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i) {
      if (flags[i] == 0 || result.found[i] == 0) continue;
      const std::optional<cv::Point2f> back =
          TrackThroughLevels(options, second, first, result.points[i], points[i], levels);
      if (!back || std::hypot(back->x - points[i].x, back->y - points[i].y) > options.max_return_error ||
          !LooksTheSame(first.pyramid[0], points[i], second.pyramid[0], result.points[i]))
        result.found[i] = 0;
    }
  });
}

}  // namespace turnscale

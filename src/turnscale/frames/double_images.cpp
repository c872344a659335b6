// SPDX-License-Identifier: MIT
#include "turnscale/frames/double_images.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

// Patches that are compared: their size limits how well a shift can be told from one that is longer or shorter.
constexpr int kRadius = 6;  // pixels
constexpr float kShortestShift = 12;
constexpr float kLongestShift = 80;

// Shifts in motions of a point since the image before.
struct Shifts {
  // The first is that between the two moments. A point that comes nearer moves more in the second half of an interval.
  // In reverse it is the first half, which is not looked at.
  std::vector<float> between_moments;
  // These a second moment makes no more similar. Of a pattern that repeats after the shift between the moments, as
  // railings may, twice the shift is as similar.
  std::vector<float> other;
};

const Shifts& ShiftsOf(FrameBlending::Kind kind) {
  static const Shifts image_before{.between_moments = {1}, .other = {0.65F, 0.8F, 1.2F, 1.35F, 2}};
  static const Shifts half_interval{.between_moments = {0.5F, 0.53F, 0.56F}, .other = {0.325F, 0.4F, 0.65F, 0.725F, 1}};
  return kind == FrameBlending::Kind::kHalfInterval ? half_interval : image_before;
}

// Points that are looked at, and the fewest that tell something of an image.
constexpr std::size_t kMostPoints = 100;
constexpr std::size_t kFewestPoints = 12;

// Excess of the similarity at the shift between the moments over the largest at the other shifts. Its median over the
// points of an image is about -0.15 to -0.2 for one moment, as the largest of several is positive by chance, and 0 to
// 0.1 for two equally strong ones.
constexpr double kLeastExcess = 0.01;
constexpr double kLeastShareOfImages = 0.25;
constexpr std::ptrdiff_t kFewestImages = 16;  // that show two moments

bool HasPatch(const cv::Mat& gray, const cv::Point& centre) {
  return centre.x >= kRadius && centre.y >= kRadius && centre.x < gray.cols - kRadius && centre.y < gray.rows - kRadius;
}

// Correlation of the gray levels around two points.
double Similarity(const cv::Mat& gray, const cv::Point& first, const cv::Point& second) {
  constexpr double kPixels = (2 * kRadius + 1) * (2 * kRadius + 1);
  std::int64_t a = 0;
  std::int64_t b = 0;
  std::int64_t aa = 0;
  std::int64_t bb = 0;
  std::int64_t ab = 0;
  for (int row = -kRadius; row <= kRadius; ++row) {
    const auto* of_first = gray.ptr<std::uint8_t>(first.y + row) + first.x;
    const auto* of_second = gray.ptr<std::uint8_t>(second.y + row) + second.x;
    for (int column = -kRadius; column <= kRadius; ++column) {
      const int u = of_first[column];
      const int v = of_second[column];
      a += u;
      b += v;
      aa += u * u;
      bb += v * v;
      ab += u * v;
    }
  }
  const double covariance = static_cast<double>(ab) - static_cast<double>(a * b) / kPixels;
  const double variances = (static_cast<double>(aa) - static_cast<double>(a * a) / kPixels) *
                           (static_cast<double>(bb) - static_cast<double>(b * b) / kPixels);
  return variances > 0 ? covariance / std::sqrt(variances) : 0;
}

// Largest similarity of a point's image to what is at these shifts; empty near the edges of the image.
std::optional<double> LargestSimilarity(const cv::Mat& gray, const MovedPoint& point,
                                        const std::vector<float>& shifts) {
  double largest = -1;
  for (const float shift : shifts) {
    const cv::Point there = point.now - shift * (point.now - point.before);
    if (!HasPatch(gray, there)) return std::nullopt;
    largest = std::max(largest, Similarity(gray, point.now, there));
  }
  return largest;
}

// Median of the points' excess; empty where too few move far enough.
std::optional<double> MedianExcess(const cv::Mat& gray, const std::vector<MovedPoint>& points, const Shifts& shifts) {
  std::vector<MovedPoint> moved;
  for (const MovedPoint& point : points) {
    const double shift = shifts.between_moments.front() * cv::norm(point.now - point.before);
    if (shift >= kShortestShift && shift <= kLongestShift && HasPatch(gray, point.now)) moved.push_back(point);
  }
  const std::size_t count = std::min(moved.size(), kMostPoints);
  std::vector<double> excess;
  for (std::size_t i = 0; i < count; ++i) {
    const MovedPoint& point = moved[i * moved.size() / count];
    const std::optional<double> between = LargestSimilarity(gray, point, shifts.between_moments);
    const std::optional<double> other = LargestSimilarity(gray, point, shifts.other);
    if (between && other) excess.push_back(*between - *other);
  }
  if (excess.size() < kFewestPoints) return std::nullopt;
  return Median(std::move(excess));
}

}  // namespace

void DoubleImages::Add(const cv::Mat& gray, double time, const std::vector<MovedPoint>& points) {
  for (Tested& tested : tested_)
    if (const std::optional<double> excess = MedianExcess(gray, points, ShiftsOf(tested.kind)))
      tested.images.push_back({time, *excess});
}

std::optional<FrameBlending> DoubleImages::Find() const {
  const auto is_double = [](const Measured& image) { return image.excess >= kLeastExcess; };
  for (const auto& [kind, images] : tested_) {
    const std::ptrdiff_t count = std::ranges::count_if(images, is_double);
    if (count < kFewestImages || static_cast<double>(count) < kLeastShareOfImages * static_cast<double>(images.size()))
      continue;
    const auto first = std::ranges::find_if(images, is_double);
    const auto last = std::find_if(images.rbegin(), images.rend(), is_double);
    return FrameBlending{.from = first->time, .to = last->time, .kind = kind};
  }
  return std::nullopt;
}

}  // namespace turnscale

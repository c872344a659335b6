// SPDX-License-Identifier: MIT
#include "turnscale/frames/double_images.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

// Patches that are compared: their size limits how well a shift can be told from one that is longer or shorter.
constexpr int kRadius = 6;  // pixels
constexpr float kShortestMotion = 12;
constexpr float kLongestMotion = 80;
// Shifts, in motions of a point, that a second moment makes no more similar. Of a pattern that repeats after the
// motion, as railings may, twice the motion is as similar.
constexpr float kOtherShifts[] = {0.65F, 0.8F, 1.2F, 1.35F, 2.0F};

// Points that are looked at, and the fewest that tell something of an image.
constexpr std::size_t kMostPoints = 100;
constexpr std::size_t kFewestPoints = 12;

// Excess of the similarity at the motion over the largest at the other shifts. Its median over the points of an image
// is about -0.2 for one moment, as the largest of several is positive by chance, and 0 to 0.1 for two equally strong
// ones.
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

// How much more similar the motion of a point makes its image than other shifts; empty near the edges of the image.
std::optional<double> ExcessAt(const cv::Mat& gray, const MovedPoint& point) {
  const cv::Point2f motion = point.now - point.before;
  const cv::Point here = point.now;
  const cv::Point before = point.before;
  if (!HasPatch(gray, here) || !HasPatch(gray, before)) return std::nullopt;
  double other = -1;
  for (const float shift : kOtherShifts) {
    const cv::Point there = point.now - shift * motion;
    if (!HasPatch(gray, there)) return std::nullopt;
    other = std::max(other, Similarity(gray, here, there));
  }
  return Similarity(gray, here, before) - other;
}

}  // namespace

void DoubleImages::Add(const cv::Mat& gray, double time, const std::vector<MovedPoint>& points) {
  std::vector<MovedPoint> moved;
  for (const MovedPoint& point : points) {
    const double motion = cv::norm(point.now - point.before);
    if (motion >= kShortestMotion && motion <= kLongestMotion) moved.push_back(point);
  }
  const std::size_t count = std::min(moved.size(), kMostPoints);
  std::vector<double> excess;
  for (std::size_t i = 0; i < count; ++i)
    if (const std::optional<double> of_point = ExcessAt(gray, moved[i * moved.size() / count]))
      excess.push_back(*of_point);
  if (excess.size() >= kFewestPoints) images_.push_back({time, Median(std::move(excess))});
}

std::optional<FrameBlending> DoubleImages::Find() const {
  const auto is_double = [](const Measured& image) { return image.excess >= kLeastExcess; };
  const std::ptrdiff_t count = std::ranges::count_if(images_, is_double);
  if (count < kFewestImages || static_cast<double>(count) < kLeastShareOfImages * static_cast<double>(images_.size()))
    return std::nullopt;
  const auto first = std::ranges::find_if(images_, is_double);
  const auto last = std::find_if(images_.rbegin(), images_.rend(), is_double);
  return FrameBlending{.from = first->time, .to = last->time, .period = 0};
}

}  // namespace turnscale

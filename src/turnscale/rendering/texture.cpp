// SPDX-License-Identifier: MIT
#include "turnscale/rendering/texture.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

// Samples along a long axis, at most: beyond that the pixel is blurred across.
constexpr int kMaxSamples = 8;
// What each of so many samples counts.
constexpr std::array<float, kMaxSamples + 1> kParts = {0,        1,        1.0F / 2, 1.0F / 3, 1.0F / 4,
                                                       1.0F / 5, 1.0F / 6, 1.0F / 7, 1.0F / 8};

// Half the rows, each the mean of four with weights 1 3 3 1: less aliasing than the mean of two, and no shift.
cv::Mat HalveRows(const cv::Mat& fine) {
  const int mask = fine.rows - 1;
  cv::Mat coarse(fine.rows / 2, fine.cols, CV_32F);
  for (int row = 0; row < coarse.rows; ++row) {
    const auto* above = fine.ptr<float>((2 * row - 1) & mask);
    const auto* first = fine.ptr<float>(2 * row);
    const auto* second = fine.ptr<float>(2 * row + 1);
    const auto* below = fine.ptr<float>((2 * row + 2) & mask);
    auto* out = coarse.ptr<float>(row);
    for (int column = 0; column < fine.cols; ++column)
      out[column] = 0.125F * (above[column] + below[column]) + 0.375F * (first[column] + second[column]);
  }
  return coarse;
}

// The logarithm to base 2, 0.09 too small at most, without a call; x > 0.
inline float RoughLog2(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  return static_cast<float>(bits) * 0x1p-23F - 127.0F;
}

// Vectors of the compiler's own: four floats at a time on every processor.
using Float4 = float __attribute__((vector_size(16)));

// Parts of a turn of the pattern in units of 2^-32: wraps around by itself.
struct Phase {
  std::uint32_t x = 0;
  std::uint32_t y = 0;
};

std::uint32_t PhaseOf(float turns) { return static_cast<std::uint32_t>(static_cast<std::int64_t>(turns * 0x1p32F)); }

// Sum of `count` bilinear samples at `at`, `at + step`, ..., each of its four pixels by itself.
inline Float4 SumSamples(const float* level, int shift, Phase at, const Phase& step, int count) {
  const std::uint32_t half = 0x80000000U >> shift;
  const size_t stride = (size_t{1} << shift) + 1;
  at.x -= half;
  at.y -= half;
  Float4 sum = {0, 0, 0, 0};
  for (int i = 0; i < count; ++i) {
    // Whole pixels above 32 bits, the rest below.
    const std::uint64_t x = static_cast<std::uint64_t>(at.x) << shift;
    const std::uint64_t y = static_cast<std::uint64_t>(at.y) << shift;
    const float* const above = level + (y >> 32U) * stride + (x >> 32U);
    const float* const below = above + stride;
    const Float4 pixels = {above[0], above[1], below[0], below[1]};
    const float right = static_cast<float>(static_cast<std::int32_t>(static_cast<std::uint32_t>(x) >> 1U)) * 0x1p-31F;
    const float down = static_cast<float>(static_cast<std::int32_t>(static_cast<std::uint32_t>(y) >> 1U)) * 0x1p-31F;
    const Float4 columns = {1 - right, right, 1 - right, right};
    const Float4 rows = {1 - down, 1 - down, down, down};
    sum += pixels * (columns * rows);
    at.x += step.x;
    at.y += step.y;
  }
  return sum;
}

}  // namespace

Texture::Texture(const cv::Mat& pattern, double size) : size_(size) {
  if (pattern.type() != CV_32F || pattern.rows != pattern.cols || pattern.rows < 1 ||
      !std::has_single_bit(static_cast<unsigned>(pattern.rows)))
    throw InternalError("a texture's pattern is CV_32F and square, its side a power of two");
  if (!(size > 0)) throw InternalError("a texture's size is above 0");
  double least = 0;
  double most = 0;
  cv::minMaxLoc(pattern, &least, &most);
  if (!(least >= 0 && most < 1e6)) throw InternalError("a texture's pattern is not negative");
  per_metre_ = static_cast<float>(1 / size);
  pixels_per_metre_ = static_cast<float>(pattern.rows / size);
  std::vector<Level> levels;
  cv::Mat pixels = pattern;
  while (true) {
    Level& level = levels.emplace_back();
    level.shift = std::countr_zero(static_cast<unsigned>(pixels.rows));
    const int mask = pixels.rows - 1;
    level.pixels.reserve(static_cast<size_t>(pixels.rows + 1) * (pixels.cols + 1));
    for (int row = 0; row <= pixels.rows; ++row) {
      const auto* here = pixels.ptr<float>(row & mask);
      for (int column = 0; column <= pixels.cols; ++column) level.pixels.push_back(here[column & mask]);
    }
    if (pixels.rows == 1) break;
    const cv::Mat halved = HalveRows(pixels);
    pixels = HalveRows(halved.t()).t();
  }
  levels_ = std::make_shared<const std::vector<Level>>(std::move(levels));
}

Texture Texture::WithContrast(float factor) const {
  std::vector<Level> levels = *levels_;
  const float mean = levels.back().pixels.front();
  for (Level& level : levels)
    for (float& value : level.pixels) value = std::max(0.0F, mean + factor * (value - mean));
  Texture other = *this;
  other.levels_ = std::make_shared<const std::vector<Level>>(std::move(levels));
  return other;
}

float Texture::Sample(const Eigen::Vector2f& at, const Eigen::Vector2f& major, float minor) const {
  const float length = major.norm();
  const float width = std::max({minor, length / kMaxSamples, 1e-9F});
  const int samples = std::clamp(static_cast<int>((length + 0.5F * width) / width), 1, kMaxSamples);
  // The level whose pixels are as wide as the ellipse, and the next coarser one.
  const std::vector<Level>& levels = *levels_;
  const int last = static_cast<int>(levels.size()) - 1;
  const float wanted = std::clamp(RoughLog2(2 * width * pixels_per_metre_), 0.0F, static_cast<float>(last));
  const int level = static_cast<int>(wanted);
  // Near to a level there is nothing of the next one: that saves half of the samples of both.
  const float coarser = std::clamp(2 * (wanted - static_cast<float>(level)) - 0.5F, 0.0F, 1.0F);

  const auto mean_of = [&](const Level& from, int count) {
    const float part = kParts[count];
    const Eigen::Vector2f step = major * (2 * part);
    const Eigen::Vector2f first = at - major * (static_cast<float>(count - 1) * part);
    const Phase start = {PhaseOf(first.x() * per_metre_), PhaseOf(first.y() * per_metre_)};
    const Phase stride = {PhaseOf(step.x() * per_metre_), PhaseOf(step.y() * per_metre_)};
    return SumSamples(from.pixels.data(), from.shift, start, stride, count) * part;
  };
  Float4 mean = {0, 0, 0, 0};
  if (coarser < 1) mean = (1 - coarser) * mean_of(levels[level], samples);
  // The coarser level's pixels are twice as wide: half the samples cover the axis.
  if (coarser > 0) mean += coarser * mean_of(levels[std::min(level + 1, last)], (samples + 1) / 2);
  return (mean[0] + mean[1]) + (mean[2] + mean[3]);
}

}  // namespace turnscale

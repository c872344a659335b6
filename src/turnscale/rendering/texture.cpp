// SPDX-License-Identifier: MIT
#include "turnscale/rendering/texture.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace turnscale {
namespace {

// Samples along a long axis, at most: beyond that the pixel is blurred across.
constexpr int kMaxSamples = 8;

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

// The greatest integer not above x, for numbers that fit; std::floor is a call on plain x86-64.
inline int Floor(float x) {
  const int truncated = static_cast<int>(x);
  return truncated - static_cast<int>(static_cast<float>(truncated) > x);
}

// The logarithm to base 2, 0.09 too small at most, without a call; x > 0.
inline float RoughLog2(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  return static_cast<float>(bits) * 0x1p-23F - 127.0F;
}

}  // namespace

Texture::Texture(const cv::Mat& pattern, double size) : size_(size) {
  if (pattern.type() != CV_32F || pattern.rows != pattern.cols || pattern.rows < 1 ||
      !std::has_single_bit(static_cast<unsigned>(pattern.rows)))
    throw std::invalid_argument("a texture's pattern is CV_32F and square, its side a power of two");
  if (!(size > 0)) throw std::invalid_argument("a texture's size is above 0");
  cv::Mat pixels = pattern.clone();
  while (true) {
    const int shift = std::countr_zero(static_cast<unsigned>(pixels.rows));
    levels_.push_back({pixels, shift, static_cast<float>(pixels.rows / size)});
    if (pixels.rows == 1) break;
    const cv::Mat halved = HalveRows(pixels);
    pixels = HalveRows(halved.t()).t();
  }
}

inline float Texture::Bilinear(const Level& level, const Eigen::Vector2f& at) {
  const float x = at.x() * level.pixels_per_metre - 0.5F;
  const float y = at.y() * level.pixels_per_metre - 0.5F;
  const int column = Floor(x);
  const int row = Floor(y);
  const float right = x - static_cast<float>(column);
  const float down = y - static_cast<float>(row);
  const int mask = (1 << level.shift) - 1;
  const auto* data = reinterpret_cast<const float*>(level.pixels.data);
  const float* above = data + (static_cast<std::ptrdiff_t>(row & mask) << level.shift);
  const float* below = data + (static_cast<std::ptrdiff_t>((row + 1) & mask) << level.shift);
  const int left = column & mask;
  const int next = (column + 1) & mask;
  const float upper = above[left] + right * (above[next] - above[left]);
  const float lower = below[left] + right * (below[next] - below[left]);
  return upper + down * (lower - upper);
}

float Texture::Sample(const Eigen::Vector2f& at, const Eigen::Vector2f& major, float minor) const {
  const float length = major.norm();
  const float width = std::max({minor, length / kMaxSamples, 1e-9F});
  const int samples = std::clamp(static_cast<int>(std::ceil(length / width - 0.25F)), 1, kMaxSamples);
  // The level whose pixels are as wide as the ellipse, and the next coarser one.
  const float fine_level = RoughLog2(2 * width * levels_[0].pixels_per_metre);
  const auto last = static_cast<float>(levels_.size() - 1);
  const float clamped = std::clamp(fine_level, 0.0F, last);
  const int level = static_cast<int>(clamped);
  const float coarser = clamped - static_cast<float>(level);
  const Level& fine = levels_[level];
  const Level& coarse = levels_[std::min(level + 1, static_cast<int>(last))];
  const Eigen::Vector2f step = major * (2.0F / static_cast<float>(samples));
  Eigen::Vector2f place = at - 0.5F * static_cast<float>(samples - 1) * step;
  float fine_sum = 0;
  float coarse_sum = 0;
  for (int i = 0; i < samples; ++i, place += step) {
    fine_sum += Bilinear(fine, place);
    if (coarser > 0) coarse_sum += Bilinear(coarse, place);
  }
  return (fine_sum + coarser * (coarse_sum - fine_sum)) / static_cast<float>(samples);
}

}  // namespace turnscale

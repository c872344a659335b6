// SPDX-License-Identifier: MIT
#include "turnscale/rendering/pattern_drawing.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"

namespace turnscale {
namespace {

// Waves longer than a quarter of the side are no stronger than these: they would show where the pattern repeats.
constexpr double kLowestFrequency = 4;

// What waves of so many turns down and across the side are multiplied by: the other half of them are these mirrored.
cv::Mat Gains(int side, double roughness) {
  cv::Mat gains(side / 2 + 1, side / 2 + 1, CV_32F);
  for (int down = 0; down < gains.rows; ++down) {
    for (int across = 0; across <= down; ++across) {
      const double frequency = std::hypot(down, across);
      const double gain = down == 0 ? 0 : std::pow(std::max(frequency, kLowestFrequency), -roughness);
      gains.at<float>(down, across) = gains.at<float>(across, down) = static_cast<float>(gain);
    }
  }
  return gains;
}

}  // namespace

void CheckSide(const PatternOptions& options) {
  if (options.side < 16 || !std::has_single_bit(static_cast<unsigned>(options.side)))
    throw InternalError("the side of a pattern is a power of two, 16 or more");
}

cv::Mat Clouds(int side, std::uint64_t seed, double roughness) {
  cv::Mat noise(side, side, CV_32F);
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) noise.at<float>(row, column) = HashUniform(seed, row, column) - 0.5F;
  cv::Mat spectrum;
  cv::dft(noise, spectrum, cv::DFT_COMPLEX_OUTPUT);
  const cv::Mat gains = Gains(side, roughness);
  for (int row = 0; row < side; ++row) {
    const auto* gain = gains.ptr<float>(std::min(row, side - row));
    auto* wave = spectrum.ptr<cv::Vec2f>(row);
    for (int column = 0; column < side; ++column) wave[column] *= gain[std::min(column, side - column)];
  }
  cv::Mat clouds;
  cv::dft(spectrum, clouds, cv::DFT_INVERSE | cv::DFT_REAL_OUTPUT | cv::DFT_SCALE);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(clouds, mean, deviation);
  return (clouds - mean[0]) / deviation[0];
}

void Finish(const PatternOptions& options, cv::Mat& pattern) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(pattern, mean, deviation);
  const double gain = options.contrast / std::max(deviation[0], 1e-9);
  pattern.convertTo(pattern, CV_32F, gain, options.mean - gain * mean[0]);
  cv::max(pattern, 0.02 * options.mean, pattern);
  cv::min(pattern, options.mean + 5.0 * options.contrast, pattern);
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/rendering/pattern_drawing.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "turnscale/base/random.h"

namespace turnscale {
namespace {

// Waves longer than a quarter of the side are no stronger than these: they would show where the pattern repeats.
constexpr double kLowestFrequency = 4;

}  // namespace

void CheckSide(const PatternOptions& options) {
  if (options.side < 16 || !std::has_single_bit(static_cast<unsigned>(options.side)))
    throw std::invalid_argument("the side of a pattern is a power of two, 16 or more");
}

cv::Mat Clouds(int side, std::uint64_t seed, double roughness) {
  cv::Mat noise(side, side, CV_32F);
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) noise.at<float>(row, column) = HashUniform(seed, row, column) - 0.5F;
  cv::Mat spectrum;
  cv::dft(noise, spectrum, cv::DFT_COMPLEX_OUTPUT);
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const double down = std::min(row, side - row);
      const double across = std::min(column, side - column);
      const double frequency = std::hypot(down, across);
      const double gain = frequency == 0 ? 0 : std::pow(std::max(frequency, kLowestFrequency), -roughness);
      spectrum.at<cv::Vec2f>(row, column) *= static_cast<float>(gain);
    }
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

// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

namespace turnscale {

/// A smooth random pattern whose gray level is known at any place, for tests: a sum of waves in all directions.
class SyntheticTexture {
 public:
  /// Wavelengths are in the unit of the places that are asked for.
  explicit SyntheticTexture(unsigned seed, double shortest_wave = 8, double longest_wave = 30, double contrast = 35) {
    constexpr int kWaves = 16;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    amplitude_ = contrast * std::sqrt(2.0 / kWaves);
    for (int i = 0; i < kWaves; ++i) {
      const double direction = 2 * M_PI * uniform(random);
      const double wave = shortest_wave * std::pow(longest_wave / shortest_wave, uniform(random));
      const double frequency = 2 * M_PI / wave;
      waves_.emplace_back(frequency * std::cos(direction), frequency * std::sin(direction), 2 * M_PI * uniform(random));
    }
  }

  /// Gray level at a place; mean 128, standard deviation `contrast`.
  double At(const Eigen::Vector2d& place) const {
    double sum = 128;
    for (const Eigen::Vector3d& wave : waves_) sum += amplitude_ * std::cos(wave.head<2>().dot(place) + wave.z());
    return sum;
  }

 private:
  double amplitude_ = 0;
  std::vector<Eigen::Vector3d> waves_;  // frequency by x, by y, phase
};

/// An 8-bit image of what `gray_at` (gray level of a pixel, Eigen::Vector2d) gives.
template <typename GrayAt>
cv::Mat MakeImage(const cv::Size& size, const GrayAt& gray_at) {
  cv::Mat image(size, CV_8U);
  for (int row = 0; row < size.height; ++row)
    for (int column = 0; column < size.width; ++column)
      image.at<uchar>(row, column) = cv::saturate_cast<uchar>(gray_at(Eigen::Vector2d(column, row)));
  return image;
}

}  // namespace turnscale

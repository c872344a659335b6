// SPDX-License-Identifier: MIT
#include "turnscale/scale/camera_height.h"

#include <cmath>

namespace turnscale {

double HeightByScale(const ScaleEstimate& estimate) {
  return estimate.car.camera_height * std::exp(estimate.single_turn_offset);
}

double HeightSigma(const ScaleEstimate& estimate, double other_sigma) {
  const double slip = estimate.slip_conflict ? estimate.test.disagreement : 0;
  const double between = estimate.height_conflict ? estimate.height_conflict->scale_sigma() : 0;
  const double smoothing = estimate.image_smoothing ? estimate.image_smoothing->scale_error : 0;
  const double lag = estimate.image_lag ? estimate.image_lag->scale_error : 0;
  const double relative = std::hypot(std::hypot(other_sigma, slip, between), smoothing, lag);
  const double factor = std::exp(estimate.single_turn_offset);
  return std::hypot(estimate.car.camera_height_sigma * factor,
                    std::hypot(relative, estimate.single_turn_spread) * HeightByScale(estimate));
}

std::optional<UnusualHeight> FindUnusualHeight(double height, double sigma) {
  constexpr double kLeast = 0.9;  // m
  constexpr double kMost = 2.4;   // m
  const double reach = 2 * sigma;
  const bool is_low = height + reach < kLeast;
  if (height == 0 || (!is_low && height - reach <= kMost)) return std::nullopt;
  return UnusualHeight{height, sigma, std::abs(std::log(height / kUsualHeight)), is_low};
}

}  // namespace turnscale

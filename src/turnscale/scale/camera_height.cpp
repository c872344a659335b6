// SPDX-License-Identifier: MIT
#include "turnscale/scale/camera_height.h"

#include <cmath>

namespace turnscale {

double HeightByScale(const ScaleEstimate& estimate) {
  return estimate.car.camera_height * std::exp(estimate.single_turn_offset);
}

double HeightSigma(const ScaleEstimate& estimate, double other_sigma) {
  // The spread of single-turn scales has it already.
  const double slip = estimate.slip_conflict && !estimate.uses_single_turns ? estimate.test.disagreement : 0;
  const double between = estimate.height_conflict ? estimate.height_conflict->scale_sigma() : 0;
  const double smoothing = estimate.image_smoothing ? estimate.image_smoothing->scale_error : 0;
  const double lag = estimate.image_lag ? estimate.image_lag->scale_error : 0;
  const double relative = std::hypot(std::hypot(other_sigma, slip, between), smoothing, lag);
  const double factor = std::exp(estimate.single_turn_offset);
  return std::hypot(estimate.car.camera_height_sigma * factor,
                    std::hypot(relative, estimate.single_turn_spread) * HeightByScale(estimate));
}

std::optional<UnusualHeight> FindUnusualHeight(double height, double sigma) {
  if (height == 0) return std::nullopt;
  const double difference = std::log(height / kUsualHeight);
  if (std::abs(difference) <= 2 * std::hypot(kUsualHeightSpread, sigma / height)) return std::nullopt;
  return UnusualHeight{height, sigma, std::abs(difference), difference < 0};
}

}  // namespace turnscale

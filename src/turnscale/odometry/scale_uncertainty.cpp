// SPDX-License-Identifier: MIT
#include "turnscale/odometry/scale_uncertainty.h"

#include <cmath>

namespace turnscale {
namespace {

Eigen::Vector3d Centre(const Keyframe& keyframe) { return keyframe.camera_from_world.inverse().translation; }

double StepLength(const Map& map, size_t k) { return (Centre(map.keyframes[k]) - Centre(map.keyframes[k - 1])).norm(); }

}  // namespace

double CarriedVariance(const ScaleOptions& options, double sigma, double distance) {
  return sigma * sigma + options.drift_per_root_metre * options.drift_per_root_metre * distance;
}

std::vector<double> ScaleSigmas(const ScaleOptions& options, const Map& map,
                                const std::vector<ObservedStretch>& observed) {
  // Information (inverse variance) from the turn before and from the turn after add up.
  const size_t keyframes = map.keyframes.size();
  std::vector<double> information(keyframes, 0.0);
  std::vector<double> known(keyframes, 0.0);
  for (const ObservedStretch& stretch : observed)
    for (int k = stretch.first; k <= stretch.last; ++k) known[k] = stretch.sigma;
  const auto sweep = [&](auto index_of, auto step_before) {
    double sigma = 0;
    double distance = 0;
    bool started = false;
    for (size_t i = 0; i < keyframes; ++i) {
      const size_t k = index_of(i);
      if (i > 0) distance += step_before(k);
      if (known[k] > 0) {
        sigma = known[k];
        distance = 0;
        started = true;
      } else if (started) {
        information[k] += 1.0 / CarriedVariance(options, sigma, distance);
      }
    }
  };
  sweep([](size_t i) { return i; }, [&](size_t k) { return StepLength(map, k); });
  sweep([&](size_t i) { return keyframes - 1 - i; }, [&](size_t k) { return StepLength(map, k + 1); });

  std::vector<double> sigmas(keyframes);
  for (size_t k = 0; k < keyframes; ++k) sigmas[k] = known[k] > 0 ? known[k] : 1.0 / std::sqrt(information[k]);
  return sigmas;
}

}  // namespace turnscale

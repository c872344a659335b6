// SPDX-License-Identifier: MIT
#include "turnscale/odometry/scale_uncertainty.h"

#include <cmath>

namespace turnscale {
namespace {

double StepLength(const Map& map, size_t k) { return (Centre(map.keyframes[k]) - Centre(map.keyframes[k - 1])).norm(); }

}  // namespace

double CarriedVariance(const ScaleOptions& options, double sigma, const ScaleCarriage& carriage) {
  return sigma * sigma + options.drift_per_root_metre * options.drift_per_root_metre * carriage.distance +
         options.gap_sigma * options.gap_sigma * carriage.gaps;
}

std::vector<double> ScaleSigmas(const ScaleOptions& options, const Map& map,
                                const std::vector<ObservedStretch>& observed) {
  // Information (inverse variance) from the turn before and from the turn after add up.
  const size_t keyframes = map.keyframes.size();
  std::vector<double> information(keyframes, 0.0);
  std::vector<double> known(keyframes, 0.0);
  for (const ObservedStretch& stretch : observed)
    for (int k = stretch.first; k <= stretch.last; ++k) known[k] = stretch.sigma;
  // `step_of` names, for each keyframe in the order of the sweep, the step that leads to it.
  const auto sweep = [&](auto index_of, auto step_of) {
    double sigma = 0;
    ScaleCarriage carriage;
    for (size_t i = 0; i < keyframes; ++i) {
      const size_t k = index_of(i);
      if (i > 0) carriage.distance += StepLength(map, step_of(k));
      if (i > 0 && map.keyframes[step_of(k)].after_gap) ++carriage.gaps;
      if (known[k] > 0) {
        sigma = known[k];
        carriage = {};
      } else if (sigma > 0) {
        information[k] += 1.0 / CarriedVariance(options, sigma, carriage);
      }
    }
  };
  sweep([](size_t i) { return i; }, [](size_t k) { return k; });
  sweep([&](size_t i) { return keyframes - 1 - i; }, [](size_t k) { return k + 1; });

  std::vector<double> sigmas(keyframes);
  for (size_t k = 0; k < keyframes; ++k) sigmas[k] = known[k] > 0 ? known[k] : 1.0 / std::sqrt(information[k]);
  return sigmas;
}

}  // namespace turnscale

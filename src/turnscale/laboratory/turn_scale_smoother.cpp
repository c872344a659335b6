// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/turn_scale_smoother.h"

#include <cmath>
#include <cstddef>

namespace turnscale {
namespace {

/// Metres from the middle of one turn to that of the next.
double PathBetween(const ObservedTurn& a, const ObservedTurn& b, const std::vector<Eigen::Vector3d>& centres) {
  double units = 0;
  for (int k = (a.region.first + a.region.last) / 2; k < (b.region.first + b.region.last) / 2; ++k)
    units += (centres[k + 1] - centres[k]).norm();
  return units * std::sqrt(a.metres_per_unit * b.metres_per_unit);
}

}  // namespace

void SmoothTurnScales(const std::vector<Eigen::Vector3d>& centres, double drift_per_root_metre,
                      std::vector<ObservedTurn>& turns) {
  const std::size_t n = turns.size();
  std::vector<double> mean(n);
  std::vector<double> variance(n);
  std::vector<double> walked(n, 0);  // variance that the way from the turn before adds
  for (std::size_t i = 0; i < n; ++i) {
    const double observed = std::log(turns[i].metres_per_unit);
    const double noise = turns[i].relative_sigma * turns[i].relative_sigma;
    if (i == 0) {
      mean[i] = observed;
      variance[i] = noise;
      continue;
    }
    walked[i] = drift_per_root_metre * drift_per_root_metre * PathBetween(turns[i - 1], turns[i], centres);
    const double predicted = variance[i - 1] + walked[i];
    const double gain = predicted / (predicted + noise);
    mean[i] = mean[i - 1] + gain * (observed - mean[i - 1]);
    variance[i] = (1 - gain) * predicted;
  }
  for (std::size_t i = n; i-- > 1;) {
    const double gain = variance[i - 1] / (variance[i - 1] + walked[i]);
    mean[i - 1] += gain * (mean[i] - mean[i - 1]);
    variance[i - 1] += gain * gain * (variance[i] - variance[i - 1] - walked[i]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    turns[i].metres_per_unit = std::exp(mean[i]);
    turns[i].relative_sigma = std::sqrt(variance[i]);
  }
}

}  // namespace turnscale

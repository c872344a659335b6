// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/statistics.h"

#include <algorithm>
#include <cmath>

namespace turnscale {

ErrorStatistics Summarize(std::vector<double> errors) {
  ErrorStatistics statistics;
  if (errors.empty()) return statistics;
  double squares = 0;
  for (double& error : errors) {
    error = std::abs(error);
    squares += error * error;
  }
  std::sort(errors.begin(), errors.end());
  const size_t middle = errors.size() / 2;
  statistics.count = static_cast<int>(errors.size());
  statistics.rms = std::sqrt(squares / static_cast<double>(errors.size()));
  statistics.median = errors.size() % 2 == 1 ? errors[middle] : 0.5 * (errors[middle - 1] + errors[middle]);
  statistics.max = errors.back();
  return statistics;
}

}  // namespace turnscale

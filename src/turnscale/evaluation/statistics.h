// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <vector>

namespace turnscale {

/// Statistics of a set of errors, in the errors' unit; NaN if there are none.
struct ErrorStatistics {
  int count = 0;
  double rms = std::numeric_limits<double>::quiet_NaN();
  double median = std::numeric_limits<double>::quiet_NaN();  ///< of the magnitudes
  double max = std::numeric_limits<double>::quiet_NaN();     ///< of the magnitudes
};

ErrorStatistics Summarize(std::vector<double> errors);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <vector>

namespace turnscale {

/// What a set of errors amounts to, in the errors' own unit; NaN where there are none.
struct ErrorStatistics {
  int count = 0;
  double rms = std::numeric_limits<double>::quiet_NaN();
  double median = std::numeric_limits<double>::quiet_NaN();  ///< of the magnitudes
  double max = std::numeric_limits<double>::quiet_NaN();     ///< of the magnitudes
};

ErrorStatistics Summarize(std::vector<double> errors);

}  // namespace turnscale

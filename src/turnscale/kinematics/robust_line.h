// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace turnscale {

/// A point of a line through the origin; all noise is in y.
struct LinePoint {
  double x = 0;
  double y = 0;
};

/// A line y = slope x fitted to points.
struct RobustLine {
  double slope = 0;
  double sigma = 0;            ///< standard deviation of the slope
  std::vector<double> weight;  ///< one per point, in [0, 1]
};

/// Robust line through the origin: iterated least squares with Tukey's biweight, started at the weighted L1 line.
/// `noise_floor` is a lower bound of the standard deviation of y, in the unit of y; must be positive.
/// Residuals beyond `threshold` robust standard deviations have no weight. At least one x has to differ from 0.
RobustLine FitRobustLine(const std::vector<LinePoint>& points, double noise_floor, double threshold);

}  // namespace turnscale

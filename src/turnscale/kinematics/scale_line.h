// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace turnscale {

/// A step as a point of the pooled line: at scale l it should fulfil l y = (L - slip l^2) x.
struct ScaleLinePoint {
  double x = 0;     ///< 2 sin(psi/2)
  double y = 0;     ///< sideways step, odometry units
  double slip = 0;  ///< c (step/dt)^2, metres per square of the scale; 0 for the rigid car
};

/// A scale fitted to points. The scale is not positive and finite where the points allow none.
struct ScaleLine {
  double scale = 0;            ///< metres per unit
  double sigma = 0;            ///< its standard deviation
  std::vector<double> weight;  ///< one a point, in [0, 1]
};

/// Robust line through the origin: iterated least squares with Tukey's biweight, started at the weighted L1 line.
/// `noise_floor` is the least standard deviation of y that is believed in, odometry units; must be positive.
ScaleLine FitScaleLine(const std::vector<ScaleLinePoint>& points, double lever_arm, double noise_floor,
                       double robust_threshold);

/// Median of the scales that the points give one by one. Points that give none (wrong sign) count as infinite scales.
ScaleLine MedianScale(const std::vector<ScaleLinePoint>& points, double lever_arm);

}  // namespace turnscale

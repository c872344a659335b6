// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/scale/path_segment.h"
#include "turnscale/scale/scale_evidence.h"

namespace turnscale {

/// How fast the odometry's scale is taken to drift: a random walk of its logarithm.
struct DriftOptions {
  double per_100m = 0.01;    ///< standard deviation gathered over 100 m
  double per_90deg = 0.005;  ///< and over 90 degrees of turning: what is left of the lens bends the scale in turns

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Mean and covariance of the unknowns.
struct ScaleBelief {
  DriveState mean = DriveState::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();

  double metres_per_unit() const;
  double sigma() const;  ///< relative standard deviation of the scale
};

/// Before the first turn: the car's constants at their priors, the scale all but unknown about a start.
ScaleBelief PriorBelief(const CarPrior& car, double log_scale);

/// Variance that the log-scale gathers on the way: `length` odometry units at `metres_per_unit`, turning by `angle`
/// rad, with a gap of `gap_sigma` (0: none).
double DriftVariance(const DriftOptions& options, double length, double metres_per_unit, double angle,
                     double gap_sigma);

/// Of a measurement under the belief before it, linearised at `at`: innovation over its standard deviation, which is
/// that of both together, squared.
double NormalizedInnovation(const ScaleBelief& belief, const Measurement& measurement, double weight,
                            const DriveState& at);

/// Huber's weight of a deviation (in standard deviations): 1 up to `threshold`, then falling with its inverse.
double HuberWeight(double deviation, double threshold);

/// The belief with one more measurement, linearised at `at`; `weight` divides the measurement's variance.
ScaleBelief Updated(const ScaleBelief& belief, const Measurement& measurement, double weight, const DriveState& at);

/// A drive as the estimator sees it.
struct ScaleProblem {
  ScaleBelief prior;  ///< before the first segment
  std::vector<PathSegment> segments;
  std::vector<SegmentEvidence> evidence;  ///< one a segment
  EvidenceOptions options;
  DriftOptions drift;
};

/// What all segments together say of each.
struct SmoothedScale {
  std::vector<ScaleBelief> segments;
  /// Gains of the smoother: from segment i + 1 back to segment i. What two segments' beliefs have in common follows
  /// from them (LengthSigma).
  std::vector<Eigen::Matrix4d> gains;
  /// Sum of the turns' squared innovations, each over its variance: chi-squared with one degree of freedom a turn, but
  /// for the first, which gives the scale. It sees what priors and drift take up, too.
  double chi_squared = 0;
};

/// Kalman filter along the drive, linearised at given states (one a segment), and the Rauch-Tung-Striebel smoother.
/// With the linearisation moved to the answer and this repeated, it is Gauss-Newton on the maximum a posteriori
/// problem, in time linear in the number of segments (Bell 1994, The iterated Kalman smoother as a Gauss-Newton
/// method).
SmoothedScale SmoothScale(const ScaleProblem& problem, const std::vector<DriveState>& at);

/// Relative standard deviation of the path's length in metres, with all that the segments' scales have in common.
double LengthSigma(const SmoothedScale& smoothed, const std::vector<PathSegment>& segments);

}  // namespace turnscale

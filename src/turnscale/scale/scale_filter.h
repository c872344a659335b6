// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include "turnscale/scale/path_segment.h"
#include "turnscale/scale/scale_evidence.h"

namespace turnscale {

/// Assumed scale drift of the odometry: a random walk of the log-scale.
struct DriftOptions {
  double per_100m = 0.01;    ///< standard deviation over 100 m
  double per_90deg = 0.005;  ///< and over 90 degrees of turning: residual lens errors bias the scale in turns
  /// Factor on the standard deviation of the unit that the errors of the landmarks cause (UnitVariance), which replaces
  /// the two above where it is larger: UnitVariance assumes independent pixel errors, and all pixels of a landmark are
  /// aligned with the same patch. 0: it is not used.
  double unit_inflation = 4;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Mean and covariance of the unknowns.
struct ScaleBelief {
  DriveState mean = DriveState::Zero();
  DriveCovariance covariance = DriveCovariance::Zero();

  double metres_per_unit() const;
  double sigma() const;  ///< relative standard deviation of the scale
  double Sigma(DriveUnknown unknown) const;
};

/// Before the first turn: the car's constants at their priors (nearly flat where they are not known), a nearly flat
/// prior of the scale.
ScaleBelief PriorBelief(const CarPrior& car, double log_scale);

/// A part of the path along which the scale drifts.
struct PathStretch {
  double length = 0;         ///< odometry units
  double turned = 0;         ///< sum of the absolute angles, rad
  double unit_variance = 0;  ///< of the unit's logarithm, due to the errors of the landmarks; 0 where it is not known
  double gap_sigma = 0;      ///< relative, by which the unit may have changed across a gap; 0 without one
};

/// Variance of the drift of the log-scale along a stretch. That of the landmarks replaces the usual drift, not the gap,
/// where it is larger.
double DriftVariance(const DriftOptions& options, const PathStretch& stretch, double metres_per_unit);

/// The belief behind a stretch: the scale has drifted, and the road's error is another.
ScaleBelief Advanced(const ScaleBelief& belief, const PathStretch& stretch, double metres_per_unit,
                     const DriftOptions& drift, const RoadEvidenceOptions& road);

/// Square of a measurement's innovation, linearised at `at`, over its variance, which includes that of the belief
/// before it: chi-squared with one degree of freedom.
double ChiSquared(const ScaleBelief& belief, const Measurement& measurement, double weight, const DriveState& at);

/// The belief with one more measurement, linearised at `at`; `weight` divides the measurement's variance.
ScaleBelief Updated(const ScaleBelief& belief, const Measurement& measurement, double weight, const DriveState& at);

/// Robust weights (Huber) of a segment's measurements, by MeasurementKind: below 1 where one disagrees with the drive.
using SegmentWeights = std::array<double, kMeasurementKinds>;
constexpr SegmentWeights kFullWeights = {1, 1, 1, 1};
static_assert(kMeasurementKinds == 4);

/// Input of the estimator.
struct ScaleProblem {
  ScaleBelief prior;  ///< before the first segment
  std::vector<PathSegment> segments;
  std::vector<SegmentEvidence> evidence;  ///< one per segment
  std::vector<SegmentWeights> weights;    ///< one per segment
  EvidenceOptions options;
  DriftOptions drift;
};

/// The estimate at each segment, from all segments.
struct SmoothedScale {
  std::vector<ScaleBelief> segments;
  /// Gains of the smoother, from segment i + 1 back to segment i. They give the covariance between segments
  /// (LengthSigma).
  std::vector<DriveCovariance> gains;
  /// Sum of the squared innovations of the turns that test the scale, each over its variance: chi-squared with one
  /// degree of freedom per turn. It includes deviations absorbed by priors and drift. The first turn sets the scale,
  /// and so does a turn after a gap that takes most of the variance of the log-scale; they are not in the sum.
  double chi_squared = 0;
  int degrees_of_freedom = 0;
};

/// Kalman filter along the drive, linearised at given states (one per segment), and the Rauch-Tung-Striebel smoother.
/// With the linearisation moved to the answer and this repeated, it is Gauss-Newton on the maximum a posteriori
/// problem, in time linear in the number of segments (Bell 1994, The iterated Kalman smoother as a Gauss-Newton
/// method).
SmoothedScale SmoothScale(const ScaleProblem& problem, const std::vector<DriveState>& at);

/// Relative standard deviation of the path length in metres, with the covariances between the segments' scales.
double LengthSigma(const SmoothedScale& smoothed, const std::vector<PathSegment>& segments);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/scale/scale_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

#include "turnscale/base/error.h"
#include "turnscale/scale/camera_height.h"

namespace turnscale {
namespace {

constexpr double kPriorLogScaleSigma = 2;  // of the prior about the start: a factor of seven either way
constexpr double kLeastSigma = 1e-9;       // a covariance has to stay regular
constexpr double kDistance = 100;          // metres
constexpr double kAngle = std::numbers::pi / 2;

// Of constants that are not known: typical means, and sigmas that make the prior nearly flat.
constexpr double kUsualLeverArm = 1;  // metres
constexpr double kUnknownLogSigma = 1;

// Share of the road's error that is left after a way.
double Persistence(double metres, const RoadEvidenceOptions& road) {
  return std::exp(-metres / road.correlation_length);
}

// From the middle of one segment to the middle of the next.
ScaleBelief AdvancedTo(const ScaleProblem& problem, std::size_t i, double metres_per_unit, const ScaleBelief& belief) {
  const PathSegment& before = problem.segments[i - 1];
  const PathSegment& after = problem.segments[i];
  const PathStretch between{.length = after.middle - before.middle,
                            .turned = 0.5 * (before.turned + after.turned),
                            .unit_variance = 0.5 * (before.unit_variance + after.unit_variance),
                            .gap_sigma = after.gap_sigma};
  return Advanced(belief, between, metres_per_unit, problem.drift, problem.options.road);
}

// Sums the innovations of the turns, other than those that set the scale (SmoothedScale::chi_squared).
class TurnSum {
 public:
  void PassGap() { after_gap_ = true; }

  void Add(const ScaleBelief& before, const ScaleBelief& after, double chi_squared) {
    // The variance that comes from the constants of the car is left by every turn.
    constexpr double kMostLeft = 0.5;
    const double left = after.covariance(kLogScale, kLogScale) / before.covariance(kLogScale, kLogScale);
    if (first_ || (after_gap_ && left < kMostLeft)) {
      first_ = after_gap_ = false;
      return;
    }
    chi_squared_ += chi_squared;
    ++count_;
  }

  double chi_squared() const { return chi_squared_; }
  int count() const { return count_; }

 private:
  bool first_ = true;
  bool after_gap_ = false;  // and no turn has set the scale since
  double chi_squared_ = 0;
  int count_ = 0;
};

}  // namespace

void DriftOptions::Check() const {
  if (!(per_100m >= 0 && per_100m < 1)) throw InputError("per_100m: has to be from 0 to below 1");
  if (!(per_90deg >= 0 && per_90deg < 1)) throw InputError("per_90deg: has to be from 0 to below 1");
  if (!(unit_inflation >= 0 && std::isfinite(unit_inflation)))
    throw InputError("unit_inflation: has to be a number that is not negative");
}

double ScaleBelief::metres_per_unit() const { return std::exp(mean[kLogScale]); }

double ScaleBelief::sigma() const { return Sigma(kLogScale); }

double ScaleBelief::Sigma(DriveUnknown unknown) const { return std::sqrt(covariance(unknown, unknown)); }

ScaleBelief PriorBelief(const CarPrior& car, double log_scale) {
  const auto relative = [](double sigma, double value) { return std::max(sigma / value, kLeastSigma); };
  const bool arm = car.knows_lever_arm();
  const bool height = car.knows_height();
  ScaleBelief prior;
  prior.mean << log_scale, 0, car.side_slip, car.image_lag, std::log(arm ? car.lever_arm : kUsualLeverArm),
      car.roll_height, std::log(height ? car.camera_height : kUsualHeight), 0;
  DriveState sigmas;
  sigmas << kPriorLogScaleSigma, car.yaw_sigma, std::max(car.side_slip_sigma, kLeastSigma),
      std::max(car.image_lag_sigma, kLeastSigma), arm ? relative(car.lever_arm_sigma, car.lever_arm) : kUnknownLogSigma,
      std::max(car.roll_height_sigma, kLeastSigma),
      height ? relative(car.camera_height_sigma, car.camera_height) : kUnknownLogSigma, 1;
  prior.covariance.diagonal() = sigmas.cwiseAbs2();
  const auto correlate = [&](DriveUnknown a, DriveUnknown b, double correlation) {
    prior.covariance(a, b) = prior.covariance(b, a) = correlation * sigmas[a] * sigmas[b];
  };
  if (arm && height) correlate(kLogLeverArm, kLogHeight, car.height_correlation);
  if (height) correlate(kSlip, kLogHeight, car.height_slip_correlation);
  if (arm) correlate(kLogLeverArm, kSlip, car.lever_arm_slip_correlation);
  return prior;
}

double DriftVariance(const DriftOptions& options, const PathStretch& stretch, double metres_per_unit) {
  const double usual = options.per_100m * options.per_100m * stretch.length * metres_per_unit / kDistance +
                       options.per_90deg * options.per_90deg * stretch.turned / kAngle;
  return std::max(usual, stretch.unit_variance) + stretch.gap_sigma * stretch.gap_sigma;
}

ScaleBelief Advanced(const ScaleBelief& belief, const PathStretch& stretch, double metres_per_unit,
                     const DriftOptions& drift, const RoadEvidenceOptions& road) {
  ScaleBelief advanced = belief;
  const double persistence = Persistence(stretch.length * metres_per_unit, road);
  advanced.mean[kRoadError] *= persistence;
  advanced.covariance.row(kRoadError) *= persistence;
  advanced.covariance.col(kRoadError) *= persistence;
  advanced.covariance(kRoadError, kRoadError) += 1 - persistence * persistence;
  advanced.covariance(kLogScale, kLogScale) += DriftVariance(drift, stretch, metres_per_unit);
  return advanced;
}

double ChiSquared(const ScaleBelief& belief, const Measurement& measurement, double weight, const DriveState& at) {
  const double innovation = measurement.innovation - measurement.by_state.dot(belief.mean - at);
  const double variance =
      measurement.by_state.dot(belief.covariance * measurement.by_state.transpose()) + measurement.variance / weight;
  return innovation * innovation / variance;
}

ScaleBelief Updated(const ScaleBelief& belief, const Measurement& measurement, double weight, const DriveState& at) {
  const DriveRow& by_state = measurement.by_state;
  const DriveState gain_direction = belief.covariance * by_state.transpose();
  const DriveState gain = gain_direction / (by_state.dot(gain_direction) + measurement.variance / weight);
  ScaleBelief updated;
  updated.mean = belief.mean + gain * (measurement.innovation - by_state.dot(belief.mean - at));
  updated.covariance = belief.covariance - gain * gain_direction.transpose();
  updated.covariance = 0.5 * (updated.covariance + updated.covariance.transpose()).eval();
  return updated;
}

SmoothedScale SmoothScale(const ScaleProblem& problem, const std::vector<DriveState>& at) {
  const std::size_t count = problem.segments.size();
  std::vector<ScaleBelief> predicted(count);
  SmoothedScale result;
  ScaleBelief belief = problem.prior;
  TurnSum turns;
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) belief = AdvancedTo(problem, i, std::exp(at[i][kLogScale]), belief);
    if (problem.segments[i].gap_sigma > 0) turns.PassGap();
    predicted[i] = belief;
    for (const auto& [kind, measurement] : MeasurementsOf(problem.evidence[i], at[i], problem.options)) {
      const double weight = problem.weights[i][kind];
      const ScaleBelief updated = Updated(belief, measurement, weight, at[i]);
      if (kind == kLeverArmOfTurn) turns.Add(belief, updated, ChiSquared(belief, measurement, weight, at[i]));
      belief = updated;
    }
    result.segments.push_back(belief);
  }
  result.chi_squared = turns.chi_squared();
  result.degrees_of_freedom = turns.count();
  result.gains.assign(count, DriveCovariance::Zero());
  for (std::size_t i = count; i-- > 1;) {
    const ScaleBelief& next = result.segments[i];
    ScaleBelief& here = result.segments[i - 1];
    // filtered * transition^T * predicted^-1, both covariances symmetric; the transition is diagonal.
    DriveCovariance carried = here.covariance;
    carried.row(kRoadError) *=
        Persistence((problem.segments[i].middle - problem.segments[i - 1].middle) * std::exp(at[i][kLogScale]),
                    problem.options.road);
    const DriveCovariance gain = predicted[i].covariance.partialPivLu().solve(carried).transpose();
    here.mean += gain * (next.mean - predicted[i].mean);
    here.covariance += gain * (next.covariance - predicted[i].covariance) * gain.transpose();
    result.gains[i - 1] = gain;
  }
  return result;
}

double LengthSigma(const SmoothedScale& smoothed, const std::vector<PathSegment>& segments) {
  double total = 0;
  for (std::size_t i = 0; i < segments.size(); ++i)
    total += smoothed.segments[i].metres_per_unit() * segments[i].length;
  if (!(total > 0)) return std::numeric_limits<double>::infinity();
  // From the end: variance of the sum of what follows, and its covariance with the segment at hand.
  double variance = 0;
  DriveState with_rest = DriveState::Zero();
  for (std::size_t i = segments.size(); i-- > 0;) {
    const ScaleBelief& belief = smoothed.segments[i];
    const double share = belief.metres_per_unit() * segments[i].length / total;
    const DriveState carried = smoothed.gains[i] * with_rest;
    variance += share * share * belief.covariance(kLogScale, kLogScale) + 2 * share * carried[kLogScale];
    with_rest = share * belief.covariance.col(kLogScale) + carried;
  }
  return std::sqrt(variance);
}

}  // namespace turnscale

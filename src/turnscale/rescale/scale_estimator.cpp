// SPDX-License-Identifier: MIT
#include "turnscale/rescale/scale_estimator.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <Eigen/QR>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

constexpr int kStartIterations = 6;
constexpr int kIterations = 9;
constexpr double kNoLimit = 1e9;
constexpr double kLogScaleSigma = 2;      // of the prior about the start: a factor of seven either way
constexpr double kMaxLogScaleStep = 0.5;  // of a Gauss-Newton step
constexpr double kLeastSigma = 1e-9;      // a covariance has to stay regular

// The noise is fitted when the linearisation has settled, and again when its weights have.
bool FitsNoise(int iteration) { return iteration == 2 || iteration == 4 || iteration == 6; }

std::span<const SwayStep> StepsOf(const std::vector<SwayStep>& steps, const Stretch& stretch) {
  return std::span(steps).subspan(stretch.first, stretch.last - stretch.first + 1);
}

void AppendResiduals(std::span<const SwayStep> steps, const Eigen::Vector4d& coefficients,
                     std::vector<double>& residuals) {
  for (const SwayStep& step : steps) {
    if (step.usable) residuals.push_back(step.sway - SwayRegressors(step).dot(coefficients));
  }
}

struct StartFit {
  Eigen::Vector4d coefficients = Eigen::Vector4d::Zero();
  double sigma = 1;
};

// One robust line through all steps, no car assumed.
StartFit FitAllSteps(const std::vector<SwayStep>& steps, double huber, double least_sigma) {
  StartFit fit;
  for (int i = 0; i < kStartIterations; ++i) {
    const PooledSway pooled = PoolSway(steps, fit.coefficients, fit.sigma, i == 0 ? kNoLimit : huber);
    fit.coefficients = pooled.information.completeOrthogonalDecomposition().solve(pooled.target);
    std::vector<double> residuals;
    AppendResiduals(steps, fit.coefficients, residuals);
    fit.sigma = std::max(RobustSigma(std::move(residuals)), least_sigma);
  }
  return fit;
}

// Of the scales that the turns show one by one; large turns have more to say, fast ones nothing.
std::optional<double> MedianLogScale(const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
                                     DriveState state, double lever_arm, const StartFit& fit, double min_lever_share) {
  std::vector<std::pair<double, double>> scales;
  for (const Stretch& stretch : stretches) {
    if (!stretch.turning) continue;
    const PooledSway pooled = PoolSway(StepsOf(steps, stretch), fit.coefficients, fit.sigma, kNoLimit);
    const auto scale = ScaleOfStretch(pooled, state, lever_arm);
    if (!scale) continue;
    state[kLogScale] = std::log(*scale);
    if (LeverShare(pooled, state, lever_arm) < min_lever_share) continue;
    scales.emplace_back(state[kLogScale], std::abs(stretch.angle));
  }
  if (scales.empty()) return std::nullopt;
  return WeightedMedian(std::move(scales));
}

std::vector<StretchObservation> EmptyObservations(const std::vector<Stretch>& stretches) {
  std::vector<StretchObservation> observations;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    StretchObservation observation;
    observation.turning = stretches[i].turning;
    if (i > 0) {
      observation.distance = stretches[i].middle - stretches[i - 1].middle;
      observation.angle = 0.5 * (std::abs(stretches[i].angle) + std::abs(stretches[i - 1].angle));
    }
    observations.push_back(observation);
  }
  return observations;
}

class Estimator {
 public:
  Estimator(const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
            const ScaleEstimatorOptions& options, double least_sigma)
      : steps_(steps),
        stretches_(stretches),
        options_(options),
        least_sigma_(least_sigma),
        own_(stretches.size(), Eigen::Vector2d::Zero()) {
    estimate_.problem.observations = EmptyObservations(stretches);
    estimate_.noise = TypicalNoise(options.noise, options.drifting);
  }

  std::optional<ScaleEstimate> Run(const Belief& prior, double lever_arm, double sigma) && {
    estimate_.problem.prior = prior;
    estimate_.problem.lever_arm = lever_arm;
    estimate_.sway_sigma = sigma;
    at_.assign(stretches_.size(), prior.mean);
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      if (iteration > 0) MeasureSigma();
      Pool(iteration == 0 ? kNoLimit : options_.huber);
      if (!LeaveOutFastTurns()) return std::nullopt;
      if (FitsNoise(iteration)) estimate_.noise = FitNoise(estimate_.problem, at_, estimate_.noise, options_.noise);
      estimate_.smoothed = SmoothScale(estimate_.problem, estimate_.noise, at_).beliefs;
      FindOwnErrors(iteration > 0);
      Relinearise();
    }
    estimate_.causal = CausalScale(estimate_.problem, estimate_.noise).beliefs;
    return std::move(estimate_);
  }

 private:
  Eigen::Vector4d CoefficientsOf(std::size_t i) const {
    Eigen::Vector4d coefficients = SwayCoefficients(at_[i], estimate_.problem.lever_arm);
    coefficients[0] *= 1 + own_[i][0];
    coefficients[2] += own_[i][1];
    return coefficients;
  }

  void MeasureSigma() {
    std::vector<double> residuals;
    residuals.reserve(steps_.size());
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      AppendResiduals(StepsOf(steps_, stretches_[i]), CoefficientsOf(i), residuals);
    }
    estimate_.sway_sigma = std::max(RobustSigma(std::move(residuals)), least_sigma_);
  }

  void Pool(double huber) {
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      estimate_.problem.observations[i].pooled =
          PoolSway(StepsOf(steps_, stretches_[i]), CoefficientsOf(i), estimate_.sway_sigma, huber);
    }
  }

  // What is out stays out, lest the scale swing to and fro. False where no turn is left.
  bool LeaveOutFastTurns() {
    bool any = false;
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      StretchObservation& observation = estimate_.problem.observations[i];
      const double share = LeverShare(observation.pooled, at_[i], estimate_.problem.lever_arm);
      observation.turning = observation.turning && share >= options_.min_lever_share;
      any = any || observation.turning;
    }
    return any;
  }

  // Expectation of Student's weight (Lange, Little and Taylor 1989).
  double StudentWeight(double mean, double variance, double sigma) const {
    const double nu = options_.degrees_of_freedom;
    return (nu + 1) / (nu + (mean * mean + variance) / (sigma * sigma));
  }

  void FindOwnErrors(bool reweigh) {
    const StretchNoise& noise = estimate_.noise.stretch;
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      StretchObservation& observation = estimate_.problem.observations[i];
      const ScaleEvidence evidence = EvidenceAt(observation, at_[i], estimate_.problem.lever_arm, noise);
      const OwnErrors own = OwnErrorsOf(evidence, at_[i], estimate_.smoothed[i]);
      own_[i] = own.mean;
      if (!reweigh) continue;
      if (observation.turning) observation.lever_weight = StudentWeight(own.mean[0], own.variance[0], noise.lever);
      observation.direction_weight = StudentWeight(own.mean[1], own.variance[1], noise.direction);
    }
  }

  void Relinearise() {
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      const double before = at_[i][kLogScale];
      at_[i] = estimate_.smoothed[i].mean;
      at_[i][kLogScale] = std::clamp(at_[i][kLogScale], before - kMaxLogScaleStep, before + kMaxLogScaleStep);
    }
  }

  const std::vector<SwayStep>& steps_;
  const std::vector<Stretch>& stretches_;
  const ScaleEstimatorOptions& options_;
  double least_sigma_;
  std::vector<Eigen::Vector2d> own_;  // errors of each stretch: lever arm, direction
  std::vector<DriveState> at_;        // where each stretch is linearised
  ScaleEstimate estimate_;
};

// The least sideways noise that is believed in, however quiet the odometry: the model itself is no better. On motion
// without any noise (a simulator's truth) the differences of speed within a turn would else outweigh the prior of c.
double LeastSigma(const std::vector<SwayStep>& steps) {
  constexpr double kDirection = 0.0025;  // rad
  double sum = 0;
  for (const SwayStep& step : steps) sum += step.length;
  return kDirection * sum / static_cast<double>(steps.size());
}

}  // namespace

void CarPrior::Check() const {
  const auto require = [](bool good, const char* what) {
    if (!good) throw InputError(what);
  };
  require(std::isfinite(lever_arm) && lever_arm > 0, "car.lever_arm: has to be a positive number of metres");
  require(side_slip >= 0 && side_slip < 1, "car.side_slip: has to be from 0 to below 1 s^2/m");
  require(side_slip_sigma >= 0 && side_slip_sigma < 1, "car.side_slip_sigma: has to be from 0 to below 1 s^2/m");
  require(yaw_sigma > 0 && yaw_sigma < 1, "car.yaw_sigma: has to be above 0 and below 1 rad");
  require(std::isfinite(height), "car.height: has to be a number of metres");
  require(std::isfinite(height_sigma) && height_sigma > 0, "car.height_sigma: has to be a positive number of metres");
}

void ScaleEstimatorOptions::Check() const {
  noise.Check();
  if (!(huber > 0)) throw InputError("estimator.huber: has to be positive");
  if (!(min_lever_share >= 0 && min_lever_share < 1)) {
    throw InputError("estimator.min_lever_share: has to be from 0 to below 1");
  }
  if (!(degrees_of_freedom > 0)) throw InputError("estimator.degrees_of_freedom: has to be positive");
}

std::optional<ScaleEstimate> EstimateScale(const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
                                           const CarPrior& car, const ScaleEstimatorOptions& options) {
  car.Check();
  options.Check();
  if (steps.empty()) return std::nullopt;
  const double least_sigma = LeastSigma(steps);
  const StartFit fit = FitAllSteps(steps, options.huber, least_sigma);
  Belief prior;
  prior.mean << 0, fit.coefficients[2], car.side_slip, 0;
  const auto log_scale = MedianLogScale(steps, stretches, prior.mean, car.lever_arm, fit, options.min_lever_share);
  if (!log_scale) return std::nullopt;
  prior.mean << *log_scale, 0, car.side_slip, car.height;
  const Eigen::Vector4d sigmas(kLogScaleSigma, car.yaw_sigma, std::max(car.side_slip_sigma, kLeastSigma),
                               car.height_sigma);
  prior.covariance.diagonal() = sigmas.cwiseAbs2();
  const auto run = [&] {
    return Estimator(steps, stretches, options, least_sigma).Run(prior, car.lever_arm, fit.sigma);
  };
  auto estimate = run();
  // Tyres do not slip inwards: on the edge of what can be, the answer is the one without slip.
  if (estimate && estimate->smoothed.back().mean[kSlip] < 0) {
    prior.mean[kSlip] = 0;
    prior.covariance(kSlip, kSlip) = kLeastSigma * kLeastSigma;
    estimate = run();
  }
  return estimate;
}

}  // namespace turnscale

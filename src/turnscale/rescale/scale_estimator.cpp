// SPDX-License-Identifier: MIT
#include "turnscale/rescale/scale_estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/rescale/scale_start.h"

namespace turnscale {
namespace {

constexpr int kMostIterations = 40;
constexpr double kConverged = 0.01;  // change of the log-scale in an iteration, in its sigmas
constexpr double kNoLimit = std::numeric_limits<double>::max();
constexpr double kLogScaleSigma = 2;      // of the prior about the start: a factor of seven either way
constexpr double kMaxLogScaleStep = 0.5;  // of a Gauss-Newton step
constexpr double kLeastSigma = 1e-9;      // a covariance has to stay regular

// The noise is fitted when the linearisation has settled, and again when its weights have.
constexpr int kLastNoiseFit = 6;
bool FitsNoise(int iteration) { return iteration == 2 || iteration == 4 || iteration == kLastNoiseFit; }

std::vector<StretchObservation> EmptyObservations(const std::vector<Stretch>& stretches, double gap_sigma) {
  std::vector<StretchObservation> observations;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    StretchObservation observation;
    observation.turning = stretches[i].turning;
    if (i > 0) {
      observation.distance = stretches[i].middle - stretches[i - 1].middle;
      observation.angle = 0.5 * (std::abs(stretches[i].angle) + std::abs(stretches[i - 1].angle));
      if (stretches[i].after_gap) observation.gap_sigma = gap_sigma;
    }
    observations.push_back(observation);
  }
  return observations;
}

class Estimator {
 public:
  Estimator(const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
            const ScaleEstimatorOptions& options)
      : steps_(steps),
        stretches_(stretches),
        options_(options),
        least_sigma_(LeastSwaySigma(steps)),
        effects_(stretches.size(), Eigen::Vector2d::Zero()) {
    estimate_.problem.observations = EmptyObservations(stretches, options.gap_sigma);
    estimate_.noise = TypicalNoise(options.noise, options.drifting);
  }

  std::optional<ScaleEstimate> Run(const Belief& prior, double lever_arm, double sigma) && {
    estimate_.problem.prior = prior;
    estimate_.problem.lever_arm = lever_arm;
    estimate_.sway_sigma = sigma;
    at_.assign(stretches_.size(), prior.mean);
    for (int iteration = 0; iteration < kMostIterations && !estimate_.converged; ++iteration) {
      if (iteration > 0) MeasureSigma();
      Pool(iteration == 0 ? kNoLimit : options_.huber);
      if (!LeaveOutFastTurns(iteration <= kLastNoiseFit)) return std::nullopt;
      if (FitsNoise(iteration)) estimate_.noise = FitNoise(estimate_.problem, at_, estimate_.noise, options_.noise);
      estimate_.smoothed = SmoothScale(estimate_.problem, estimate_.noise, at_).beliefs;
      FindRandomEffects(iteration > 0);
      estimate_.converged = Relinearise() < kConverged && iteration > kLastNoiseFit;
    }
    estimate_.filtered = FilterScale(estimate_.problem, estimate_.noise).beliefs;
    return std::move(estimate_);
  }

 private:
  Eigen::Vector4d CoefficientsOf(std::size_t i) const {
    Eigen::Vector4d coefficients = SwayCoefficients(at_[i], estimate_.problem.lever_arm);
    coefficients[0] *= 1 + effects_[i][0];
    coefficients[2] += effects_[i][1];
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

  // While the side slip is being found, a turn may come back; then what is out stays out, lest the scale swing to and
  // fro. False where no turn is left.
  bool LeaveOutFastTurns(bool may_come_back) {
    bool any = false;
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      StretchObservation& observation = estimate_.problem.observations[i];
      const bool was_in = may_come_back ? stretches_[i].turning : observation.turning;
      observation.turning = was_in && LeverArmRatio(observation.pooled, at_[i], estimate_.problem.lever_arm) >=
                                          options_.min_lever_arm_ratio;
      any = any || observation.turning;
    }
    return any;
  }

  // Expectation of Student's weight (Lange, Little and Taylor 1989).
  double StudentWeight(double mean, double variance, double sigma) const {
    const double nu = options_.degrees_of_freedom;
    return (nu + 1) / (nu + (mean * mean + variance) / (sigma * sigma));
  }

  void FindRandomEffects(bool reweigh) {
    const StretchNoise& noise = estimate_.noise.stretch;
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      StretchObservation& observation = estimate_.problem.observations[i];
      const ScaleEvidence evidence = EvidenceAt(observation, at_[i], estimate_.problem.lever_arm, noise);
      const RandomEffects effects = RandomEffectsOf(evidence, at_[i], estimate_.smoothed[i]);
      effects_[i] = effects.mean;
      if (!reweigh) continue;
      if (observation.turning)
        observation.lever_weight = StudentWeight(effects.mean[0], effects.variance[0], noise.lever);
      observation.direction_weight = StudentWeight(effects.mean[1], effects.variance[1], noise.direction);
    }
  }

  // The largest change of a log-scale, in its sigmas.
  double Relinearise() {
    double change = 0;
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      const double before = at_[i][kLogScale];
      at_[i] = estimate_.smoothed[i].mean;
      at_[i][kLogScale] = std::clamp(at_[i][kLogScale], before - kMaxLogScaleStep, before + kMaxLogScaleStep);
      const double sigma = std::sqrt(estimate_.smoothed[i].covariance(kLogScale, kLogScale));
      change = std::max(change, std::abs(at_[i][kLogScale] - before) / sigma);
    }
    return change;
  }

  const std::vector<SwayStep>& steps_;
  const std::vector<Stretch>& stretches_;
  const ScaleEstimatorOptions& options_;
  double least_sigma_;
  std::vector<Eigen::Vector2d> effects_;  // random ones of each stretch: lever arm, direction
  std::vector<DriveState> at_;            // where each stretch is linearised
  ScaleEstimate estimate_;
};

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
  if (!(min_lever_arm_ratio >= 0 && min_lever_arm_ratio < 1)) {
    throw InputError("estimator.min_lever_arm_ratio: has to be from 0 to below 1");
  }
  if (!(gap_sigma > 0)) throw InputError("estimator.gap_sigma: has to be positive");
  if (!(degrees_of_freedom > 0)) throw InputError("estimator.degrees_of_freedom: has to be positive");
}

std::optional<ScaleEstimate> EstimateScale(const std::vector<SwayStep>& steps, const std::vector<Stretch>& stretches,
                                           const CarPrior& car, const ScaleEstimatorOptions& options) {
  car.Check();
  options.Check();
  if (steps.empty()) return std::nullopt;
  Belief prior;
  prior.mean << 0, 0, car.side_slip, car.height;
  const auto start =
      StartScale(steps, stretches, prior.mean, car.lever_arm, options.huber, options.min_lever_arm_ratio);
  if (!start) return std::nullopt;
  prior.mean[kLogScale] = start->log_scale;
  const Eigen::Vector4d sigmas(kLogScaleSigma, car.yaw_sigma, std::max(car.side_slip_sigma, kLeastSigma),
                               car.height_sigma);
  prior.covariance.diagonal() = sigmas.cwiseAbs2();
  const auto run = [&] { return Estimator(steps, stretches, options).Run(prior, car.lever_arm, start->sway_sigma); };
  auto estimate = run();
  // Tyres do not slip inwards: on the edge of what can be, the answer is the one without slip.
  if (estimate && car.side_slip_sigma > 0 && estimate->smoothed.back().mean[kSlip] < 0) {
    prior.mean[kSlip] = 0;
    prior.covariance(kSlip, kSlip) = kLeastSigma * kLeastSigma;
    estimate = run();
    if (estimate) estimate->side_slip_at_bound = true;
  }
  return estimate;
}

}  // namespace turnscale

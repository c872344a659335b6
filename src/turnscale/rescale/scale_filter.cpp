// SPDX-License-Identifier: MIT
#include "turnscale/rescale/scale_filter.h"

#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/LU>

namespace turnscale {
namespace {

constexpr double kDistance = 100;  // metres
constexpr double kAngle = std::numbers::pi / 2;
constexpr int kLocalIterations = 4;

Belief Predict(Belief belief, const StretchObservation& next, const ScaleNoise& noise, double scale) {
  belief.covariance(kLogScale, kLogScale) +=
      noise.per_distance * noise.per_distance * next.distance * scale / kDistance +
      noise.per_angle * noise.per_angle * next.angle / kAngle + next.gap_sigma * next.gap_sigma;
  return belief;
}

struct Update {
  Belief belief;
  double log_likelihood = 0;
};

// The evidence is a quadratic in the state: the posterior is exact. No inverse of what may be singular: a straight has
// nothing to say of the scale.
Update Combine(const Belief& predicted, const ScaleEvidence& evidence, const DriveState& taken_at) {
  const Eigen::Matrix4d growth = Eigen::Matrix4d::Identity() + predicted.covariance * evidence.information;
  const Eigen::PartialPivLU<Eigen::Matrix4d> solver(growth);
  const Eigen::Matrix4d covariance = solver.solve(predicted.covariance);
  Update update;
  update.belief.covariance = 0.5 * (covariance + covariance.transpose());
  const DriveState offset = predicted.mean - taken_at;
  const Eigen::Vector4d pull = evidence.gradient - evidence.information * offset;
  const Eigen::Vector4d step = update.belief.covariance * pull;
  update.belief.mean = predicted.mean + step;
  const double cost = evidence.cost - 2 * evidence.gradient.dot(offset) + offset.dot(evidence.information * offset) -
                      pull.dot(step) + std::log(solver.determinant());
  update.log_likelihood = -0.5 * cost;
  return update;
}

struct Trace {
  std::vector<Belief> predicted;
  std::vector<Belief> filtered;
};

double RunFilter(const ScaleProblem& problem, const ScaleNoise& noise, const std::vector<DriveState>& at,
                 Trace* trace) {
  double log_likelihood = 0;
  Belief belief = problem.prior;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const StretchObservation& observation = problem.observations[i];
    if (i > 0) belief = Predict(belief, observation, noise, std::exp(at[i][kLogScale]));
    if (trace) trace->predicted.push_back(belief);
    const Update update = Combine(belief, EvidenceAt(observation, at[i], problem.lever_arm, noise.stretch), at[i]);
    belief = update.belief;
    log_likelihood += update.log_likelihood;
    if (trace) trace->filtered.push_back(belief);
  }
  return log_likelihood;
}

}  // namespace

double ScaleLogLikelihood(const ScaleProblem& problem, const ScaleNoise& noise, const std::vector<DriveState>& at) {
  return RunFilter(problem, noise, at, nullptr);
}

ScaleHistory SmoothScale(const ScaleProblem& problem, const ScaleNoise& noise, const std::vector<DriveState>& at) {
  Trace trace;
  ScaleHistory history;
  history.log_likelihood = RunFilter(problem, noise, at, &trace);
  history.beliefs = trace.filtered;
  for (std::size_t i = history.beliefs.size(); i-- > 1;) {
    const Belief& next = history.beliefs[i];
    const Belief& predicted = trace.predicted[i];
    Belief& belief = history.beliefs[i - 1];
    // filtered * predicted^-1, both symmetric.
    const Eigen::Matrix4d gain = predicted.covariance.partialPivLu().solve(belief.covariance).transpose();
    belief.mean += gain * (next.mean - predicted.mean);
    belief.covariance += gain * (next.covariance - predicted.covariance) * gain.transpose();
  }
  return history;
}

ScaleHistory FilterScale(const ScaleProblem& problem, const ScaleNoise& noise) {
  ScaleHistory history;
  Belief belief = problem.prior;
  bool started = false;
  for (const StretchObservation& observation : problem.observations) {
    if (!started && observation.turning) {
      if (const auto scale = ScaleOfStretch(observation.pooled, belief.mean, problem.lever_arm)) {
        belief.mean[kLogScale] = std::log(*scale);
        started = true;
      }
    }
    if (started && !history.beliefs.empty()) {
      belief = Predict(belief, observation, noise, std::exp(belief.mean[kLogScale]));
    }
    Update update{belief};
    for (int i = 0; i < kLocalIterations; ++i) {
      const DriveState at = update.belief.mean;
      StretchObservation seen = observation;
      seen.turning = observation.turning && started;
      update = Combine(belief, EvidenceAt(seen, at, problem.lever_arm, noise.stretch), at);
    }
    belief = update.belief;
    history.log_likelihood += update.log_likelihood;
    history.beliefs.push_back(belief);
  }
  return history;
}

}  // namespace turnscale

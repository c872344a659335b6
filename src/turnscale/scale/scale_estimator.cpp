// SPDX-License-Identifier: MIT
#include "turnscale/scale/scale_estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

constexpr int kMostIterations = 40;
constexpr double kConverged = 1e-6;       // change of a log-scale in an iteration
constexpr double kLogScaleSigma = 2;      // of the prior about the start: a factor of seven either way
constexpr double kMaxLogScaleStep = 0.3;  // of a Gauss-Newton step
constexpr double kLeastSigma = 1e-9;      // a covariance has to stay regular

DriveState PriorState(const CarPrior& car, double log_scale) {
  return {log_scale, 0, car.side_slip, std::log(car.lever_arm)};
}

// Turns from which the measured lever arm cannot be seen are left out, with the reason. Returns where the estimator
// starts: the median of the scales that the others show one by one, large turns counting more.
std::optional<double> StartingLogScale(const CarPrior& car, const EvidenceOptions& options,
                                       std::vector<SegmentEvidence>& evidence) {
  std::vector<std::pair<double, double>> log_scales;
  const LeverArm lever_arm{car.lever_arm, car.side_slip};
  for (SegmentEvidence& segment : evidence) {
    if (!segment.turn) continue;
    const double scale = MetresPerUnit(*segment.turn, lever_arm);
    if (!std::isfinite(scale)) {
      segment.reason = "the camera does not move outwards as its lever arm requires";
    } else if (LeverArmRatio(*segment.turn, lever_arm, scale) < options.min_lever_arm_ratio) {
      segment.reason = "too fast: side slip leaves too little of the lever arm";
    } else {
      log_scales.emplace_back(std::log(scale), std::abs(segment.turn->angle));
      continue;
    }
    segment.turn.reset();
  }
  if (log_scales.empty()) return std::nullopt;
  return WeightedMedian(std::move(log_scales));
}

class Smoothing {
 public:
  Smoothing(ScaleProblem problem, double huber)
      : problem_(std::move(problem)), huber_(huber), at_(problem_.segments.size(), problem_.prior.mean) {}

  void Run() {
    for (int i = 0; i < kMostIterations && !converged_; ++i) {
      smoothed_ = SmoothScale(problem_, at_);
      converged_ = Relinearize() < kConverged;
      Reweigh();
    }
  }

  const ScaleProblem& problem() const { return problem_; }
  const SmoothedScale& smoothed() const { return smoothed_; }
  bool converged() const { return converged_; }

 private:
  double Relinearize() {
    double change = 0;
    for (std::size_t i = 0; i < at_.size(); ++i) {
      const double before = at_[i][kLogScale];
      at_[i] = smoothed_.segments[i].mean;
      at_[i][kLogScale] = std::clamp(at_[i][kLogScale], before - kMaxLogScaleStep, before + kMaxLogScaleStep);
      change = std::max(change, std::abs(at_[i][kLogScale] - before));
    }
    return change;
  }

  void Reweigh() {
    for (std::size_t i = 0; i < at_.size(); ++i) {
      const auto measurement = Linearize(problem_.evidence[i], at_[i], problem_.options);
      if (!measurement) continue;
      const double deviation = std::abs(measurement->innovation) / std::sqrt(measurement->variance);
      problem_.evidence[i].weight = std::min(1.0, huber_ / std::max(deviation, 1e-9));
    }
  }

  ScaleProblem problem_;
  double huber_;
  std::vector<DriveState> at_;  // where each segment is linearised
  SmoothedScale smoothed_;
  bool converged_ = false;
};

TurnEstimate DescribeTurn(const PathSegment& segment, const SegmentEvidence& evidence, const CarPrior& car,
                          const EvidenceOptions& options) {
  TurnEstimate turn;
  turn.first_step = segment.first;
  turn.last_step = segment.last;
  turn.angle = segment.angle;
  turn.used = evidence.turn.has_value();
  turn.reason = evidence.reason;
  if (!turn.used) return turn;
  turn.lever_arm_units = evidence.turn->lever_arm;
  turn.speed_units = std::sqrt(evidence.turn->mean_square_speed);
  turn.own = turn.as_given = OwnScale(evidence, PriorState(car, 0));
  const Measurement measurement = *Linearize(evidence, PriorState(car, std::log(turn.as_given)), options);
  turn.own_sigma = std::sqrt(measurement.variance) / std::abs(measurement.by_state[kLogScale]);
  return turn;
}

std::vector<TurnEstimate> DescribeTurns(const ScaleProblem& problem, const CarPrior& car) {
  std::vector<TurnEstimate> turns;
  for (std::size_t i = 0; i < problem.segments.size(); ++i)
    if (problem.segments[i].turning)
      turns.push_back(DescribeTurn(problem.segments[i], problem.evidence[i], car, problem.options));
  return turns;
}

CarRefinement DescribeCar(const ScaleBelief& belief, const CarPrior& car, bool slip_at_bound) {
  const auto sigma = [&](DriveUnknown unknown) { return std::sqrt(belief.covariance(unknown, unknown)); };
  return {-belief.mean[kDirection], sigma(kDirection), std::max(belief.mean[kSlip], 0.0),
          car.side_slip_sigma > 0 ? sigma(kSlip) : 0.0, slip_at_bound};
}

// Each turn's own scale, with the car's constants as the drive has them, and the test of all of them.
void CompareTurns(const Smoothing& smoothing, const CarPrior& car, const TurnTestOptions& options,
                  ScaleEstimate& estimate) {
  TurnTestInput input;
  const ScaleProblem& problem = smoothing.problem();
  std::size_t next = 0;
  for (std::size_t i = 0; i < problem.segments.size(); ++i) {
    if (!problem.segments[i].turning) continue;
    TurnEstimate& turn = estimate.turns[next++];
    const SegmentEvidence& evidence = problem.evidence[i];
    const ScaleBelief& belief = estimate.smoothed[i];
    turn.smoothed = belief.metres_per_unit();
    turn.smoothed_sigma = belief.sigma();
    if (!turn.used) continue;
    const Measurement measurement = *Linearize(evidence, belief.mean, problem.options);
    turn.own = OwnScale(evidence, belief.mean);
    turn.own_sigma = std::sqrt(measurement.variance) / std::abs(measurement.by_state[kLogScale]);
    turn.weight = evidence.weight;
    turn.deviation = measurement.innovation / std::sqrt(measurement.variance);
    input.deviations.push_back(turn.deviation);
    input.differences.push_back(std::log(turn.smoothed / turn.as_given));
    input.weights.push_back(std::abs(turn.angle));
  }
  if (car.side_slip_sigma > 0)
    input.slip_deviation = (estimate.smoothed.back().mean[kSlip] - car.side_slip) / car.side_slip_sigma;
  estimate.test = TestTurns(input, options);
}

// The scale goes through what each turn says with the car's constants as given; sigma covers how much they differ.
// Turns that know the scale much worse than others say nothing.
void FollowTurns(const ScaleProblem& problem, ScaleEstimate& estimate) {
  constexpr double kMostSigmaRatio = 3;
  struct Node {
    double place;
    double log_scale;
  };
  std::vector<Node> nodes;
  std::vector<std::pair<double, double>> log_scales;
  double best_sigma = std::numeric_limits<double>::infinity();
  for (const TurnEstimate& turn : estimate.turns)
    if (turn.used) best_sigma = std::min(best_sigma, turn.own_sigma);
  std::size_t next = 0;
  for (const PathSegment& segment : problem.segments) {
    if (!segment.turning) continue;
    const TurnEstimate& turn = estimate.turns[next++];
    if (!turn.used || !std::isfinite(turn.as_given) || turn.own_sigma > kMostSigmaRatio * best_sigma) continue;
    nodes.push_back({segment.middle, std::log(turn.as_given)});
    log_scales.emplace_back(std::log(turn.as_given), std::abs(segment.angle));
  }
  const double centre = WeightedMedian(log_scales);
  double squares = 0;
  double weights = 0;
  for (const auto& [log_scale, weight] : log_scales) {
    squares += weight * (log_scale - centre) * (log_scale - centre);
    weights += weight;
  }
  const double spread = std::hypot(std::sqrt(squares / weights), estimate.test.disagreement);
  for (std::size_t i = 0; i < problem.segments.size(); ++i) {
    const double place = problem.segments[i].middle;
    const auto after = std::ranges::find_if(nodes, [&](const Node& node) { return node.place >= place; });
    double log_scale = nodes.back().log_scale;
    if (after == nodes.begin()) {
      log_scale = after->log_scale;
    } else if (after != nodes.end()) {
      const Node& before = *(after - 1);
      const double share = (place - before.place) / (after->place - before.place);
      log_scale = (1 - share) * before.log_scale + share * after->log_scale;
    }
    estimate.smoothed[i].mean[kLogScale] = log_scale;
    estimate.smoothed[i].covariance(kLogScale, kLogScale) += spread * spread;
  }
  estimate.length_sigma = std::hypot(estimate.length_sigma, spread);
  estimate.fell_back = true;
}

std::string WhatWouldDo(const ScaleEstimatorOptions& options) {
  const long degrees = std::lround(options.segments.turns.min_region_angle * 180 / M_PI);
  return "give a drive with a slow turn of " + std::to_string(degrees) + " degrees or more";
}

}  // namespace

void ScaleEstimatorOptions::Check() const {
  segments.Check();
  evidence.Check();
  drift.Check();
  test.Check();
  if (!(huber > 0)) throw InputError("scale.huber: has to be positive");
  if (!(max_sigma > 0)) throw InputError("scale.max_sigma: has to be positive");
}

ScaleBelief PriorBelief(const CarPrior& car, double log_scale) {
  ScaleBelief prior;
  prior.mean = PriorState(car, log_scale);
  const Eigen::Vector4d sigmas(kLogScaleSigma, car.yaw_sigma, std::max(car.side_slip_sigma, kLeastSigma),
                               std::max(car.lever_arm_sigma / car.lever_arm, kLeastSigma));
  prior.covariance.diagonal() = sigmas.cwiseAbs2();
  return prior;
}

ScaleEstimateResult EstimateScale(const std::vector<VehicleStep>& steps, const CarPrior& car,
                                  const ScaleEstimatorOptions& options) {
  car.Check();
  options.Check();
  ScaleProblem problem;
  problem.segments = SplitIntoSegments(steps, options.segments);
  problem.options = options.evidence;
  problem.drift = options.drift;
  problem.evidence = GatherEvidence(steps, problem.segments, options.evidence);
  ScaleEstimateResult result;
  const std::optional<double> start = StartingLogScale(car, options.evidence, problem.evidence);
  result.turns = DescribeTurns(problem, car);
  if (result.turns.empty()) {
    result.reason = "it has no turn; " + WhatWouldDo(options);
    return result;
  }
  if (!start) {
    result.reason = "no sufficiently slow turn shows the expected lateral motion; " + WhatWouldDo(options);
    return result;
  }
  problem.prior = PriorBelief(car, *start);
  Smoothing smoothing(problem, options.huber);
  smoothing.Run();
  // Tyres do not slip inwards: on the edge of what can be, the answer is the one without slip.
  const bool at_bound = car.side_slip_sigma > 0 && smoothing.smoothed().segments.back().mean[kSlip] < 0;
  if (at_bound) {
    problem.prior.mean[kSlip] = 0;
    problem.prior.covariance(kSlip, kSlip) = kLeastSigma * kLeastSigma;
    smoothing = Smoothing(problem, options.huber);
    smoothing.Run();
  }

  ScaleEstimate estimate;
  estimate.segments = problem.segments;
  estimate.smoothed = smoothing.smoothed().segments;
  estimate.length_sigma = LengthSigma(smoothing.smoothed(), problem.segments);
  estimate.converged = smoothing.converged();
  const auto best = std::ranges::min_element(estimate.smoothed, {}, [](const ScaleBelief& b) { return b.sigma(); });
  if (!(best->sigma() <= options.max_sigma)) {
    result.reason = "its turns leave the scale uncertain by " + std::to_string(std::lround(100 * best->sigma())) +
                    " %, more than " + std::to_string(std::lround(100 * options.max_sigma)) + "; " +
                    WhatWouldDo(options);
    return result;
  }
  estimate.car = DescribeCar(estimate.smoothed.back(), car, at_bound);
  estimate.turns = result.turns;
  CompareTurns(smoothing, car, options.test, estimate);
  const double inflation = estimate.test.inflation;
  for (ScaleBelief& belief : estimate.smoothed) belief.covariance(kLogScale, kLogScale) *= inflation * inflation;
  estimate.length_sigma *= inflation;
  if (estimate.test.contradicted || !estimate.converged) FollowTurns(problem, estimate);
  result.estimate = std::move(estimate);
  return result;
}

}  // namespace turnscale

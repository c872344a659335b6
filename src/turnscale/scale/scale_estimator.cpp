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
constexpr int kMostSelections = 3;
constexpr double kConverged = 1e-6;       // change of a log-scale in an iteration
constexpr double kMaxLogScaleStep = 0.3;  // of a Gauss-Newton step

DriveState PriorState(const CarPrior& car, double log_scale) {
  return {log_scale, 0, car.side_slip, std::log(car.lever_arm)};
}

// Turns from which the measured lever arm cannot be seen are left out, with the reason.
struct Selection {
  std::vector<SegmentEvidence> evidence;
  std::vector<std::pair<double, double>> log_scales;  // of the turns that are left, one by one, and their angles
};

Selection SelectTurns(const std::vector<SegmentEvidence>& gathered, const DriveState& state,
                      const EvidenceOptions& options) {
  Selection selection{gathered, {}};
  for (SegmentEvidence& segment : selection.evidence) {
    if (!segment.turn) continue;
    segment.reason = WhyUnusable(*segment.turn, state, options);
    if (segment.reason.empty())
      selection.log_scales.emplace_back(std::log(OwnScale(segment, state)), std::abs(segment.turn->angle));
    else
      segment.turn.reset();
  }
  return selection;
}

bool SameTurns(const std::vector<SegmentEvidence>& a, const std::vector<SegmentEvidence>& b) {
  return std::ranges::equal(
      a, b, {}, [](const SegmentEvidence& segment) { return segment.turn.has_value(); },
      [](const SegmentEvidence& segment) { return segment.turn.has_value(); });
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

struct Answer {
  Smoothing smoothing;
  SmoothedScale smoothed;
  double side_slip = 0;  // that the drive asks for, s^2/m, be it negative
};

Answer SmoothWith(ScaleProblem problem, const CarPrior& car, double huber) {
  Smoothing smoothing(problem, huber);
  smoothing.Run();
  Answer answer{smoothing, smoothing.smoothed(), smoothing.smoothed().segments.back().mean[kSlip]};
  if (car.side_slip_sigma == 0 || answer.side_slip >= 0) return answer;
  // Tyres do not slip inwards: on the edge of what can be, the answer is the one without slip. How well it is known
  // does not change by that.
  constexpr double kHeld = 1e-9;
  problem.prior.mean[kSlip] = 0;
  problem.prior.covariance(kSlip, kSlip) = kHeld * kHeld;
  answer.smoothing = Smoothing(std::move(problem), huber);
  answer.smoothing.Run();
  for (std::size_t i = 0; i < answer.smoothed.segments.size(); ++i)
    answer.smoothed.segments[i].mean = answer.smoothing.smoothed().segments[i].mean;
  answer.smoothed.chi_squared = answer.smoothing.smoothed().chi_squared;
  return answer;
}

// Which turns are too fast, or swing inwards, depends on the direction of travel and the slip, which the drive knows
// better than the prior: turns are selected again with its answer.
Answer SmoothDrive(ScaleProblem problem, const std::vector<SegmentEvidence>& gathered, const CarPrior& car,
                   const ScaleEstimatorOptions& options, Selection selection) {
  problem.evidence = selection.evidence;
  problem.prior = PriorBelief(car, WeightedMedian(selection.log_scales));
  Answer answer = SmoothWith(problem, car, options.huber);
  for (int i = 0; i < kMostSelections; ++i) {
    const DriveState& state = answer.smoothed.segments.back().mean;
    selection = SelectTurns(gathered, state, options.evidence);
    if (selection.log_scales.empty() || SameTurns(selection.evidence, problem.evidence)) break;
    problem.evidence = selection.evidence;
    problem.prior = PriorBelief(car, WeightedMedian(selection.log_scales));
    answer = SmoothWith(problem, car, options.huber);
  }
  return answer;
}

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
  if (!std::isfinite(turn.as_given)) return turn;
  const Measurement measurement = *Linearize(evidence, PriorState(car, std::log(turn.as_given)), options);
  turn.own_sigma = turn.as_given_sigma = std::sqrt(measurement.variance) / std::abs(measurement.by_state[kLogScale]);
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
void CompareTurns(const Answer& answer, const CarPrior& car, const TurnTestOptions& options, ScaleEstimate& estimate) {
  TurnTestInput input;
  input.chi_squared = answer.smoothed.chi_squared;
  std::vector<int> tested;
  const ScaleProblem& problem = answer.smoothing.problem();
  std::size_t next = 0;
  for (std::size_t i = 0; i < problem.segments.size(); ++i) {
    if (!problem.segments[i].turning) continue;
    TurnEstimate& turn = estimate.turns[next++];
    const SegmentEvidence& evidence = problem.evidence[i];
    const ScaleBelief& belief = estimate.smoothed[i];
    if (!turn.used || !std::isfinite(turn.as_given)) continue;
    tested.push_back(static_cast<int>(next) - 1);
    const Measurement measurement = *Linearize(evidence, belief.mean, problem.options);
    turn.own = OwnScale(evidence, belief.mean);
    turn.own_sigma = std::sqrt(measurement.variance) / std::abs(measurement.by_state[kLogScale]);
    turn.weight = evidence.weight;
    turn.deviation = measurement.innovation / std::sqrt(measurement.variance);
    input.deviations.push_back(turn.deviation);
    input.differences.push_back(std::log(belief.metres_per_unit() / turn.as_given));
    input.weights.push_back(std::abs(turn.angle));
  }
  if (car.side_slip_sigma > 0) input.slip_deviation = (answer.side_slip - car.side_slip) / car.side_slip_sigma;
  estimate.test = TestTurns(input, options);
  if (estimate.test.worst_turn >= 0) estimate.test.worst_turn = tested[estimate.test.worst_turn];
}

// The scale along the drive, as the turns lie in it.
void DescribeScaleAtTurns(ScaleEstimate& estimate) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < estimate.segments.size(); ++i) {
    if (!estimate.segments[i].turning) continue;
    TurnEstimate& turn = estimate.turns[next++];
    turn.smoothed = estimate.smoothed[i].metres_per_unit();
    turn.smoothed_sigma = estimate.smoothed[i].sigma();
  }
}

// The scale goes through what each turn says with the car's constants as given; sigma covers how much they differ from
// the estimate, and from each other. Turns that know the scale much worse than others say nothing. Between two losses
// of tracking without a turn, the estimate stays.
void FollowTurns(const ScaleProblem& problem, const ScaleEstimatorOptions& options, ScaleEstimate& estimate) {
  struct Node {
    double place;
    double difference;  // ln(as given / smoothed)
    std::size_t piece;
  };
  double best_sigma = std::numeric_limits<double>::infinity();
  for (TurnEstimate& turn : estimate.turns) {
    turn.followed = turn.used && std::isfinite(turn.as_given);
    if (turn.followed) best_sigma = std::min(best_sigma, turn.as_given_sigma);
  }
  std::vector<Node> nodes;
  std::vector<std::size_t> pieces;
  std::vector<std::pair<double, double>> differences;
  std::size_t piece = 0;
  std::size_t next = 0;
  for (std::size_t i = 0; i < problem.segments.size(); ++i) {
    const PathSegment& segment = problem.segments[i];
    piece += segment.gap_sigma > 0 ? 1 : 0;
    pieces.push_back(piece);
    if (!segment.turning) continue;
    TurnEstimate& turn = estimate.turns[next++];
    turn.followed = turn.followed && turn.as_given_sigma <= options.max_sigma_ratio * best_sigma;
    if (!turn.followed) continue;
    const double difference = std::log(turn.as_given) - estimate.smoothed[i].mean[kLogScale];
    nodes.push_back({segment.middle, difference, piece});
    differences.emplace_back(difference, std::abs(segment.angle));
  }
  estimate.fell_back = true;
  if (nodes.empty()) return;
  const double centre = WeightedMedian(differences);
  double squares = 0;
  double weights = 0;
  for (const auto& [difference, weight] : differences) {
    squares += weight * (difference - centre) * (difference - centre);
    weights += weight;
  }
  const double spread = std::hypot(std::sqrt(squares / weights), estimate.test.disagreement);
  for (std::size_t i = 0; i < problem.segments.size(); ++i) {
    const double place = problem.segments[i].middle;
    const Node* before = nullptr;
    const Node* after = nullptr;
    for (const Node& node : nodes) {
      if (node.piece != pieces[i]) continue;
      if (node.place <= place) before = &node;
      if (node.place >= place && after == nullptr) after = &node;
    }
    double difference = 0;
    if (before != nullptr && after != nullptr) {
      const double way = after->place - before->place;
      const double share = way > 0 ? (place - before->place) / way : 0.0;
      difference = (1 - share) * before->difference + share * after->difference;
    } else if (before != nullptr || after != nullptr) {
      difference = (before != nullptr ? before : after)->difference;
    }
    const double sigma = std::max(spread, std::abs(difference - centre));
    estimate.smoothed[i].mean[kLogScale] += difference;
    estimate.smoothed[i].covariance(kLogScale, kLogScale) += sigma * sigma;
  }
  estimate.length_sigma = std::hypot(estimate.length_sigma, spread);
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
  if (!(max_sigma_ratio >= 1)) throw InputError("scale.max_sigma_ratio: has to be at least 1");
  if (!(huber > 0)) throw InputError("scale.huber: has to be positive");
  if (!(max_sigma > 0)) throw InputError("scale.max_sigma: has to be positive");
}

ScaleEstimateResult EstimateScale(const std::vector<VehicleStep>& steps, const CarPrior& car,
                                  const ScaleEstimatorOptions& options) {
  car.Check();
  options.Check();
  ScaleProblem problem;
  problem.segments = SplitIntoSegments(steps, options.segments);
  problem.options = options.evidence;
  problem.drift = options.drift;
  const std::vector<SegmentEvidence> gathered = GatherEvidence(steps, problem.segments, options.evidence);
  ScaleEstimateResult result;
  Selection selection = SelectTurns(gathered, PriorState(car, 0), options.evidence);
  problem.evidence = selection.evidence;
  result.turns = DescribeTurns(problem, car);
  if (result.turns.empty()) {
    result.reason = "it has no turn; " + WhatWouldDo(options);
    return result;
  }
  if (selection.log_scales.empty()) {
    result.reason = "no sufficiently slow turn shows the expected lateral motion; " + WhatWouldDo(options);
    return result;
  }
  const Answer answer = SmoothDrive(problem, gathered, car, options, selection);
  result.turns = DescribeTurns(answer.smoothing.problem(), car);

  ScaleEstimate estimate;
  estimate.segments = problem.segments;
  estimate.smoothed = answer.smoothed.segments;
  estimate.length_sigma = LengthSigma(answer.smoothed, problem.segments);
  estimate.converged = answer.smoothing.converged();
  const auto best = std::ranges::min_element(estimate.smoothed, {}, [](const ScaleBelief& b) { return b.sigma(); });
  if (!(best->sigma() <= options.max_sigma)) {
    result.reason = "its turns leave the scale uncertain by " + std::to_string(std::lround(100 * best->sigma())) +
                    " %, more than " + std::to_string(std::lround(100 * options.max_sigma)) + "; " +
                    WhatWouldDo(options);
    for (TurnEstimate& turn : result.turns) {
      if (!turn.used) continue;
      turn.used = false;
      turn.reason = "knows the scale too badly";
    }
    return result;
  }
  estimate.turns = result.turns;
  CompareTurns(answer, car, options.test, estimate);
  const double inflation = estimate.test.inflation;
  for (ScaleBelief& belief : estimate.smoothed) belief.covariance *= inflation * inflation;
  estimate.length_sigma *= inflation;
  estimate.car = DescribeCar(estimate.smoothed.back(), car, car.side_slip_sigma > 0 && answer.side_slip < 0);
  if (options.follow_turns || estimate.test.contradicted || !estimate.converged)
    FollowTurns(answer.smoothing.problem(), options, estimate);
  DescribeScaleAtTurns(estimate);
  result.estimate = std::move(estimate);
  return result;
}

}  // namespace turnscale

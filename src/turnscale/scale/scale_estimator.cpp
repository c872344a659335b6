// SPDX-License-Identifier: MIT
#include "turnscale/scale/scale_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "turnscale/base/check_part.h"
#include "turnscale/base/error.h"
#include "turnscale/geometry/angle.h"
#include "turnscale/scale/drive_evidence.h"
#include "turnscale/scale/drive_smoothing.h"
#include "turnscale/scale/missing_scale.h"
#include "turnscale/scale/prior_fit.h"
#include "turnscale/scale/single_turns.h"

namespace turnscale {
namespace {

double BestSigma(const std::vector<ScaleBelief>& smoothed) {
  return std::ranges::min_element(smoothed, {}, &ScaleBelief::sigma)->sigma();
}

// The car's constants as given, by which single-turn scales are taken. A yaw that is hardly known is the drive's, and
// so is a lag.
DriveState StateAsGiven(const CarPrior& car, const SmoothedScale& smoothed, const ScaleEstimatorOptions& options) {
  DriveState state = PriorBelief(car, 0).mean;
  if (car.yaw_sigma > options.max_given_yaw_sigma) state[kDirection] = smoothed.segments.back().mean[kDirection];
  if (car.image_lag_sigma > 0) state[kLag] = smoothed.segments.back().mean[kLag];
  return state;
}

CarBelief CarBeliefOf(const ScaleBelief& belief) {
  constexpr std::array kConstants = {kDirection, kSlip, kLogLeverArm, kLogHeight};
  // The yaw error is minus the direction.
  const Eigen::Vector4d sign(-1, 1, 1, 1);
  CarBelief car;
  for (int i = 0; i < 4; ++i) {
    car.mean[i] = sign[i] * belief.mean[kConstants[i]];
    for (int k = 0; k < 4; ++k)
      car.covariance(i, k) = sign[i] * sign[k] * belief.covariance(kConstants[i], kConstants[k]);
  }
  return car;
}

// A height that is less certain than `max_height_sigma` (relative) counts as unknown.
CarRefinement DescribeCar(const ScaleBelief& belief, const CarPrior& car, bool slip_at_bound, double max_height_sigma) {
  CarRefinement refinement{-belief.mean[kDirection], belief.Sigma(kDirection), std::max(belief.mean[kSlip], 0.0),
                           car.side_slip_sigma > 0 ? belief.Sigma(kSlip) : 0.0, slip_at_bound};
  const auto correlation = [&](DriveUnknown a, DriveUnknown b) {
    return belief.covariance(a, b) / (belief.Sigma(a) * belief.Sigma(b));
  };
  refinement.roll_height = belief.mean[kRollHeight];
  refinement.roll_height_sigma = belief.Sigma(kRollHeight);
  if (car.knows_lever_arm()) {
    refinement.lever_arm = std::exp(belief.mean[kLogLeverArm]);
    refinement.lever_arm_sigma = belief.Sigma(kLogLeverArm) * refinement.lever_arm;
    if (car.side_slip_sigma > 0) refinement.lever_arm_slip_correlation = correlation(kLogLeverArm, kSlip);
  }
  if (belief.Sigma(kLogHeight) <= max_height_sigma) {
    refinement.camera_height = std::exp(belief.mean[kLogHeight]);
    refinement.camera_height_sigma = belief.Sigma(kLogHeight) * refinement.camera_height;
    refinement.height_correlation = correlation(kLogLeverArm, kLogHeight);
    if (car.side_slip_sigma > 0) refinement.height_slip_correlation = correlation(kSlip, kLogHeight);
  }
  return refinement;
}

// Adds a standard deviation of ln(lambda) that all segments share.
void Widen(double sigma, ScaleEstimate& estimate) {
  for (ScaleBelief& belief : estimate.smoothed) belief.covariance(kLogScale, kLogScale) += sigma * sigma;
  estimate.length_sigma = std::hypot(estimate.length_sigma, sigma);
}

// Without the given height the estimate agrees with it: the conflict came from the height's own pull. Far from a
// conflict, so that the correlations of the two need not be known.
bool IsWithinSigma(const HeightConflict& conflict) {
  const double sigma = std::hypot(conflict.found_sigma / conflict.found, conflict.given_sigma / conflict.given);
  return std::abs(std::log(conflict.found / conflict.given)) < sigma;
}

// One of the two lengths is wrong.
void TakeConflict(const HeightConflict& conflict, ScaleEstimate& estimate) {
  estimate.height_conflict = conflict;
  Widen(conflict.scale_sigma(), estimate);
}

// Segments, other than used turns, in which the road shows the scale of the joint estimate.
std::vector<char> FromRoad(const ScaleProblem& problem, const ScaleEstimate& estimate) {
  const bool shows = estimate.car.camera_height > 0 && !estimate.uses_single_turns;
  std::vector<char> from_road;
  for (const SegmentEvidence& evidence : problem.evidence)
    from_road.push_back(shows && evidence.road && !evidence.turn ? 1 : 0);
  return from_road;
}

// The single-turn scales with the refined constants of the car, against the smoothed scale as it is before anything
// widens it.
void RefineTurns(const SmoothedDrive& drive, std::vector<TurnEstimate>& turns) {
  const ScaleProblem& problem = drive.problem;
  for (TurnEstimate& turn : turns) {
    if (!turn.used) continue;
    const PooledLine& line = *problem.evidence[turn.segment].turn;
    const ScaleBelief& belief = drive.smoothed.segments[turn.segment];
    const Measurement measurement = LinearizeTurn(line, belief.mean, problem.options);
    turn.own = OwnScale(line, belief.mean);
    turn.own_relative_sigma = std::sqrt(measurement.variance) / std::abs(measurement.by_state[kLogScale]);
    turn.weight = problem.weights[turn.segment][kLeverArmOfTurn];
    turn.deviation = measurement.innovation / std::sqrt(measurement.variance);
  }
}

// The joint test of the single-turn scales, and that of the slip.
TurnTest TestOf(const std::vector<TurnEstimate>& turns, const SmoothedDrive& drive, const CarPrior& car,
                const TurnTestOptions& options) {
  TurnTestInput input;
  input.chi_squared = drive.smoothed.chi_squared;
  input.degrees_of_freedom = drive.smoothed.degrees_of_freedom;
  input.slip_deviation = SlipDeviation(drive, car);
  std::vector<int> tested;
  for (int i = 0; i < static_cast<int>(turns.size()); ++i) {
    const TurnEstimate& turn = turns[i];
    if (!turn.used || !std::isfinite(turn.as_given)) continue;
    const double smoothed = drive.smoothed.segments[turn.segment].metres_per_unit();
    tested.push_back(i);
    input.deviations.push_back(turn.deviation);
    input.differences.push_back(std::log(smoothed / turn.as_given));
    input.weights.push_back(std::abs(turn.angle));
  }
  TurnTest test = TestTurns(input, options);
  if (test.worst_turn >= 0) test.worst_turn = tested[test.worst_turn];
  return test;
}

// An unusual slip where the turns agree nevertheless.
std::optional<SlipConflict> SlipConflictOf(const TurnTest& test, const SmoothedDrive& drive, const CarPrior& car,
                                           const TurnTestOptions& options) {
  const bool is_unusual = std::abs(SlipDeviation(drive, car)) > options.max_prior_deviation;
  if (test.contradicted || !is_unusual) return std::nullopt;
  return SlipConflict{car.side_slip, car.side_slip_sigma, drive.side_slip()};
}

// The smoothed scale at each turn.
void DescribeScaleAtTurns(ScaleEstimate& estimate) {
  for (TurnEstimate& turn : estimate.turns) {
    turn.smoothed = estimate.smoothed[turn.segment].metres_per_unit();
    turn.smoothed_relative_sigma = estimate.smoothed[turn.segment].sigma();
  }
}

// The smoothed scale and the turns, before they are tested.
ScaleEstimate EstimateOf(const SmoothedDrive& drive, const CarPrior& car, const ScaleEstimatorOptions& options) {
  const ScaleProblem& problem = drive.problem;
  ScaleEstimate estimate;
  estimate.segments = problem.segments;
  estimate.smoothed = drive.smoothed.segments;
  estimate.length_sigma = LengthSigma(drive.smoothed, problem.segments);
  estimate.converged = drive.converged;
  estimate.turns = DescribeTurns(problem, StateAsGiven(car, drive.smoothed, options));
  return estimate;
}

// Sigma covers the scatter of the turns, and the car is described with it.
void InflateAndDescribe(const SmoothedDrive& drive, const CarPrior& car, double max_height_sigma,
                        ScaleEstimate& estimate) {
  const double inflation = estimate.test.inflation;
  for (ScaleBelief& belief : estimate.smoothed) belief.covariance *= inflation * inflation;
  estimate.length_sigma *= inflation;
  const ScaleBelief& last = estimate.smoothed.back();
  if (car.image_lag_sigma > 0) estimate.image_lag = ImageLag{last.mean[kLag], last.Sigma(kLag)};
  const bool slip_at_bound = car.side_slip_sigma > 0 && drive.side_slip() < 0;
  estimate.car = DescribeCar(last, car, slip_at_bound, max_height_sigma);
  estimate.car_evidence = {CarBeliefOf(PriorBelief(car, 0)), CarBeliefOf(drive.car), inflation};
}

// Sigma grows by what the smoothing of stabilised images does to a scale from turns alone, and by what a lag may do:
// images that are stabilised may have one, too.
void CoverSmoothing(const DriveEvidence& evidence, const PriorFit& fit, const ScaleEstimatorOptions& options,
                    ScaleEstimate& estimate) {
  if (!options.stabilisation.enabled || !fit.car.knows_lever_arm() || fit.car.knows_height()) return;
  estimate.image_smoothing =
      FindImageSmoothing(evidence.steps, fit.drive->problem.segments, fit.drive->smoothed.segments,
                         options.evidence.line.sigma_theta, options.stabilisation);
  if (!estimate.image_smoothing) return;
  double& error = estimate.image_smoothing->scale_error;
  error = std::hypot(error, ErrorByLag(evidence, fit, options));
  Widen(error, estimate);
}

// Few turns do not confirm a lag, and one that something else may look like is not adopted. Sigma grows by how far the
// scale is from that of the other choice.
void CoverLag(const DriveEvidence& evidence, const PriorFit& fit, const ScaleEstimatorOptions& options,
              ScaleEstimate& estimate) {
  const bool adopted = fit.freed.lag;
  const auto used = std::ranges::count_if(estimate.turns, &TurnEstimate::used);
  if (adopted ? used >= options.stabilisation.min_lag_turns : options.stabilisation.adopts_lag) return;
  ScaleEstimatorOptions other = options;
  other.stabilisation.adopts_lag = !adopted;
  const PriorFit alternative = FitPriors(evidence, fit.given, other);
  if (alternative.freed.lag == adopted || !alternative.drive) return;
  const ScaleBelief& last = alternative.drive->smoothed.segments.back();
  if (!adopted)
    estimate.image_lag = ImageLag{.found = last.mean[kLag], .found_sigma = last.Sigma(kLag), .is_used = false};
  estimate.image_lag->scale_error =
      std::abs(last.mean[kLogScale] - fit.drive->smoothed.segments.back().mean[kLogScale]);
  Widen(estimate.image_lag->scale_error, estimate);
}

// No metres: the turns are left without a scale.
ScaleEstimateResult WithoutEstimate(std::string reason, std::vector<TurnEstimate> turns) {
  ScaleEstimateResult result;
  result.reason = std::move(reason);
  result.detected_turns = std::move(turns);
  return result;
}

// The joint estimate of all turns, tested, before a conflict changes it; or why there is none.
ScaleEstimateResult JointEstimate(const DriveEvidence& evidence, const PriorFit& fit,
                                  const ScaleEstimatorOptions& options) {
  const CarPrior& car = fit.car;
  if (!fit.drive) {
    const ScaleProblem problem = StartingProblem(evidence, car, options);
    return WithoutEstimate(WhyNoStart(evidence, car, options), DescribeTurns(problem, PriorBelief(car, 0).mean));
  }
  const SmoothedDrive& drive = *fit.drive;
  ScaleEstimate estimate = EstimateOf(drive, car, options);
  const double best = BestSigma(estimate.smoothed);
  if (!(best <= options.max_sigma)) {
    LeaveOutTurns("its scale is too uncertain", estimate.turns);
    return WithoutEstimate(WhyTooUncertain(best, evidence, car, options), std::move(estimate.turns));
  }
  ScaleEstimateResult result;
  result.detected_turns = estimate.turns;
  RefineTurns(drive, estimate.turns);
  estimate.test = TestOf(estimate.turns, drive, car, options.test);
  estimate.slip_conflict = SlipConflictOf(estimate.test, drive, car, options.test);
  InflateAndDescribe(drive, car, options.max_sigma, estimate);
  CoverLag(evidence, fit, options, estimate);
  CoverSmoothing(evidence, fit, options, estimate);
  result.estimate = std::move(estimate);
  return result;
}

// Single-turn scales where the joint estimate is not to be trusted, a wider sigma where only the slip is unusual: what
// it explains may be something else. Then all that depends on which scales are used.
void Conclude(const PriorFit& fit, const ScaleEstimatorOptions& options, ScaleEstimate& estimate) {
  if (options.uses_single_turns || estimate.test.contradicted || !estimate.converged)
    estimate.uses_single_turns = UseSingleTurns(options.max_sigma_ratio, estimate);
  if (estimate.slip_conflict && !estimate.uses_single_turns) Widen(estimate.test.disagreement, estimate);
  estimate.from_road = FromRoad(fit.drive->problem, estimate);
  DescribeScaleAtTurns(estimate);
}

// Says which priors were freed. There is no estimate where the yaw is too far off.
void NameFreedPriors(const PriorFit& fit, const ScaleEstimatorOptions& options, ScaleEstimateResult& result) {
  if (fit.freed.yaw && result.estimate) {
    const CarRefinement& found = result.estimate->car;
    result.estimate->yaw_conflict = YawConflict{fit.given.yaw_sigma, found.yaw_error, found.yaw_error_sigma};
    // So far off, lateral and forward motion are confused, and the yaw that fits best may be far from right, too.
    constexpr double kMostSigmas = 3;
    if (std::abs(found.yaw_error) > kMostSigmas * options.contradicted_yaw_sigma) {
      result.reason = "the drive contradicts the camera-to-vehicle rotation by about " +
                      std::to_string(std::lround(InDegrees(std::abs(found.yaw_error)))) +
                      " degrees of yaw; correct the rotation, or have it estimated";
      LeaveOutTurns("the camera-to-vehicle rotation is wrong", result.detected_turns);
      result.estimate.reset();
    }
  }
  if (fit.freed.lag && !result.estimate) result.reason = "the images seem to be stabilised; " + result.reason;
}

ScaleEstimateResult EstimateWithoutHeight(const DriveEvidence& evidence, const CarPrior& car,
                                          const ScaleEstimatorOptions& options) {
  const PriorFit fit = FitPriors(evidence, WithoutHeight(car), options);
  ScaleEstimateResult result = JointEstimate(evidence, fit, options);
  if (result.estimate) Conclude(fit, options, *result.estimate);
  NameFreedPriors(fit, options, result);
  return result;
}

// What becomes of a given height.
struct HeightDecision {
  std::optional<HeightConflict> conflict;
  /// The estimate without the given height, where the turns are consistent without it only.
  std::optional<ScaleEstimateResult> without;
};

// A height that seems to be in conflict with the turns is compared with the one that they show without it: weights,
// slip and yaw of the joint estimate are bent by it.
HeightDecision JudgeHeight(const DriveEvidence& evidence, const PriorFit& fit, const TurnTest& test,
                           const ScaleEstimatorOptions& options) {
  // With c unbounded: a wrong height may be what makes it negative.
  std::optional<HeightConflict> conflict = CompareHeight(fit.drive->car, fit.car, options.max_height_deviation);
  if (!conflict) return {};
  ScaleEstimateResult without = EstimateWithoutHeight(evidence, fit.car, options);
  if (without.estimate && without.estimate->car.camera_height > 0) {
    const ScaleEstimate& alone = *without.estimate;
    conflict->found = alone.car.camera_height;
    conflict->found_sigma = alone.car.camera_height_sigma;
    conflict->contradicts_turns =
        test.contradicted && !alone.test.contradicted && (options.uses_single_turns || !alone.uses_single_turns);
  }
  if (IsWithinSigma(*conflict)) return {};
  if (!conflict->contradicts_turns) return {conflict, {}};
  TakeConflict(*conflict, *without.estimate);
  DescribeScaleAtTurns(*without.estimate);
  return {conflict, std::move(without)};
}

}  // namespace

void ScaleEstimatorOptions::Check() const {
  segments.Check();
  evidence.Check();
  CheckPart("drift.", drift);
  CheckPart("test.", test);
  CheckPart("stabilisation.", stabilisation);
  if (!(max_sigma_ratio >= 1)) throw InputError("max_sigma_ratio: has to be at least 1");
  if (!(huber > 0)) throw InputError("huber: has to be positive");
  if (!(max_height_deviation > 0)) throw InputError("max_height_deviation: has to be positive");
  if (!(max_yaw_deviation > 0)) throw InputError("max_yaw_deviation: has to be positive");
  if (!(max_turn_yaw_deviation > 0)) throw InputError("max_turn_yaw_deviation: has to be positive");
  if (!(contradicted_yaw_sigma > 0)) throw InputError("contradicted_yaw_sigma_deg: has to be positive");
  if (!(max_given_yaw_sigma > 0)) throw InputError("max_given_yaw_sigma_deg: has to be positive");
  if (!(max_sigma > 0)) throw InputError("max_sigma: has to be positive");
}

ScaleEstimateResult EstimateScale(const std::vector<VehicleStep>& steps, const CarPrior& car,
                                  const ScaleEstimatorOptions& options) {
  car.Check();
  options.Check();
  const DriveEvidence evidence = EvidenceOfDrive(steps, options.segments, options.evidence);
  const PriorFit fit = FitPriors(evidence, car, options);
  ScaleEstimateResult result = JointEstimate(evidence, fit, options);
  if (result.estimate) {
    HeightDecision height = JudgeHeight(evidence, fit, result.estimate->test, options);
    if (height.without) {
      result = *std::move(height.without);
    } else {
      if (height.conflict) TakeConflict(*height.conflict, *result.estimate);
      Conclude(fit, options, *result.estimate);
    }
  }
  NameFreedPriors(fit, options, result);
  return result;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/scale/scale_estimator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "turnscale/base/check_part.h"
#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"
#include "turnscale/scale/drive_smoothing.h"
#include "turnscale/scale/follow_turns.h"
#include "turnscale/scale/turn_selection.h"

namespace turnscale {
namespace {

// The car's constants as given, by which single-turn scales are taken. A yaw that is hardly known is the drive's.
DriveState StateAsGiven(const CarPrior& car, const SmoothedScale& smoothed, const ScaleEstimatorOptions& options) {
  DriveState state = PriorBelief(car, 0).mean;
  if (car.yaw_sigma > options.max_given_yaw_sigma) state[kDirection] = smoothed.segments.back().mean[kDirection];
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
  refinement.roll_height = belief.mean[kRollHeight];
  refinement.roll_height_sigma = belief.Sigma(kRollHeight);
  if (car.knows_lever_arm()) {
    refinement.lever_arm = std::exp(belief.mean[kLogLeverArm]);
    refinement.lever_arm_sigma = belief.Sigma(kLogLeverArm) * refinement.lever_arm;
  }
  if (belief.Sigma(kLogHeight) <= max_height_sigma) {
    refinement.camera_height = std::exp(belief.mean[kLogHeight]);
    refinement.camera_height_sigma = belief.Sigma(kLogHeight) * refinement.camera_height;
    const auto correlation = [&](DriveUnknown unknown) {
      return belief.covariance(unknown, kLogHeight) / (belief.Sigma(unknown) * belief.Sigma(kLogHeight));
    };
    refinement.height_correlation = correlation(kLogLeverArm);
    if (car.side_slip_sigma > 0) refinement.height_slip_correlation = correlation(kSlip);
  }
  return refinement;
}

// Adds a standard deviation of ln(lambda) that all segments share.
void Widen(double sigma, ScaleEstimate& estimate) {
  for (ScaleBelief& belief : estimate.smoothed) belief.covariance(kLogScale, kLogScale) += sigma * sigma;
  estimate.length_sigma = std::hypot(estimate.length_sigma, sigma);
}

CarPrior WithoutHeight(CarPrior car) {
  car.camera_height = car.camera_height_sigma = car.height_correlation = car.height_slip_correlation = 0;
  return car;
}

// Without the given height the estimate agrees with it: the conflict came from the height's own pull. Far from a
// conflict, so that the correlations of the two need not be known.
bool IsWithinSigma(const HeightConflict& conflict) {
  const double sigma = std::hypot(conflict.found_sigma / conflict.found, conflict.given_sigma / conflict.given);
  return std::abs(std::log(conflict.found / conflict.given)) < sigma;
}

// One of the two lengths is wrong: the scale is between those that they imply.
void WidenForConflict(const HeightConflict& conflict, ScaleEstimate& estimate) {
  Widen(0.5 * std::log(conflict.found / conflict.given), estimate);
}

// Segments, other than used turns, in which the road shows the scale.
std::vector<char> FromRoad(const ScaleProblem& problem, const CarRefinement& car) {
  std::vector<char> from_road;
  for (const SegmentEvidence& evidence : problem.evidence)
    from_road.push_back(car.camera_height > 0 && evidence.road && !evidence.turn ? 1 : 0);
  return from_road;
}

// The single-turn scales, with the refined constants of the car, their joint test, and that of the slip.
void CompareTurns(const SmoothedDrive& drive, const CarPrior& car, const TurnTestOptions& options,
                  ScaleEstimate& estimate) {
  TurnTestInput input;
  input.chi_squared = drive.smoothed.chi_squared;
  input.degrees_of_freedom = drive.smoothed.degrees_of_freedom;
  std::vector<int> tested;
  const ScaleProblem& problem = drive.problem;
  for (int i = 0; i < static_cast<int>(estimate.turns.size()); ++i) {
    TurnEstimate& turn = estimate.turns[i];
    if (!turn.used) continue;
    const PooledLine& line = *problem.evidence[turn.segment].turn;
    const ScaleBelief& belief = estimate.smoothed[turn.segment];
    const Measurement measurement = LinearizeTurn(line, belief.mean, problem.options);
    turn.own = OwnScale(line, belief.mean);
    turn.own_sigma = std::sqrt(measurement.variance) / std::abs(measurement.by_state[kLogScale]);
    turn.weight = problem.weights[turn.segment][kLeverArmOfTurn];
    turn.deviation = measurement.innovation / std::sqrt(measurement.variance);
    if (!std::isfinite(turn.as_given)) continue;
    tested.push_back(i);
    input.deviations.push_back(turn.deviation);
    input.differences.push_back(std::log(belief.metres_per_unit() / turn.as_given));
    input.weights.push_back(std::abs(turn.angle));
  }
  if (car.side_slip_sigma > 0) input.slip_deviation = (drive.side_slip() - car.side_slip) / car.side_slip_sigma;
  estimate.test = TestTurns(input, options);
  if (estimate.test.worst_turn >= 0) estimate.test.worst_turn = tested[estimate.test.worst_turn];
  if (!estimate.test.contradicted && std::abs(input.slip_deviation) > options.max_prior_deviation)
    estimate.slip_conflict = SlipConflict{car.side_slip, car.side_slip_sigma, drive.side_slip()};
}

// The smoothed scale at each turn.
void DescribeScaleAtTurns(ScaleEstimate& estimate) {
  for (TurnEstimate& turn : estimate.turns) {
    turn.smoothed = estimate.smoothed[turn.segment].metres_per_unit();
    turn.smoothed_sigma = estimate.smoothed[turn.segment].sigma();
  }
}

// What would make the scale known.
std::string Remedy(const CarPrior& car, const ScaleEstimatorOptions& options,
                   const std::vector<SegmentEvidence>& evidence) {
  if (!car.knows_lever_arm()) return "give the lever arm, or the height of the camera more exactly";
  if (car.lever_arm_sigma > options.max_sigma * car.lever_arm)
    return "the lever arm, " + NumberText(car.lever_arm) + " +-" + NumberText(car.lever_arm_sigma) +
           " m, is itself too uncertain: check it";
  const long degrees = std::lround(options.segments.turns.min_region_angle * 180 / M_PI);
  const bool road =
      std::ranges::any_of(evidence, [](const SegmentEvidence& segment) { return segment.road.has_value(); });
  const bool turns =
      std::ranges::any_of(evidence, [](const SegmentEvidence& segment) { return segment.turn.has_value(); });
  return (turns ? "a sharper or slower turn is needed"
                : "a slow turn of " + std::to_string(degrees) + " degrees or more is needed") +
         (road && !car.knows_height() ? ", or the measured height of the camera above the road" : "");
}

bool AllSwingInward(const std::vector<SegmentEvidence>& evidence, const DriveState& state) {
  int turns = 0;
  for (const SegmentEvidence& segment : evidence) {
    if (!segment.turn) continue;
    if (!SwingsInward(*segment.turn, state)) return false;
    ++turns;
  }
  return turns > 0;
}

// No turn and no height gives a first value of the scale.
ScaleEstimateResult WithoutAStart(const ScaleProblem& problem, const std::vector<SegmentEvidence>& gathered,
                                  const CarPrior& car, const ScaleEstimatorOptions& options) {
  ScaleEstimateResult result;
  result.detected_turns = DescribeTurns(problem, PriorBelief(car, 0).mean);
  if (!car.knows_lever_arm()) {
    result.reason = "too few steps show the height above the road";
    return result;
  }
  if (result.detected_turns.empty()) {
    result.reason = "no turn; ";
  } else if (AllSwingInward(gathered, PriorBelief(car, 0).mean)) {
    result.reason =
        "in all turns the camera swings to the inside: they are too fast, or the camera is not ahead of the rear axle, "
        "looking forward, as the lever arm says; ";
  } else {
    result.reason =
        "no sufficiently slow turn shows the expected lateral motion, or the times of the images are wrong; ";
  }
  result.reason += Remedy(car, options, gathered);
  return result;
}

// Metres are not claimed where even the best of the scale is as uncertain as that.
ScaleEstimateResult TooUncertain(double sigma, std::vector<TurnEstimate> turns, const CarPrior& car,
                                 const ScaleEstimatorOptions& options, const std::vector<SegmentEvidence>& gathered) {
  ScaleEstimateResult result;
  result.detected_turns = std::move(turns);
  result.reason = "the drive leaves the scale uncertain by " + std::to_string(std::lround(100 * sigma)) +
                  " %, more than " + std::to_string(std::lround(100 * options.max_sigma)) + " %; " +
                  Remedy(car, options, gathered);
  LeaveOutTurns("its scale is too uncertain", result.detected_turns);
  return result;
}

// Straights and pairs of turns show another yaw than the prior expects, or the turns by themselves another than all
// else.
bool YawIsContradicted(const SmoothedDrive& drive, const CarPrior& car, const ScaleEstimatorOptions& options) {
  if (car.yaw_sigma >= options.contradicted_yaw_sigma) return false;
  if (ContradictsYaw(drive.car, car.yaw_sigma, options.max_yaw_deviation)) return true;
  const ScaleProblem& problem = drive.problem;
  std::vector<WeightedDirection> directions;
  for (std::size_t i = 0; i < problem.evidence.size(); ++i) {
    const std::optional<DirectionInTurn>& turn = problem.evidence[i].direction_in_turn;
    if (!turn) continue;
    const DriveState& state = drive.smoothed.segments[i].mean;
    directions.push_back(
        {LinearizeDirectionInTurn(*turn, state, problem.options), problem.weights[i][kDirectionInTurn]});
  }
  return TurnsContradictYaw(directions, drive.smoothed.segments.back(), problem.options.direction_in_turn_sigma,
                            options.max_turn_yaw_deviation);
}

// With a yaw that its prior does not hold, as the drive contradicts it.
ScaleEstimateResult EstimateWithFreeYaw(const std::vector<VehicleStep>& steps, const CarPrior& car,
                                        const ScaleEstimatorOptions& options) {
  CarPrior freed = car;
  freed.yaw_sigma = options.contradicted_yaw_sigma;
  ScaleEstimateResult result = EstimateScale(steps, freed, options);
  if (!result.estimate) return result;
  const CarRefinement& found = result.estimate->car;
  result.estimate->yaw_conflict = YawConflict{car.yaw_sigma, found.yaw_error, found.yaw_error_sigma};
  // So far off, lateral and forward motion are confused, and the yaw that fits best may be far from right, too.
  constexpr double kMostSigmas = 3;
  if (std::abs(found.yaw_error) <= kMostSigmas * options.contradicted_yaw_sigma) return result;
  result.reason = "the drive contradicts the camera-to-vehicle rotation by about " +
                  std::to_string(std::lround(std::abs(found.yaw_error) * 180 / M_PI)) +
                  " degrees of yaw; correct the rotation, or have it estimated";
  LeaveOutTurns("the camera-to-vehicle rotation is wrong", result.detected_turns);
  result.estimate.reset();
  return result;
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
  const bool slip_at_bound = car.side_slip_sigma > 0 && drive.side_slip() < 0;
  estimate.car = DescribeCar(estimate.smoothed.back(), car, slip_at_bound, max_height_sigma);
  estimate.car_evidence = {CarBeliefOf(PriorBelief(car, 0)), CarBeliefOf(drive.car), inflation};
}

}  // namespace

void ScaleEstimatorOptions::Check() const {
  segments.Check();
  evidence.Check();
  CheckPart("drift.", drift);
  CheckPart("test.", test);
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
  ScaleProblem problem;
  problem.segments = SplitIntoSegments(steps, options.segments);
  problem.options = options.evidence;
  problem.drift = options.drift;
  const std::vector<SegmentEvidence> gathered = GatherEvidence(steps, problem.segments, options.evidence);
  const MeanTurnDirection of_turns = MeanDirectionOfTurns(gathered, options.evidence);
  const TurnSelection selection = SelectTurns(gathered, car, StartingState(car, of_turns), options.evidence);
  problem.evidence = selection.evidence;
  if (!StartingLogScale(selection, car)) {
    const bool may_be_freed = car.knows_lever_arm() && car.yaw_sigma < options.contradicted_yaw_sigma;
    const double sigma = std::sqrt(of_turns.variance + car.yaw_sigma * car.yaw_sigma);
    if (may_be_freed && std::abs(of_turns.mean) > options.max_turn_yaw_deviation * sigma)
      return EstimateWithFreeYaw(steps, car, options);
    ScaleEstimateResult result = WithoutAStart(problem, gathered, car, options);
    if (!result.detected_turns.empty() && !std::ranges::all_of(steps, &VehicleStep::dense))
      result.reason =
          "in turns the camera turns by too much from one image or pose to the next, which are far apart in time; " +
          Remedy(car, options, gathered);
    return result;
  }
  const SmoothedDrive drive = SmoothDrive(problem, gathered, car, options.huber, selection);
  if (YawIsContradicted(drive, car, options)) return EstimateWithFreeYaw(steps, car, options);

  ScaleEstimate estimate = EstimateOf(drive, car, options);
  const auto best = std::ranges::min_element(estimate.smoothed, {}, [](const ScaleBelief& b) { return b.sigma(); });
  if (!(best->sigma() <= options.max_sigma))
    return TooUncertain(best->sigma(), std::move(estimate.turns), car, options, gathered);
  ScaleEstimateResult result;
  result.detected_turns = estimate.turns;
  // The turns are tested against the estimate as it is; only then is it widened.
  CompareTurns(drive, car, options.test, estimate);
  InflateAndDescribe(drive, car, options.max_sigma, estimate);
  // With c unbounded: a wrong height may be what makes it negative.
  estimate.height_conflict = CompareHeight(drive.car, car, options.max_height_deviation);
  if (estimate.height_conflict) {
    ScaleEstimateResult alone = EstimateScale(steps, WithoutHeight(car), options);
    if (alone.estimate && alone.estimate->car.camera_height > 0) {
      estimate.height_conflict->found = alone.estimate->car.camera_height;
      estimate.height_conflict->found_sigma = alone.estimate->car.camera_height_sigma;
      estimate.height_conflict->contradicts_turns = estimate.test.contradicted && !alone.estimate->test.contradicted &&
                                                    (options.follow_turns || !alone.estimate->fell_back);
    }
    if (IsWithinSigma(*estimate.height_conflict)) estimate.height_conflict.reset();
    // Weights, slip and yaw of the joint estimate are bent by the height.
    if (estimate.height_conflict && estimate.height_conflict->contradicts_turns) {
      alone.estimate->height_conflict = estimate.height_conflict;
      WidenForConflict(*estimate.height_conflict, *alone.estimate);
      DescribeScaleAtTurns(*alone.estimate);
      return alone;
    }
    if (estimate.height_conflict) WidenForConflict(*estimate.height_conflict, estimate);
  }
  if (options.follow_turns || estimate.test.contradicted || !estimate.converged)
    estimate.fell_back = FollowTurns(options.max_sigma_ratio, estimate);
  // What the unusual slip explains may be something else.
  if (estimate.slip_conflict && !estimate.fell_back) Widen(estimate.test.disagreement, estimate);
  estimate.from_road =
      estimate.fell_back ? std::vector<char>(estimate.segments.size(), 0) : FromRoad(drive.problem, estimate.car);
  DescribeScaleAtTurns(estimate);
  result.estimate = std::move(estimate);
  return result;
}

}  // namespace turnscale

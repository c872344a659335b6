// SPDX-License-Identifier: MIT
#include "turnscale/scale/prior_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "turnscale/scale/car_conflicts.h"
#include "turnscale/scale/image_stabilisation.h"
#include "turnscale/scale/turn_selection.h"
#include "turnscale/scale/turn_test.h"

namespace turnscale {
namespace {

ScaleProblem ProblemOf(const DriveEvidence& evidence, const TurnSelection& selection,
                       const ScaleEstimatorOptions& options) {
  ScaleProblem problem;
  problem.segments = evidence.segments;
  problem.evidence = selection.evidence;
  problem.options = options.evidence;
  problem.drift = options.drift;
  return problem;
}

// Empty where no turn and no height gives a first value of the scale.
std::optional<SmoothedDrive> SmoothFrom(const DriveState& start, const DriveEvidence& evidence, const CarPrior& car,
                                        const ScaleEstimatorOptions& options) {
  TurnSelection selection = SelectTurns(evidence.of_segments, car, start, options.evidence);
  if (!StartingLogScale(selection, car)) return std::nullopt;
  ScaleProblem problem = ProblemOf(evidence, selection, options);
  return SmoothDrive(std::move(problem), evidence.of_segments, car, options.huber, std::move(selection));
}

CarPrior WithLag(CarPrior car, const ScaleEstimatorOptions& options) {
  car.image_lag_sigma = options.stabilisation.lag_sigma;
  return car;
}

// A car that slips more than the prior expects.
CarPrior WithUnusualSlip(CarPrior car) {
  constexpr double kTimesUsual = 2;
  car.side_slip_sigma *= kTimesUsual;
  return car;
}

CarPrior WithFreed(const FreedPriors& freed, CarPrior car, const ScaleEstimatorOptions& options) {
  if (freed.yaw) car.yaw_sigma = options.contradicted_yaw_sigma;
  return freed.lag ? WithLag(car, options) : car;
}

bool TurnsAgree(const SmoothedDrive& drive, const TurnTestOptions& options) {
  return !ExceedsChance(drive.smoothed.chi_squared, drive.smoothed.degrees_of_freedom, options);
}

// No turn seems usable, and the turns by themselves show a yaw that may be why.
bool YawHidesTurns(const MeanTurnDirection& of_turns, const CarPrior& car, const ScaleEstimatorOptions& options) {
  if (!car.knows_lever_arm() || car.yaw_sigma >= options.contradicted_yaw_sigma) return false;
  const double sigma = std::sqrt(of_turns.variance + car.yaw_sigma * car.yaw_sigma);
  return std::abs(of_turns.mean) > options.max_turn_yaw_deviation * sigma;
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

// Whether the turns show a lag of stabilised images. A given height plays no part: one that disagrees with the lever
// arm would look like a lag. So would a slip that is unusually large, with which the turns agree: it has a warning of
// its own. One that is only large, and with which the turns agree, is more likely than stabilisation.
bool ShowsLag(const SmoothedDrive& drive, const DriveEvidence& evidence, const CarPrior& car,
              const ScaleEstimatorOptions& options) {
  const StabilisationOptions& stabilisation = options.stabilisation;
  if (!stabilisation.enabled || !stabilisation.adopts_lag) return false;
  if (car.image_lag_sigma > 0 || !car.knows_lever_arm()) return false;
  const DriveState& start = drive.car.mean;
  const CarPrior alone = WithoutHeight(car);
  const auto without = car.knows_height() ? SmoothFrom(start, evidence, alone, options) : drive;
  const auto with = SmoothFrom(start, evidence, WithLag(alone, options), options);
  if (!without || !with) return false;
  const double most_slip = options.test.max_prior_deviation;
  if (TurnsAgree(*without, options.test) && SlipDeviation(*without, car) > most_slip) return false;
  if (!TurnsAgree(*with, options.test) || std::abs(SlipDeviation(*with, car)) > most_slip) return false;
  if (!LagCounts(*without, *with, stabilisation)) return false;
  if (car.side_slip_sigma == 0) return true;
  const auto slipping = SmoothFrom(start, evidence, WithUnusualSlip(alone), options);
  return !slipping || !TurnsAgree(*slipping, options.test) || LagCounts(*slipping, *with, stabilisation);
}

// What the drive contradicts, if it is more or other than what is freed in `fit`.
std::optional<FreedPriors> Contradicted(const PriorFit& fit, const DriveEvidence& evidence,
                                        const ScaleEstimatorOptions& options) {
  const FreedPriors with_yaw{.yaw = true, .lag = fit.freed.lag};
  if (!fit.drive) return YawHidesTurns(evidence.of_turns, fit.car, options) ? std::optional(with_yaw) : std::nullopt;
  if (YawIsContradicted(*fit.drive, fit.car, options)) return with_yaw;
  // A lag may be all that seemed to contradict the yaw.
  if (ShowsLag(*fit.drive, evidence, fit.car, options)) return FreedPriors{.yaw = false, .lag = true};
  return std::nullopt;
}

}  // namespace

PriorFit FitPriors(const DriveEvidence& evidence, const CarPrior& car, const ScaleEstimatorOptions& options) {
  const auto fit_with = [&](const FreedPriors& freed) {
    PriorFit fit{car, freed, WithFreed(freed, car, options), std::nullopt};
    fit.drive = SmoothFrom(StartingState(fit.car, evidence.of_turns), evidence, fit.car, options);
    return fit;
  };
  // Ends: a freed lag stays so, and a freed yaw is given up only once, for a lag.
  PriorFit fit = fit_with({});
  while (const std::optional<FreedPriors> freed = Contradicted(fit, evidence, options)) fit = fit_with(*freed);
  return fit;
}

CarPrior WithoutHeight(CarPrior car) {
  car.camera_height = car.camera_height_sigma = car.height_correlation = car.height_slip_correlation = 0;
  return car;
}

double ErrorByLag(const DriveEvidence& evidence, const PriorFit& fit, const ScaleEstimatorOptions& options) {
  if (fit.car.image_lag_sigma > 0) return 0;
  const auto with = SmoothFrom(fit.drive->car.mean, evidence, WithLag(WithoutHeight(fit.car), options), options);
  if (!with) return 0;
  const ScaleBelief& without_lag = fit.drive->smoothed.segments.back();
  const ScaleBelief& with_lag = with->smoothed.segments.back();
  const double more = with_lag.sigma() * with_lag.sigma() - without_lag.sigma() * without_lag.sigma();
  return std::hypot(with_lag.mean[kLogScale] - without_lag.mean[kLogScale], std::sqrt(std::max(0.0, more)));
}

ScaleProblem StartingProblem(const DriveEvidence& evidence, const CarPrior& car, const ScaleEstimatorOptions& options) {
  const DriveState start = StartingState(car, evidence.of_turns);
  return ProblemOf(evidence, SelectTurns(evidence.of_segments, car, start, options.evidence), options);
}

double SlipDeviation(const SmoothedDrive& drive, const CarPrior& car) {
  return car.side_slip_sigma > 0 ? (drive.side_slip() - car.side_slip) / car.side_slip_sigma : 0.0;
}

}  // namespace turnscale

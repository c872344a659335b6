// SPDX-License-Identifier: MIT
#include "turnscale/scale/drive_smoothing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turnscale/base/robust_weights.h"

namespace turnscale {
namespace {

constexpr int kMostIterations = 40;
constexpr int kFreeSelections = 4;
constexpr double kConverged = 1e-6;       // change of a log-scale in an iteration
constexpr double kNegligible = 1e-3;      // such a change over the standard deviation
constexpr double kMaxLogScaleStep = 0.3;  // of a Gauss-Newton step

// The largest change of a log-scale in an iteration.
struct Change {
  double absolute = 0;
  double in_sigmas = 0;
};

// Moves the linearisation of each segment to its estimate.
Change Relinearize(const SmoothedScale& smoothed, std::vector<DriveState>& at) {
  Change change;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double before = at[i][kLogScale];
    at[i] = smoothed.segments[i].mean;
    at[i][kLogScale] = std::clamp(at[i][kLogScale], before - kMaxLogScaleStep, before + kMaxLogScaleStep);
    const double moved = std::abs(at[i][kLogScale] - before);
    change.absolute = std::max(change.absolute, moved);
    change.in_sigmas = std::max(change.in_sigmas, moved / smoothed.segments[i].sigma());
  }
  return change;
}

void Reweigh(const std::vector<DriveState>& at, double huber, ScaleProblem& problem) {
  for (std::size_t i = 0; i < at.size(); ++i)
    for (const auto& [kind, measurement] : MeasurementsOf(problem.evidence[i], at[i], problem.options))
      problem.weights[i][kind] = HuberWeight(measurement.innovation / std::sqrt(measurement.variance), huber);
}

SmoothedDrive SmoothUntilConverged(ScaleProblem problem, double huber) {
  SmoothedDrive drive;
  drive.problem = std::move(problem);
  drive.problem.weights.assign(drive.problem.segments.size(), kFullWeights);
  std::vector<DriveState> at(drive.problem.segments.size(), drive.problem.prior.mean);
  for (int i = 1; i <= kMostIterations && !drive.converged; ++i) {
    drive.smoothed = SmoothScale(drive.problem, at);
    const Change change = Relinearize(drive.smoothed, at);
    // The weights converge slowly: what is left in the end may not matter.
    drive.converged = change.absolute < kConverged || (i == kMostIterations && change.in_sigmas < kNegligible);
    Reweigh(at, huber, drive.problem);
  }
  drive.car = drive.smoothed.segments.back();
  return drive;
}

// The prior at c = 0: a height whose error correlates with that of c moves with it.
ScaleBelief WithoutSlip(const ScaleBelief& prior) {
  constexpr double kVariance = 1e-18;  // a covariance has to stay regular
  ScaleBelief held = Updated(prior, {-prior.mean[kSlip], kVariance, DriveRow::Unit(kSlip)}, 1, prior.mean);
  held.mean[kSlip] = 0;
  held.covariance.row(kSlip).setZero();
  held.covariance.col(kSlip).setZero();
  held.covariance(kSlip, kSlip) = kVariance;
  return held;
}

SmoothedDrive SmoothBounded(ScaleProblem problem, const CarPrior& car, double huber) {
  SmoothedDrive unbounded = SmoothUntilConverged(problem, huber);
  if (car.side_slip_sigma == 0 || unbounded.side_slip() >= 0) return unbounded;
  // Tyres do not slip inwards: at the bound, the estimate is the one without slip. The covariance stays that of the
  // unbounded fit.
  problem.prior = WithoutSlip(problem.prior);
  SmoothedDrive drive = SmoothUntilConverged(std::move(problem), huber);
  drive.car = unbounded.car;
  drive.smoothed.gains = unbounded.smoothed.gains;
  for (std::size_t i = 0; i < drive.smoothed.segments.size(); ++i)
    drive.smoothed.segments[i].covariance = unbounded.smoothed.segments[i].covariance;
  return drive;
}

bool SameTurns(const std::vector<SegmentEvidence>& a, const std::vector<SegmentEvidence>& b) {
  return std::ranges::equal(
      a, b, {}, [](const SegmentEvidence& segment) { return segment.turn.has_value(); },
      [](const SegmentEvidence& segment) { return segment.turn.has_value(); });
}

}  // namespace

SmoothedDrive SmoothDrive(ScaleProblem problem, const std::vector<SegmentEvidence>& gathered, const CarPrior& car,
                          double huber, TurnSelection selection) {
  for (int round = 1;; ++round) {
    problem.evidence = selection.evidence;
    problem.prior = PriorBelief(car, *StartingLogScale(selection, car));
    SmoothedDrive drive = SmoothBounded(problem, car, huber);
    // If selections alternate, turns that are left out stay left out.
    const std::vector<SegmentEvidence>& candidates = round < kFreeSelections ? gathered : problem.evidence;
    selection = SelectTurns(candidates, car, drive.smoothed.segments.back().mean, problem.options);
    if (!StartingLogScale(selection, car) || SameTurns(selection.evidence, problem.evidence)) return drive;
  }
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/mapping/absolute_scale_recovery.h"

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "turnscale/base/check_part.h"
#include "turnscale/base/error.h"

namespace turnscale {
namespace {

/// Held lengths count as met below this, relative.
constexpr double kHeldTolerance = 1e-6;
/// A held step has to be this share of its turn's mean step: the direction of a shorter one is unknown.
constexpr double kShortestHeldStep = 1e-3;
/// A camera centre is determined by two points; fewer leave the problem singular.
constexpr int kFewestPoints = 2;

void CheckTurns(const std::vector<TurnScale>& turns, const Map& map) {
  const auto require = [](bool good, const char* what, SourcePlace where = SourcePlace::Here()) {
    Ensure(good, std::string("scale recovery: ") + what, where);
  };
  require(!turns.empty(), "no turn is given");
  int previous = 0;
  for (const TurnScale& turn : turns) {
    require(turn.first_step > previous && turn.last_step >= turn.first_step, "steps of turns are out of order");
    require(std::isfinite(turn.factor) && turn.factor > 0, "the factor of a turn is not a positive number");
    require(std::isfinite(turn.sigma) && turn.sigma >= 0, "the sigma of a turn is negative or not a number");
    require(turn.distances.empty() || std::cmp_equal(turn.distances.size(), turn.last_step - turn.first_step + 1),
            "a turn needs one distance for each of its steps");
    previous = turn.last_step;
  }
  require(std::cmp_less(previous, map.keyframes.size()), "a step is not in the map");
}

/// Lengths (metres) that the steps of a turn are held at or measured as; 0 where a step is neither.
std::vector<double> StepDistances(const TurnScale& turn, const std::vector<Eigen::Vector3d>& guess) {
  std::vector<double> distances;
  double sum = 0;
  for (int j = turn.first_step; j <= turn.last_step; ++j) {
    distances.push_back((guess[j] - guess[j - 1]).norm());
    sum += distances.back();
  }
  const double shortest = kShortestHeldStep * sum / static_cast<double>(distances.size());
  for (std::size_t i = 0; i < distances.size(); ++i) {
    const bool long_enough = distances[i] > shortest;
    if (!turn.distances.empty()) distances[i] = turn.distances[i];
    if (!long_enough || !std::isfinite(distances[i]) || distances[i] <= 0) distances[i] = 0;
  }
  return distances;
}

void AddTurns(const ScaleRecoveryOptions& options, const std::vector<TurnScale>& turns,
              const std::vector<Eigen::Vector3d>& guess, const KeyframeRange& range, RecoveryProblem& problem) {
  for (const TurnScale& turn : turns) {
    const std::vector<double> distances = StepDistances(turn, guess);
    // Steps err independently for the adjustment; a turn of n equal ones errs by its sigma as a whole.
    const double step_sigma =
        turn.sigma * std::sqrt(static_cast<double>(distances.size())) / options.pixel_sigma_inflation;
    for (int j = turn.first_step; j <= turn.last_step; ++j) {
      const double distance = distances[j - turn.first_step];
      if (distance <= 0 || j <= range.first || j > range.last) continue;
      if (turn.sigma > 0) {
        MeasureStep(j, distance, step_sigma, range, problem);
      } else {
        HoldStep(j, distance, range, problem);
      }
    }
  }
}

double PathLength(const std::vector<Eigen::Vector3d>& centres, const KeyframeRange& range) {
  double length = 0;
  for (int j = range.first + 1; j <= range.last; ++j) length += (centres[j] - centres[j - 1]).norm();
  return length;
}

/// Steps that bridge a loss of tracking.
std::vector<int> Gaps(const Map& map) {
  std::vector<int> gaps;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k)
    if (map.keyframes[k].after_gap) gaps.push_back(static_cast<int>(k));
  return gaps;
}

/// Why an adjusted range is not to be believed; empty where it is.
std::string Astray(const BundleSummary& summary, double stretch, double max_stretch) {
  if (!std::isfinite(summary.final_cost) || !std::isfinite(stretch)) return "the adjustment diverged";
  if (!(summary.constraint_residual < kHeldTolerance)) return "the length constraints of the turn were not satisfied";
  if (stretch > max_stretch || stretch * max_stretch < 1) return "the adjustment changed the path length too much";
  return {};
}

/// Why the adjustment of a range is not worth trying; empty where it is.
std::string Hopeless(const RecoveryProblem& problem, const KeyframeRange& range) {
  if (problem.bundle.distances.empty() && problem.bundle.measured_distances.empty())
    return "no turn since tracking was lost";
  for (int k = range.first; k <= range.last; ++k) {
    if (problem.points_of_camera[k - range.first] >= kFewestPoints) continue;
    return "keyframe " + std::to_string(k) + " sees too few landmarks";
  }
  return {};
}

BundleSummary Adjust(const ScaleRecoveryOptions& options, BundleProblem& problem) {
  BundleOptions bundle_options;
  bundle_options.fix_rotations = true;
  bundle_options.max_iterations = options.max_iterations;
  bundle_options.huber_threshold = options.huber_threshold;
  return AdjustBundle(bundle_options, problem);
}

/// Moves the map from its guessed centres to the range's adjusted ones. What comes after the range goes along with its
/// last keyframe: the bridged step between them stays as it is.
void MoveMap(const RecoveryProblem& problem, const KeyframeRange& range, const std::vector<Eigen::Vector3d>& guess,
             std::vector<Eigen::Vector3d> centres, Map& map) {
  std::vector<double> factors = KeyframeFactors(guess, centres, range.first, std::vector<double>(guess.size(), 1.0));
  const Eigen::Vector3d shift = centres[range.last] - guess[range.last];
  for (std::size_t k = range.last + 1; k < centres.size(); ++k) {
    centres[k] += shift;
    factors[k] = 1.0;
  }
  WriteBackLandmarks(problem, map);
  CarryLandmarks(guess, centres, range.first, factors, problem.left_out, map);
  SetKeyframeCentres(centres, map);
}

/// Adjusts one range of the map that the guess has brought to metres; leaves it as it is when that does not work out.
RangeRecovery AdjustRange(const ScaleRecoveryOptions& options, const std::vector<TurnScale>& turns,
                          const KeyframeRange& range, Map& map) {
  RangeRecovery recovery{range, false, {}, {}};
  const std::vector<Eigen::Vector3d> guess = KeyframeCentres(map);
  RecoveryProblem problem = MakeRecoveryProblem(map, range, options.pixel_sigma);
  AddTurns(options, turns, guess, range, problem);
  recovery.reason = Hopeless(problem, range);
  if (!recovery.reason.empty()) return recovery;

  try {
    recovery.summary = Adjust(options, problem.bundle);
  } catch (const NumericalError& error) {
    // A map with a number that is none: the drive goes on with the guess.
    recovery.reason = error.what();
    return recovery;
  }
  std::vector<Eigen::Vector3d> centres = guess;
  for (int k = range.first; k <= range.last; ++k) {
    centres[k] = problem.bundle.camera_from_world[k - range.first].inverse().translation;
  }
  const double stretch = PathLength(centres, range) / PathLength(guess, range);
  recovery.reason = Astray(recovery.summary, stretch, options.max_stretch);
  recovery.adjusted = recovery.reason.empty();
  if (recovery.adjusted) MoveMap(problem, range, guess, centres, map);
  return recovery;
}

}  // namespace

void ScaleRecoveryOptions::Check() const {
  Require(std::isfinite(pixel_sigma) && pixel_sigma > 0, "pixel_sigma: has to be positive");
  Require(std::isfinite(pixel_sigma_inflation) && pixel_sigma_inflation >= 1,
          "pixel_sigma_inflation: has to be at least 1");
  Require(max_iterations >= 1, "max_iterations: has to be at least 1");
  Require(std::isfinite(huber_threshold) && huber_threshold >= 0, "huber_threshold: must not be negative");
  Require(max_stretch > 1, "max_stretch: has to be above 1");
}

ScaleRecoveryResult RecoverAbsoluteScale(const ScaleRecoveryOptions& options, const std::vector<TurnScale>& turns,
                                         Map& map) {
  options.Check();
  CheckTurns(turns, map);
  const std::vector<Eigen::Vector3d> before = KeyframeCentres(map);
  const std::vector<double> step_factors = StepFactors(before, turns, Gaps(map));
  ScaleMap(step_factors, map);

  ScaleRecoveryResult result;
  for (const KeyframeRange& range : SplitAtGaps(map)) {
    result.ranges.push_back(AdjustRange(options, turns, range, map));
  }
  result.factors = KeyframeFactors(before, KeyframeCentres(map), 0, step_factors);
  return result;
}

}  // namespace turnscale

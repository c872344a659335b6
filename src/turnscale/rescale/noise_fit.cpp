// SPDX-License-Identifier: MIT
#include "turnscale/rescale/noise_fit.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

constexpr int kGrid = 9;
constexpr int kRefinements = 2;

/// Argument between low and high with the greatest value, to a few per cent of the range: a grid, then a finer one
/// about its best point. The likelihood of a standard deviation is flat enough for that, and may have more than one
/// peak.
template <typename Function>
double GridMaximum(double low, double high, Function function) {
  double best = low;
  for (int refinement = 0; refinement < kRefinements; ++refinement) {
    const double spacing = (high - low) / (kGrid - 1);
    double best_value = -HUGE_VAL;
    const double begin = low;
    for (int i = 0; i < kGrid; ++i) {
      const double argument = begin + i * spacing;
      const double value = function(argument);
      if (value > best_value) {
        best_value = value;
        best = argument;
      }
    }
    low = std::max(low, best - spacing);
    high = std::min(high, best + spacing);
  }
  return best;
}

class Search {
 public:
  Search(const ScaleProblem& problem, const std::vector<DriveState>& at, const ScaleNoise& start)
      : problem_(problem), at_(at), noise_(start) {}

  void Improve(double& sigma, const NoisePrior& prior) {
    sigma = std::exp(GridMaximum(std::log(prior.low), std::log(prior.high), [&](double log_sigma) {
      sigma = std::exp(log_sigma);
      const double off = (log_sigma - std::log(prior.typical)) / prior.spread;
      return ScaleLogLikelihood(problem_, noise_, at_) - 0.5 * off * off;
    }));
  }

  ScaleNoise& noise() { return noise_; }

 private:
  const ScaleProblem& problem_;
  const std::vector<DriveState>& at_;
  ScaleNoise noise_;
};

}  // namespace

void NoisePrior::Check(const char* field) const {
  const auto require = [&](bool good, const char* what) {
    if (!good) throw InputError(std::string("noise.") + field + ": " + what);
  };
  require(low > 0 && high >= low && std::isfinite(high), "bounds have to be positive and in order");
  require(typical >= low && typical <= high, "the typical value has to lie within the bounds");
  require(spread > 0, "the spread has to be positive");
}

void NoiseFitOptions::Check() const {
  lever.Check("lever");
  direction.Check("direction");
  per_distance.Check("per_distance");
  per_angle.Check("per_angle");
}

ScaleNoise TypicalNoise(const NoiseFitOptions& options, bool drifting) {
  return {{options.lever.typical, options.direction.typical},
          drifting ? options.per_distance.typical : 0,
          drifting ? options.per_angle.typical : 0};
}

ScaleNoise FitNoise(const ScaleProblem& problem, const std::vector<DriveState>& at, const ScaleNoise& start,
                    const NoiseFitOptions& options) {
  Search search(problem, at, start);
  ScaleNoise& noise = search.noise();
  search.Improve(noise.stretch.lever, options.lever);
  search.Improve(noise.stretch.direction, options.direction);
  if (start.per_distance > 0) search.Improve(noise.per_distance, options.per_distance);
  if (start.per_angle > 0) search.Improve(noise.per_angle, options.per_angle);
  return noise;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/scale/turn_test.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

// Chi-squared value that is exceeded with probability p at k degrees of freedom (Wilson and Hilferty 1931).
double ChiSquaredLimit(double p, int k) {
  // Upper quantile of the normal distribution by bisection of the complementary error function.
  double low = 0;
  double high = 10;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(middle / std::sqrt(2.0)) > p ? low : high) = middle;
  }
  const double a = 2.0 / (9.0 * k);
  return k * std::pow(1 - a + low * std::sqrt(a), 3);
}

}  // namespace

void TurnTestOptions::Check() const {
  if (!(min_probability > 0 && min_probability < 0.5))
    throw InputError("min_probability: has to be above 0 and below 0.5");
  if (!(max_prior_deviation > 0)) throw InputError("max_prior_deviation: has to be positive");
  if (!(max_turn_deviation > 0)) throw InputError("max_turn_deviation: has to be positive");
  if (!(min_disagreement >= 0)) throw InputError("min_disagreement: must not be negative");
}

double InflationOf(double chi_squared, int degrees_of_freedom) {
  return degrees_of_freedom > 0 ? std::max(1.0, std::sqrt(chi_squared / degrees_of_freedom)) : 1;
}

bool ExceedsChance(double chi_squared, int degrees_of_freedom, const TurnTestOptions& options) {
  return degrees_of_freedom > 0 && chi_squared > ChiSquaredLimit(options.min_probability, degrees_of_freedom);
}

double ReductionSignificance(double before, double after, int degrees_of_freedom) {
  if (degrees_of_freedom < 1 || !(before > after && after > 0)) return 0;
  const double n = degrees_of_freedom;
  return (8 * n + 1) / (8 * n + 3) * std::sqrt(n * std::log(before / after));
}

TurnTest TestTurns(const TurnTestInput& input, const TurnTestOptions& options) {
  TurnTest test;
  test.chi_squared = input.chi_squared;
  test.degrees_of_freedom = input.degrees_of_freedom;
  double weights = 0;
  double worst = -1;
  for (std::size_t i = 0; i < input.deviations.size(); ++i) {
    test.disagreement += input.weights[i] * std::abs(input.differences[i]);
    weights += input.weights[i];
    if (std::abs(input.deviations[i]) <= worst) continue;
    worst = std::abs(input.deviations[i]);
    test.worst_turn = static_cast<int>(i);
  }
  if (weights > 0) test.disagreement /= weights;
  test.inflation = InflationOf(test.chi_squared, test.degrees_of_freedom);
  // A single turn has nothing to deviate from but what is assumed of the car.
  const bool deviates = input.deviations.size() > 1 && worst > options.max_turn_deviation;
  const bool is_inconsistent = ExceedsChance(test.chi_squared, test.degrees_of_freedom, options) ||
                               std::abs(input.slip_deviation) > options.max_prior_deviation || deviates;
  test.contradicted = is_inconsistent && test.disagreement > options.min_disagreement;
  return test;
}

}  // namespace turnscale

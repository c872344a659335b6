// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace turnscale {

struct TurnTestOptions {
  /// Significance level: the turns are inconsistent if chi-squared is less probable than this.
  double min_probability = 0.01;
  /// Or if the side slip deviates from its prior by more than this many standard deviations. (The yaw may deviate:
  /// it is observed on straights.)
  double max_prior_deviation = 2.5;
  /// Or if a turn deviates from the estimate by more than this many standard deviations of its own. Chi-squared does
  /// not include all turns: not the first one after a gap, which may contradict what was assumed of the gap.
  double max_turn_deviation = 5;
  /// Inconsistencies below this change of the scale (relative) are ignored.
  double min_disagreement = 0.05;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Input of the test; in the lists, one entry per used turn.
struct TurnTestInput {
  double chi_squared = 0;           ///< of all turns together (SmoothedScale)
  int degrees_of_freedom = 0;       ///< of chi-squared
  std::vector<double> deviations;   ///< TurnEstimate::deviation
  std::vector<double> differences;  ///< ln(smoothed / own as given), the car's constants as they were given
  std::vector<double> weights;      ///< angles, rad
  double slip_deviation = 0;        ///< of the side slip from its prior, in standard deviations of the prior
};

/// Consistency of the turns with the estimate.
struct TurnTest {
  bool contradicted = false;
  double chi_squared = 0;
  int degrees_of_freedom = 0;
  double disagreement = 0;  ///< weighted mean of |differences|
  int worst_turn = -1;      ///< index of the turn that deviates most; -1 without turns
  /// Factor on sigma: the square root of chi-squared over the degrees of freedom, at least 1.
  double inflation = 1;
};

/// TurnTest::inflation.
double InflationOf(double chi_squared, int degrees_of_freedom);

/// Whether chi-squared is more than chance explains.
bool ExceedsChance(double chi_squared, int degrees_of_freedom, const TurnTestOptions& options);

/// Significance of the reduction of chi-squared by one more parameter, `before` to `after`, if all sigmas may be wrong
/// by a common factor, in standard deviations of a normal variable: Student's t with so many degrees of freedom
/// (Wallace 1959, Bounds on normal approximations to Student's and the chi-square distributions). 0 without any.
double ReductionSignificance(double before, double after, int degrees_of_freedom);

/// Tests the turns against the estimate.
TurnTest TestTurns(const TurnTestInput& input, const TurnTestOptions& options);

}  // namespace turnscale

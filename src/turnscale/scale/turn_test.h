// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace turnscale {

struct TurnTestOptions {
  /// Turns contradict the estimate where the sum of their squared deviations is less likely than this by chance.
  double min_probability = 0.001;
  /// Or where the side slip has been moved by more than this many standard deviations of its prior. (The yaw may be:
  /// straights show it.)
  double max_prior_deviation = 2.5;
  /// Contradictions below this change of the scale (relative) do not matter.
  double min_disagreement = 0.05;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// What the test looks at: one entry a used turn.
struct TurnTestInput {
  double chi_squared = 0;           ///< of all turns together (SmoothedScale), one degree of freedom less than turns
  std::vector<double> deviations;   ///< ln(smoothed / own) over its standard deviation
  std::vector<double> differences;  ///< ln(smoothed / own as given), the car's constants as they were given
  std::vector<double> weights;      ///< angles, rad
  double slip_deviation = 0;        ///< of the side slip from its prior, in standard deviations of the prior
};

/// Do the turns agree with the drive's estimate?
struct TurnTest {
  bool contradicted = false;
  double chi_squared = 0;
  int degrees_of_freedom = 0;
  double disagreement = 0;  ///< weighted mean of |differences|
  int worst_turn = -1;      ///< index of the turn that deviates most; -1 without turns
  /// Factor on sigma that the scatter of the turns about the estimate asks for, at least 1.
  double inflation = 1;
};

/// Tests the turns against the estimate.
TurnTest TestTurns(const TurnTestInput& input, const TurnTestOptions& options);

}  // namespace turnscale

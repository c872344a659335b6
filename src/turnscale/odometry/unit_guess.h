// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

/// The unit of length of a new map in the unit of the old one.
struct UnitGuess {
  double unit = 1;   ///< positive
  double sigma = 1;  ///< relative standard deviation; 1 if nothing is known
};

/// Mean of two independent guesses, weighted in the logarithm by their variances. Where they contradict each other, the
/// standard deviation grows with the contradiction. A guess with a sigma of 1 or more is left out.
UnitGuess Combine(const UnitGuess& a, const UnitGuess& b);

}  // namespace turnscale

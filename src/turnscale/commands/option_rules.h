// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

namespace turnscale {

/// Which options of a command go together, by their names on the command line. The program declares them, so that its
/// help shows them; the command checks them for other callers (CheckTogether).
struct OptionRules {
  struct Pair {
    const char* one;
    const char* other;
  };
  std::vector<Pair> exclusive;  ///< at most one of the two is given
  std::vector<Pair> needs;      ///< the first is given only with the second
};

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

/// How many seeds a test over random worlds runs: `all`, or one under the address sanitizer (GCC's), which makes each
/// run about ten times slower and looks for invalid memory accesses, for which further seeds add little.
constexpr int SeedsToTest(int all) {
#ifdef __SANITIZE_ADDRESS__
  return all > 0 ? 1 : 0;
#else
  return all;
#endif
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

namespace turnscale {

/// Whether this is a build with the address sanitizer, GCC's or Clang's. It makes each run several times slower, and
/// looks for invalid memory accesses, for which further seeds add little: tests of statistics over many seeds skip
/// themselves, others run fewer.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif
#else
inline constexpr bool kSanitized = false;
#endif

/// How many seeds a test over random worlds runs: `all`, or one in a sanitizer build.
constexpr int SeedsToTest(int all) { return kSanitized && all > 1 ? 1 : all; }

}  // namespace turnscale

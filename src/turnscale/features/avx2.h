// SPDX-License-Identifier: MIT
// Code for AVX2 is compiled in addition to SSE2's, and runs where the processor has AVX2: TURNSCALE_WITH_AVX2 is 1
// where there is such code, TURNSCALE_AVX2 marks its functions.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(CV_FORCE_SIMD128_CPP)
#define TURNSCALE_WITH_AVX2 1
#define TURNSCALE_AVX2 __attribute__((target("avx2")))
#include <cstdint>

#include <immintrin.h>
#include <opencv2/core/utility.hpp>

namespace turnscale {

inline bool HasAvx2() {
  static const bool has = cv::checkHardwareSupport(CV_CPU_AVX2);
  return has;
}

TURNSCALE_AVX2 inline __m256i LoadWide(const std::int16_t* values) {
  return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(values));
}

}  // namespace turnscale
#else
#define TURNSCALE_WITH_AVX2 0
#endif

// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <opencv2/core.hpp>
#include <opencv2/core/hal/intrin.hpp>

#include "turnscale/features/avx2.h"

namespace turnscale {

/// Pixels that are processed together, as 16-bit integers.
constexpr int kPixelGroup = cv::v_int16x8::nlanes;

/// Gray levels of an image between its pixels, in integers: in 1/2^kBits of a gray level (at most 1/32), interpolated
/// bilinearly with weights in 1/32768. The same bits from SSE2, AVX2 and plain C++.
template <int kBits>
class GrayInterpolation {
 public:
  /// (x, y) is the top left pixel of a patch of `image`, in memory that reaches as far as the patch.
  GrayInterpolation(const cv::Mat& image, float x, float y)
      : GrayInterpolation(
            image.data + std::ptrdiff_t{cvFloor(y)} * static_cast<std::ptrdiff_t>(image.step) + cvFloor(x),
            static_cast<std::ptrdiff_t>(image.step), x, y) {}

  /// The same for rows of pixels `step` bytes apart; `corner` is the pixel at the integral parts of (x, y).
  GrayInterpolation(const uchar* corner, std::ptrdiff_t step, float x, float y)
      : step_(step), corner_(corner), right_(Weight(x - std::floor(x))), down_(Weight(y - std::floor(y))) {}

  /// Between two columns of a row: a group of pixels from `column` on.
  cv::v_int16x8 InRow(int row, int column) const {
    const uchar* pixels = corner_ + row * step_ + column;
    const cv::v_int16x8 left = Load(pixels);
    return (left << kBits) + cv::v_mul_hi((Load(pixels + 1) - left) << (kBits + 1), right_);
  }

  /// Between two rows that are interpolated already.
  cv::v_int16x8 Between(const cv::v_int16x8& above, const cv::v_int16x8& below) const {
    return above + cv::v_mul_hi((below - above) << 1, down_);
  }

#if TURNSCALE_WITH_AVX2
  /// The same for two groups.
  TURNSCALE_AVX2 __m256i WideInRow(int row, int column) const {
    const uchar* pixels = corner_ + row * step_ + column;
    const __m256i left = LoadWide(pixels);
    const __m256i difference = _mm256_slli_epi16(_mm256_subs_epi16(LoadWide(pixels + 1), left), kBits + 1);
    return _mm256_adds_epi16(_mm256_slli_epi16(left, kBits),
                             _mm256_mulhi_epi16(difference, _mm256_broadcastsi128_si256(right_.val)));
  }

  TURNSCALE_AVX2 __m256i WideBetween(__m256i above, __m256i below) const {
    const __m256i difference = _mm256_slli_epi16(_mm256_subs_epi16(below, above), 1);
    return _mm256_adds_epi16(above, _mm256_mulhi_epi16(difference, _mm256_broadcastsi128_si256(down_.val)));
  }
#endif

 private:
  static cv::v_int16x8 Weight(float fraction) {
    return cv::v_setall_s16(static_cast<std::int16_t>(std::min(32767.0F, fraction * 32768.0F)));
  }

  static cv::v_int16x8 Load(const uchar* pixels) { return cv::v_reinterpret_as_s16(cv::v_load_expand(pixels)); }

#if TURNSCALE_WITH_AVX2
  TURNSCALE_AVX2 static __m256i LoadWide(const uchar* pixels) {
    return _mm256_cvtepu8_epi16(_mm_loadu_si128(reinterpret_cast<const __m128i*>(pixels)));
  }
#endif

  std::ptrdiff_t step_;
  const uchar* corner_;
  cv::v_int16x8 right_;
  cv::v_int16x8 down_;
};

}  // namespace turnscale

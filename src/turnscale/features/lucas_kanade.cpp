// SPDX-License-Identifier: MIT
#include "turnscale/features/lucas_kanade.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <opencv2/core/hal/intrin.hpp>

#include "turnscale/features/avx2.h"
#include "turnscale/features/gray_interpolation.h"

namespace turnscale {
namespace {

constexpr int kGroup = kPixelGroup;
// Gray levels are in 1/32.
constexpr int kGrayBits = 5;
constexpr float kGrayLevel = 1 << kGrayBits;

// Texture below which a patch is flat, gray levels squared.
constexpr float kLeastTexture = 0.1F;

constexpr int kMostFlowWidth = (kMostFlowWindow + kGroup - 1) / kGroup * kGroup;

// Gradients are taken across one more pixel on each side.
constexpr int kMostSampledRows = kMostFlowWindow + 2;
constexpr int kMostSampledWidth = kMostFlowWidth + kGroup;

using Interpolation = GrayInterpolation<kGrayBits>;

// Sums over a patch, with the lanes added in a fixed order.
class PatchSum {
 public:
  void Add(const cv::v_int32x4& products) { lanes_ += cv::v_cvt_f32(products); }

  float Total() const {
    std::array<float, 4> lanes;
    cv::v_store(lanes.data(), lanes_);
    return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
  }

 private:
  cv::v_float32x4 lanes_ = cv::v_setzero_f32();
};

// What is searched: gray levels and gradients. Rows are padded to whole groups. Gradients are 0 in the padding and
// outside of the image, so that these pixels count for nothing: the border repeats what is inside, and moves the other
// way.
struct Patch {
  int width = 0;  // of a padded row
  std::array<std::int16_t, kMostFlowWindow * kMostFlowWidth> gray;
  std::array<std::int16_t, kMostFlowWindow * kMostFlowWidth> by_x;
  std::array<std::int16_t, kMostFlowWindow * kMostFlowWidth> by_y;
  float xx = 0, xy = 0, yy = 0;  // gradient matrix, summed
};

using SampledPatch = std::array<std::int16_t, kMostSampledRows * kMostSampledWidth>;

// Rows of `sampled` pixels, from `first` to their ends.
void Sample(const Interpolation& interpolation, int rows, int first, int sampled, SampledPatch& gray) {
  for (int column = first; column < sampled; column += kGroup) {
    cv::v_int16x8 above = interpolation.InRow(0, column);
    for (int row = 0; row < rows; ++row) {
      const cv::v_int16x8 below = interpolation.InRow(row + 1, column);
      cv::v_store(&gray[row * sampled + column], interpolation.Between(above, below));
      above = below;
    }
  }
}

// Adds the products of the gradients. `counts` has all bits set for the columns inside of the image.
void TakeGradients(const std::int16_t* sampled_row, int sampled, const std::int16_t* counts, int at, Patch& patch,
                   std::array<PatchSum, 3>& sums) {
  std::array<cv::v_int32x4, 3> row = {cv::v_setzero_s32(), cv::v_setzero_s32(), cv::v_setzero_s32()};
  for (int column = 0; column < patch.width; column += kGroup) {
    const std::int16_t* centre = sampled_row + column;
    const cv::v_int16x8 inside = cv::v_load(counts + column);
    const cv::v_int16x8 by_x = inside & ((cv::v_load(centre + 1) - cv::v_load(centre - 1)) >> 1);
    const cv::v_int16x8 by_y = inside & ((cv::v_load(centre + sampled) - cv::v_load(centre - sampled)) >> 1);
    cv::v_store(&patch.gray[at + column], cv::v_load(centre));
    cv::v_store(&patch.by_x[at + column], by_x);
    cv::v_store(&patch.by_y[at + column], by_y);
    row[0] += cv::v_dotprod(by_x, by_x);
    row[1] += cv::v_dotprod(by_x, by_y);
    row[2] += cv::v_dotprod(by_y, by_y);
  }
  for (size_t i = 0; i < row.size(); ++i) sums[i].Add(row[i]);
}

// Sums of the gradients times the difference of the image and the patch.
void SumMismatch(const Patch& patch, int window, const Interpolation& interpolation, PatchSum& sum_x, PatchSum& sum_y) {
  for (int column = 0; column < patch.width; column += kGroup) {
    // Over all rows of a group the sums stay below 2^31: differences below 2^13, gradients below 2^12, 31 rows.
    cv::v_int32x4 group_x = cv::v_setzero_s32();
    cv::v_int32x4 group_y = group_x;
    cv::v_int16x8 above = interpolation.InRow(0, column);
    for (int row = 0; row < window; ++row) {
      const cv::v_int16x8 below = interpolation.InRow(row + 1, column);
      const int at = row * patch.width + column;
      const cv::v_int16x8 difference = interpolation.Between(above, below) - cv::v_load(&patch.gray[at]);
      group_x += cv::v_dotprod(difference, cv::v_load(&patch.by_x[at]));
      group_y += cv::v_dotprod(difference, cv::v_load(&patch.by_y[at]));
      above = below;
    }
    sum_x.Add(group_x);
    sum_y.Add(group_y);
  }
}

#if TURNSCALE_WITH_AVX2
// Two groups at a time give the same bits: sums over a group are exact integers, and are added in the same order.
constexpr int kWideGroup = 2 * kGroup;

bool IsWide(int width) { return HasAvx2() && width % kWideGroup == 0; }

TURNSCALE_AVX2 void StoreWide(std::int16_t* values, __m256i wide) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(values), wide);
}

TURNSCALE_AVX2 cv::v_int32x4 FirstHalf(__m256i wide) { return cv::v_int32x4(_mm256_castsi256_si128(wide)); }

TURNSCALE_AVX2 cv::v_int32x4 SecondHalf(__m256i wide) { return cv::v_int32x4(_mm256_extracti128_si256(wide, 1)); }

TURNSCALE_AVX2 void SampleWide(const Interpolation& interpolation, int rows, int sampled, int end, SampledPatch& gray) {
  for (int column = 0; column < end; column += kWideGroup) {
    __m256i above = interpolation.WideInRow(0, column);
    for (int row = 0; row < rows; ++row) {
      const __m256i below = interpolation.WideInRow(row + 1, column);
      StoreWide(&gray[row * sampled + column], interpolation.WideBetween(above, below));
      above = below;
    }
  }
}

TURNSCALE_AVX2 void TakeGradientsWide(const std::int16_t* sampled_row, int sampled, const std::int16_t* counts, int at,
                                      Patch& patch, std::array<PatchSum, 3>& sums) {
  __m256i xx = _mm256_setzero_si256();
  __m256i xy = xx;
  __m256i yy = xx;
  for (int column = 0; column < patch.width; column += kWideGroup) {
    const std::int16_t* centre = sampled_row + column;
    const __m256i inside = LoadWide(counts + column);
    const __m256i across = _mm256_subs_epi16(LoadWide(centre + 1), LoadWide(centre - 1));
    const __m256i along = _mm256_subs_epi16(LoadWide(centre + sampled), LoadWide(centre - sampled));
    const __m256i by_x = _mm256_and_si256(inside, _mm256_srai_epi16(across, 1));
    const __m256i by_y = _mm256_and_si256(inside, _mm256_srai_epi16(along, 1));
    StoreWide(&patch.gray[at + column], LoadWide(centre));
    StoreWide(&patch.by_x[at + column], by_x);
    StoreWide(&patch.by_y[at + column], by_y);
    xx = _mm256_add_epi32(xx, _mm256_madd_epi16(by_x, by_x));
    xy = _mm256_add_epi32(xy, _mm256_madd_epi16(by_x, by_y));
    yy = _mm256_add_epi32(yy, _mm256_madd_epi16(by_y, by_y));
  }
  sums[0].Add(FirstHalf(xx) + SecondHalf(xx));
  sums[1].Add(FirstHalf(xy) + SecondHalf(xy));
  sums[2].Add(FirstHalf(yy) + SecondHalf(yy));
}

TURNSCALE_AVX2 void SumMismatchWide(const Patch& patch, int window, const Interpolation& interpolation, PatchSum& sum_x,
                                    PatchSum& sum_y) {
  for (int column = 0; column < patch.width; column += kWideGroup) {
    __m256i groups_x = _mm256_setzero_si256();
    __m256i groups_y = groups_x;
    __m256i above = interpolation.WideInRow(0, column);
    for (int row = 0; row < window; ++row) {
      const __m256i below = interpolation.WideInRow(row + 1, column);
      const int at = row * patch.width + column;
      const __m256i difference = _mm256_subs_epi16(interpolation.WideBetween(above, below), LoadWide(&patch.gray[at]));
      groups_x = _mm256_add_epi32(groups_x, _mm256_madd_epi16(difference, LoadWide(&patch.by_x[at])));
      groups_y = _mm256_add_epi32(groups_y, _mm256_madd_epi16(difference, LoadWide(&patch.by_y[at])));
      above = below;
    }
    sum_x.Add(FirstHalf(groups_x));
    sum_x.Add(SecondHalf(groups_x));
    sum_y.Add(FirstHalf(groups_y));
    sum_y.Add(SecondHalf(groups_y));
  }
}
#endif

// (x, y) is the top left pixel of the patch.
void CutOut(const cv::Mat& image, float x, float y, int window, Patch& patch) {
  patch.width = (window + kGroup - 1) / kGroup * kGroup;
  const int sampled = patch.width + kGroup;
  SampledPatch gray;
  const Interpolation interpolation(image, x - 1, y - 1);
  const int rows = window + 2;
#if TURNSCALE_WITH_AVX2
  const bool wide = IsWide(patch.width);
  if (wide) SampleWide(interpolation, rows, sampled, patch.width, gray);
  Sample(interpolation, rows, wide ? patch.width : 0, sampled, gray);
#else
  Sample(interpolation, rows, 0, sampled, gray);
#endif
  const auto is_inside = [](float at, int size) { return at >= 0 && at <= static_cast<float>(size - 1); };
  constexpr std::array<std::int16_t, kMostFlowWidth> kNone{};
  std::array<std::int16_t, kMostFlowWidth> counts{};
  for (int column = 0; column < window; ++column)
    counts[column] = is_inside(x + static_cast<float>(column), image.cols) ? -1 : 0;
  std::array<PatchSum, 3> sums;
  for (int row = 0; row < window; ++row) {
    const bool row_counts = is_inside(y + static_cast<float>(row), image.rows);
    const std::int16_t* of_row = row_counts ? counts.data() : kNone.data();
    const std::int16_t* sampled_row = &gray[(row + 1) * sampled + 1];
#if TURNSCALE_WITH_AVX2
    if (wide) {
      TakeGradientsWide(sampled_row, sampled, of_row, row * patch.width, patch, sums);
      continue;
    }
#endif
    TakeGradients(sampled_row, sampled, of_row, row * patch.width, patch, sums);
  }
  patch.xx = sums[0].Total();
  patch.xy = sums[1].Total();
  patch.yy = sums[2].Total();
}

// Smaller eigenvalue of the mean gradient matrix, gray levels squared.
float Texture(const Patch& patch, int window) {
  const float difference = patch.xx - patch.yy;
  const float root = std::sqrt(difference * difference + 4 * patch.xy * patch.xy);
  const float pixels = static_cast<float>(window * window);
  return 0.5F * (patch.xx + patch.yy - root) / (pixels * kGrayLevel * kGrayLevel);
}

// Sum of the gradients times the difference of the image and the patch. (x, y) is the top left pixel of the patch.
cv::Point2f Mismatch(const Patch& patch, int window, const cv::Mat& image, float x, float y) {
  const Interpolation interpolation(image, x, y);
  PatchSum sum_x;
  PatchSum sum_y;
#if TURNSCALE_WITH_AVX2
  if (IsWide(patch.width)) {
    SumMismatchWide(patch, window, interpolation, sum_x, sum_y);
    return {sum_x.Total(), sum_y.Total()};
  }
#endif
  SumMismatch(patch, window, interpolation, sum_x, sum_y);
  return {sum_x.Total(), sum_y.Total()};
}

// Half a patch outside is still inside the border.
bool IsNear(const cv::Mat& image, const cv::Point2f& point, float margin) {
  return point.x >= -margin && point.y >= -margin && point.x <= static_cast<float>(image.cols - 1) + margin &&
         point.y <= static_cast<float>(image.rows - 1) + margin;
}

}  // namespace

std::optional<cv::Point2f> TrackPatch(const LucasKanadeOptions& options, const cv::Mat& first, const cv::Point2f& point,
                                      const cv::Mat& second, const cv::Point2f& guess) {
  const int half_window = options.window / 2;
  const float half = static_cast<float>(half_window);
  if (!IsNear(first, point, half) || !IsNear(second, guess, half)) return std::nullopt;
  Patch patch;
  CutOut(first, point.x - half, point.y - half, options.window, patch);
  if (!(Texture(patch, options.window) >= kLeastTexture)) return std::nullopt;
  const float inverse = 1.0F / (patch.xx * patch.yy - patch.xy * patch.xy);
  cv::Point2f pixel = guess;
  cv::Point2f last_step(0, 0);
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const cv::Point2f b = Mismatch(patch, options.window, second, pixel.x - half, pixel.y - half);
    const cv::Point2f step((patch.xy * b.y - patch.yy * b.x) * inverse, (patch.xy * b.x - patch.xx * b.y) * inverse);
    pixel += step;
    if (!IsNear(second, pixel, half)) return std::nullopt;
    if (step.dot(step) <= options.tolerance * options.tolerance) break;
    // Two places are equally good: their middle.
    if (std::abs(step.x + last_step.x) < 0.01F && std::abs(step.y + last_step.y) < 0.01F) {
      pixel -= 0.5F * step;
      break;
    }
    last_step = step;
  }
  return pixel;
}

}  // namespace turnscale

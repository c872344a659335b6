// SPDX-License-Identifier: MIT
#include "turnscale/features/patch_sums.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <opencv2/core/hal/intrin.hpp>

#include "turnscale/features/avx2.h"

namespace turnscale {
namespace {

// Products of two gray levels, and of gradients, are below 2^26: 32 bits hold their sums over two columns of this many
// rows.
constexpr int kSummedRows = 16;

// Columns of a patch from one on, and rows: so many that their sums fit.
struct Block {
  int column = 0;
  int first_row = 0;
  int end_row = 0;
};

// Sums over a patch, per lane. They are exact, so that the order does not matter.
using Lanes = cv::v_int32x4;

double Total(const Lanes& lanes) {
  std::array<std::int32_t, Lanes::nlanes> values;
  cv::v_store(values.data(), lanes);
  return static_cast<double>((std::int64_t{values[0]} + values[1]) + (std::int64_t{values[2]} + values[3]));
}

void AddBlock(const PatchTemplate& patch, const PatchInterpolation& interpolation, const Block& block,
              ImageSums& sums) {
  Lanes by_x = cv::v_setzero_s32();
  Lanes by_y = by_x, value = by_x, one = by_x, gray = by_x;
  const cv::v_int16x8 middle = cv::v_setall_s16(patch.middle);
  const cv::v_int16x8 ones = cv::v_setall_s16(1);
  const cv::v_int16x8 inside = cv::v_load(&patch.in_patch[block.column]);
  cv::v_int16x8 above = interpolation.InRow(block.first_row, block.column);
  for (int row = block.first_row; row < block.end_row; ++row) {
    const cv::v_int16x8 below = interpolation.InRow(row + 1, block.column);
    const cv::v_int16x8 shown = inside & (interpolation.Between(above, below) - middle);
    const int at = row * patch.width + block.column;
    by_x += cv::v_dotprod(shown, cv::v_load(&patch.by_x[at]));
    by_y += cv::v_dotprod(shown, cv::v_load(&patch.by_y[at]));
    value += cv::v_dotprod(shown, cv::v_load(&patch.value[at]));
    one += cv::v_dotprod(shown, ones);
    gray += cv::v_dotprod(shown, shown);
    above = below;
  }
  sums.by_x += Total(by_x);
  sums.by_y += Total(by_y);
  sums.value += Total(value);
  sums.one += Total(one);
  sums.gray += Total(gray);
}

void AddBlock(const PatchTemplate& patch, const Block& block, TemplateSums& sums) {
  Lanes xx = cv::v_setzero_s32();
  Lanes xy = xx, yy = xx, xv = xx, yv = xx, vv = xx, x = xx, y = xx, v = xx;
  const cv::v_int16x8 ones = cv::v_setall_s16(1);
  for (int row = block.first_row; row < block.end_row; ++row) {
    const int at = row * patch.width + block.column;
    const cv::v_int16x8 by_x = cv::v_load(&patch.by_x[at]);
    const cv::v_int16x8 by_y = cv::v_load(&patch.by_y[at]);
    const cv::v_int16x8 value = cv::v_load(&patch.value[at]);
    xx += cv::v_dotprod(by_x, by_x);
    xy += cv::v_dotprod(by_x, by_y);
    yy += cv::v_dotprod(by_y, by_y);
    xv += cv::v_dotprod(by_x, value);
    yv += cv::v_dotprod(by_y, value);
    vv += cv::v_dotprod(value, value);
    x += cv::v_dotprod(by_x, ones);
    y += cv::v_dotprod(by_y, ones);
    v += cv::v_dotprod(value, ones);
  }
  sums.xx += Total(xx);
  sums.xy += Total(xy);
  sums.yy += Total(yy);
  sums.xv += Total(xv);
  sums.yv += Total(yv);
  sums.vv += Total(vv);
  sums.x += Total(x);
  sums.y += Total(y);
  sums.v += Total(v);
}

#if TURNSCALE_WITH_AVX2
// The same for a whole block at once.
TURNSCALE_AVX2 void MultiplyAdd(__m256i& lanes, __m256i a, __m256i b) {
  lanes = _mm256_add_epi32(lanes, _mm256_madd_epi16(a, b));
}

TURNSCALE_AVX2 double Total(__m256i lanes) {
  const __m256i pairs = _mm256_add_epi64(_mm256_cvtepi32_epi64(_mm256_castsi256_si128(lanes)),
                                         _mm256_cvtepi32_epi64(_mm256_extracti128_si256(lanes, 1)));
  const __m128i two = _mm_add_epi64(_mm256_castsi256_si128(pairs), _mm256_extracti128_si256(pairs, 1));
  return static_cast<double>(_mm_cvtsi128_si64(two) + _mm_extract_epi64(two, 1));
}

TURNSCALE_AVX2 void AddWideBlock(const PatchTemplate& patch, const PatchInterpolation& interpolation,
                                 const Block& block, ImageSums& sums) {
  __m256i by_x = _mm256_setzero_si256();
  __m256i by_y = by_x, value = by_x, one = by_x, gray = by_x;
  const __m256i middle = _mm256_set1_epi16(patch.middle);
  const __m256i ones = _mm256_set1_epi16(1);
  const __m256i inside = LoadWide(&patch.in_patch[block.column]);
  __m256i above = interpolation.WideInRow(block.first_row, block.column);
  for (int row = block.first_row; row < block.end_row; ++row) {
    const __m256i below = interpolation.WideInRow(row + 1, block.column);
    const __m256i shown = _mm256_and_si256(inside, _mm256_subs_epi16(interpolation.WideBetween(above, below), middle));
    const int at = row * patch.width + block.column;
    MultiplyAdd(by_x, shown, LoadWide(&patch.by_x[at]));
    MultiplyAdd(by_y, shown, LoadWide(&patch.by_y[at]));
    MultiplyAdd(value, shown, LoadWide(&patch.value[at]));
    MultiplyAdd(one, shown, ones);
    MultiplyAdd(gray, shown, shown);
    above = below;
  }
  sums.by_x += Total(by_x);
  sums.by_y += Total(by_y);
  sums.value += Total(value);
  sums.one += Total(one);
  sums.gray += Total(gray);
}

TURNSCALE_AVX2 void AddWideBlock(const PatchTemplate& patch, const Block& block, TemplateSums& sums) {
  __m256i xx = _mm256_setzero_si256();
  __m256i xy = xx, yy = xx, xv = xx, yv = xx, vv = xx, x = xx, y = xx, v = xx;
  const __m256i ones = _mm256_set1_epi16(1);
  for (int row = block.first_row; row < block.end_row; ++row) {
    const int at = row * patch.width + block.column;
    const __m256i by_x = LoadWide(&patch.by_x[at]);
    const __m256i by_y = LoadWide(&patch.by_y[at]);
    const __m256i value = LoadWide(&patch.value[at]);
    MultiplyAdd(xx, by_x, by_x);
    MultiplyAdd(xy, by_x, by_y);
    MultiplyAdd(yy, by_y, by_y);
    MultiplyAdd(xv, by_x, value);
    MultiplyAdd(yv, by_y, value);
    MultiplyAdd(vv, value, value);
    MultiplyAdd(x, by_x, ones);
    MultiplyAdd(y, by_y, ones);
    MultiplyAdd(v, value, ones);
  }
  sums.xx += Total(xx);
  sums.xy += Total(xy);
  sums.yy += Total(yy);
  sums.xv += Total(xv);
  sums.yv += Total(yv);
  sums.vv += Total(vv);
  sums.x += Total(x);
  sums.y += Total(y);
  sums.v += Total(v);
}
#endif

template <typename Add>
void ForEachBlock(const PatchTemplate& patch, int columns, const Add& add) {
  for (int row = 0; row < patch.side; row += kSummedRows)
    for (int column = 0; column < patch.width; column += columns)
      add(Block{column, row, std::min(row + kSummedRows, patch.side)});
}

// The image around the patch; copied where reading whole blocks of pixels would leave the image.
class PatchView {
 public:
  PatchView(const cv::Mat& image, int row, int column, int rows, int width)
      : pixels_(image.ptr<uchar>(row) + column), step_(static_cast<std::ptrdiff_t>(image.step)) {
    if (column + width < image.cols) return;
    const int inside = image.cols - column;
    for (int i = 0; i < rows; ++i) {
      uchar* copy = &copy_[static_cast<size_t>(i) * kStep];
      std::copy_n(pixels_ + i * step_, inside, copy);
      std::fill(copy + inside, copy + kStep, uchar{0});
    }
    pixels_ = copy_.data();
    step_ = kStep;
  }
  PatchView(const PatchView&) = delete;
  PatchView& operator=(const PatchView&) = delete;

  const uchar* corner() const { return pixels_; }
  std::ptrdiff_t step() const { return step_; }

 private:
  static constexpr std::ptrdiff_t kStep = kMostPatchWidth + kPatchBlock;

  std::array<uchar, (kMostPatchSide + 1) * kStep> copy_;
  const uchar* pixels_;
  std::ptrdiff_t step_;
};

}  // namespace

TemplateSums SumsOf(const PatchTemplate& patch) {
  TemplateSums sums;
#if TURNSCALE_WITH_AVX2
  if (HasAvx2()) {
    ForEachBlock(patch, kPatchBlock, [&](const Block& block) { AddWideBlock(patch, block, sums); });
    return sums;
  }
#endif
  ForEachBlock(patch, kPixelGroup, [&](const Block& block) { AddBlock(patch, block, sums); });
  return sums;
}

ImageSums SumsOf(const PatchTemplate& patch, const cv::Mat& image, float x, float y) {
  const PatchView view(image, static_cast<int>(y), static_cast<int>(x), patch.side + 1, patch.width);
  const PatchInterpolation interpolation(view.corner(), view.step(), x, y);
  ImageSums sums;
#if TURNSCALE_WITH_AVX2
  if (HasAvx2()) {
    ForEachBlock(patch, kPatchBlock, [&](const Block& block) { AddWideBlock(patch, interpolation, block, sums); });
    return sums;
  }
#endif
  ForEachBlock(patch, kPixelGroup, [&](const Block& block) { AddBlock(patch, interpolation, block, sums); });
  return sums;
}

}  // namespace turnscale

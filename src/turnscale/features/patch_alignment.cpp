// SPDX-License-Identifier: MIT
#include "turnscale/features/patch_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/LU>
#include <opencv2/core/hal/intrin.hpp>

#include "turnscale/base/error.h"
#include "turnscale/features/avx2.h"
#include "turnscale/features/gray_interpolation.h"

namespace turnscale {
namespace {

// Gray levels are integers in 1/32. Products of two of them, and of gradients, are below 2^26, so that 32 bits hold
// their sums over two columns of this many rows.
constexpr int kPatchGrayBits = 5;
constexpr int kSummedRows = 16;
using PatchInterpolation = GrayInterpolation<kPatchGrayBits>;

// Sum over the patch, gray levels squared: what is flatter looks like anything.
constexpr double kLeastVariance = 1 << (2 * kPatchGrayBits);

// Where contrast is low, the rounding of gray levels moves the minimum: steps of up to so many times the tolerance may
// no longer reduce the difference.
constexpr double kRoundingSteps = 5;

// Rows are padded to whole blocks of this many pixels.
constexpr int kWideBlock = 2 * kPixelGroup;
constexpr int kMostHalf = 20;
constexpr int kMostSide = 2 * kMostHalf + 1;
constexpr int kMostWidth = (kMostSide + kWideBlock - 1) / kWideBlock * kWideBlock;

bool Inside(const cv::Mat& image, float x, float y) {
  return x >= 0 && y >= 0 && x < static_cast<float>(image.cols - 1) && y < static_cast<float>(image.rows - 1);
}

// Samples that are computed together. A gather reads four pixels where two are needed: so many beyond them.
constexpr int kWide = 8;
constexpr int kWideReach = 2;

// Gray levels at points on a line: coordinates in 1/65536 pixel, weights in 1/1024.
class LineSampler {
 public:
  LineSampler(const cv::Mat& image, const Eigen::Vector2d& step)
      : image_(image), dx_(Fixed(step.x())), dy_(Fixed(step.y())) {}

  void StartAt(const Eigen::Vector2d& point) {
    x_ = Fixed(point.x()) + kHalfWeight;
    y_ = Fixed(point.y()) + kHalfWeight;
  }

  std::int16_t Next() {
    const uchar* top = image_.data + static_cast<size_t>(y_ >> kBits) * image_.step + static_cast<size_t>(x_ >> kBits);
    const uchar* bottom = top + image_.step;
    const int right = Weight(x_);
    const int down = Weight(y_);
    const int above = (top[0] << kWeightBits) + right * (top[1] - top[0]);
    const int below = (bottom[0] << kWeightBits) + right * (bottom[1] - bottom[0]);
    x_ += dx_;
    y_ += dy_;
    return static_cast<std::int16_t>(((above << kWeightBits) + down * (below - above) + kHalfGray) >> kUnusedBits);
  }

#if TURNSCALE_WITH_AVX2
  // Whether coordinates and addresses in this image fit in 32 bits.
  static bool IsSmall(const cv::Mat& image) {
    constexpr int kMost = 1 << (31 - kBits);
    return image.cols < kMost && image.rows < kMost && image.step * image.rows < size_t{1} << 31;
  }

  // The next `count` gray levels, eight at a time, and up to seven copies of the last one. Reads up to kWideReach
  // pixels to the right of what Next reads.
  TURNSCALE_AVX2 void NextWide(int count, std::int16_t* values) const {
    const __m256i eight = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
    const __m256i last = _mm256_set1_epi32(count - 1);
    const __m256i step = _mm256_set1_epi32(static_cast<int>(image_.step));
    const __m256i mask = _mm256_set1_epi32((1 << kWeightBits) - 1);
    const __m256i one = _mm256_set1_epi32(1 << kWeightBits);
    const int* top = reinterpret_cast<const int*>(image_.data);
    const int* bottom = reinterpret_cast<const int*>(image_.data + image_.step);
    for (int first = 0; first < count; first += kWide) {
      const __m256i steps = _mm256_min_epi32(_mm256_add_epi32(eight, _mm256_set1_epi32(first)), last);
      const __m256i x = AfterSteps(x_, dx_, steps);
      const __m256i y = AfterSteps(y_, dy_, steps);
      const __m256i at =
          _mm256_add_epi32(_mm256_mullo_epi32(_mm256_srai_epi32(y, kBits), step), _mm256_srai_epi32(x, kBits));
      const __m256i right = _mm256_and_si256(_mm256_srai_epi32(x, kBits - kWeightBits), mask);
      const __m256i down = _mm256_and_si256(_mm256_srai_epi32(y, kBits - kWeightBits), mask);
      const __m256i weights = _mm256_or_si256(_mm256_sub_epi32(one, right), _mm256_slli_epi32(right, 16));
      const __m256i above = _mm256_madd_epi16(FirstPair(_mm256_i32gather_epi32(top, at, 1)), weights);
      const __m256i below = _mm256_madd_epi16(FirstPair(_mm256_i32gather_epi32(bottom, at, 1)), weights);
      const __m256i sum = _mm256_add_epi32(_mm256_slli_epi32(above, kWeightBits),
                                           _mm256_mullo_epi32(down, _mm256_sub_epi32(below, above)));
      const __m256i gray = _mm256_srai_epi32(_mm256_add_epi32(sum, _mm256_set1_epi32(kHalfGray)), kUnusedBits);
      _mm_storeu_si128(reinterpret_cast<__m128i*>(values + first),
                       _mm_packs_epi32(_mm256_castsi256_si128(gray), _mm256_extracti128_si256(gray, 1)));
    }
  }
#endif

 private:
#if TURNSCALE_WITH_AVX2
  TURNSCALE_AVX2 static __m256i AfterSteps(std::int64_t start, std::int64_t step, __m256i steps) {
    return _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(start)),
                            _mm256_mullo_epi32(steps, _mm256_set1_epi32(static_cast<int>(step))));
  }

  // The first two bytes of each four, as 16-bit integers.
  TURNSCALE_AVX2 static __m256i FirstPair(__m256i bytes) {
    const __m256i first = _mm256_and_si256(bytes, _mm256_set1_epi32(0xFF));
    return _mm256_or_si256(first, _mm256_slli_epi32(_mm256_and_si256(bytes, _mm256_set1_epi32(0xFF00)), 8));
  }
#endif

  static constexpr int kBits = 16;
  static constexpr int kWeightBits = 10;
  static constexpr int kHalfWeight = 1 << (kBits - kWeightBits - 1);  // rounds weights to the nearest
  static constexpr int kUnusedBits = 2 * kWeightBits - kPatchGrayBits;
  static constexpr int kHalfGray = 1 << (kUnusedBits - 1);  // rounds gray levels

  static std::int64_t Fixed(double value) { return std::llround(value * (1 << kBits)); }
  static int Weight(std::int64_t coordinate) {
    return static_cast<int>(coordinate >> (kBits - kWeightBits)) & ((1 << kWeightBits) - 1);
  }

  const cv::Mat& image_;
  std::int64_t x_ = 0;
  std::int64_t y_ = 0;
  std::int64_t dx_;
  std::int64_t dy_;
};

// The patch as the current image should show it, less the gray level of its middle, and how it changes with position.
// Rows are padded to whole blocks with zeros.
struct Template {
  int side = 0;
  int width = 0;            // of a padded row
  std::int16_t middle = 0;  // gray level of the middle pixel
  std::array<std::int16_t, kMostSide * kMostWidth> value;
  std::array<std::int16_t, kMostSide * kMostWidth> by_x;  // per two pixels
  std::array<std::int16_t, kMostSide * kMostWidth> by_y;
  std::array<std::int16_t, kMostWidth> in_patch;  // of one row: all bits set, in the padding none
};

// Gray levels of a patch with one more pixel all around, and the zeros that a padded row of gradients reads besides.
constexpr int kMostWarpedWidth = kMostWidth + kWideBlock;
using WarpedPatch = std::array<std::int16_t, (kMostSide + 2) * kMostWarpedWidth>;

// False where the patch leaves the image.
bool WarpPatch(int half, const cv::Mat& reference, const Eigen::Vector2d& pixel,
               const Eigen::Matrix2d& reference_from_current, int sampled, WarpedPatch& gray) {
  const int side = 2 * half + 3;
  const Eigen::Vector2d start = pixel - (half + 1) * (reference_from_current.col(0) + reference_from_current.col(1));
  const auto inside = [&](int margin) {
    // Rounding to fixed point must not leave the image either.
    constexpr double kRounding = 0.01;
    for (const int row : {0, side - 1})
      for (const int column : {0, side - 1}) {
        const Eigen::Vector2d at = start + column * reference_from_current.col(0) + row * reference_from_current.col(1);
        if (!(at.x() >= kRounding && at.y() >= kRounding && at.x() < reference.cols - 1 - margin - kRounding &&
              at.y() < reference.rows - 1 - kRounding))
          return false;
      }
    return true;
  };
  if (!inside(0)) return false;
  LineSampler sampler(reference, reference_from_current.col(0));
#if TURNSCALE_WITH_AVX2
  const bool wide = HasAvx2() && LineSampler::IsSmall(reference) && inside(kWideReach);
#endif
  for (int row = 0; row < side; ++row) {
    sampler.StartAt(start + row * reference_from_current.col(1));
    std::int16_t* of_row = &gray[row * sampled];
    std::fill(of_row + side, of_row + sampled, std::int16_t{0});
#if TURNSCALE_WITH_AVX2
    if (wide) {
      sampler.NextWide(side, of_row);
      continue;
    }
#endif
    for (int column = 0; column < side; ++column) of_row[column] = sampler.Next();
  }
  return true;
}

void TakeGradients(int half, int sampled, const WarpedPatch& gray, Template& patch) {
  patch.side = 2 * half + 1;
  patch.width = (patch.side + kWideBlock - 1) / kWideBlock * kWideBlock;
  // Sums of squares stay small where a bright patch has little contrast.
  patch.middle = gray[(half + 1) * sampled + half + 1];
  for (int column = 0; column < patch.width; ++column) patch.in_patch[column] = column < patch.side ? -1 : 0;
  const cv::v_int16x8 middle = cv::v_setall_s16(patch.middle);
  for (int row = 0; row < patch.side; ++row)
    for (int column = 0; column < patch.width; column += kPixelGroup) {
      const std::int16_t* centre = &gray[(row + 1) * sampled + column + 1];
      const int at = row * patch.width + column;
      const cv::v_int16x8 inside = cv::v_load(&patch.in_patch[column]);
      cv::v_store(&patch.value[at], inside & (cv::v_load(centre) - middle));
      cv::v_store(&patch.by_x[at], inside & (cv::v_load(centre + 1) - cv::v_load(centre - 1)));
      cv::v_store(&patch.by_y[at], inside & (cv::v_load(centre + sampled) - cv::v_load(centre - sampled)));
    }
}

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

// Sums of an image's gray levels, less the template's middle, times what is named.
struct ImageSums {
  double by_x = 0, by_y = 0, value = 0, one = 0, gray = 0;
};

void AddBlock(const Template& patch, const PatchInterpolation& interpolation, const Block& block, ImageSums& sums) {
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

// Sums of products of the template's gradients and values, and of 1.
struct TemplateSums {
  double xx = 0, xy = 0, yy = 0, xv = 0, yv = 0, vv = 0, x = 0, y = 0, v = 0;
};

void AddBlock(const Template& patch, const Block& block, TemplateSums& sums) {
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

TURNSCALE_AVX2 void AddWideBlock(const Template& patch, const PatchInterpolation& interpolation, const Block& block,
                                 ImageSums& sums) {
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

TURNSCALE_AVX2 void AddWideBlock(const Template& patch, const Block& block, TemplateSums& sums) {
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
void ForEachBlock(const Template& patch, int columns, const Add& add) {
  for (int row = 0; row < patch.side; row += kSummedRows)
    for (int column = 0; column < patch.width; column += columns)
      add(Block{column, row, std::min(row + kSummedRows, patch.side)});
}

TemplateSums SumsOf(const Template& patch) {
  TemplateSums sums;
#if TURNSCALE_WITH_AVX2
  if (HasAvx2()) {
    ForEachBlock(patch, kWideBlock, [&](const Block& block) { AddWideBlock(patch, block, sums); });
    return sums;
  }
#endif
  ForEachBlock(patch, kPixelGroup, [&](const Block& block) { AddBlock(patch, block, sums); });
  return sums;
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
  static constexpr std::ptrdiff_t kStep = kMostWidth + kWideBlock;

  std::array<uchar, (kMostSide + 1) * kStep> copy_;
  const uchar* pixels_;
  std::ptrdiff_t step_;
};

// (x, y) is the top left pixel of the patch.
ImageSums SumsOf(const Template& patch, const cv::Mat& image, float x, float y) {
  const PatchView view(image, static_cast<int>(y), static_cast<int>(x), patch.side + 1, patch.width);
  const PatchInterpolation interpolation(view.corner(), view.step(), x, y);
  ImageSums sums;
#if TURNSCALE_WITH_AVX2
  if (HasAvx2()) {
    ForEachBlock(patch, kWideBlock, [&](const Block& block) { AddWideBlock(patch, interpolation, block, sums); });
    return sums;
  }
#endif
  ForEachBlock(patch, kPixelGroup, [&](const Block& block) { AddBlock(patch, interpolation, block, sums); });
  return sums;
}

// Least squares for x, y (in two pixels), gain and offset of the brightness.
class Alignment {
 public:
  explicit Alignment(const Template& patch) : sums_(SumsOf(patch)), pixels_(patch.side * patch.side) {
    const TemplateSums& s = sums_;
    const Eigen::Matrix4d normal_matrix = (Eigen::Matrix4d() << s.xx, s.xy, s.xv, s.x,  //
                                           s.xy, s.yy, s.yv, s.y,                       //
                                           s.xv, s.yv, s.vv, s.v,                       //
                                           s.x, s.y, s.v, pixels_)
                                              .finished();
    inverse_ = normal_matrix.inverse();
  }

  // Sum of squared deviations from the mean.
  double Variance() const { return sums_.vv - sums_.v * sums_.v / pixels_; }

  // What the difference of the image and the template, of this gain and offset, adds to the unknowns.
  Eigen::Vector4d Step(const ImageSums& image, double gain, double offset) const {
    return inverse_ * Eigen::Vector4d(image.by_x - gain * sums_.xv - offset * sums_.x,
                                      image.by_y - gain * sums_.yv - offset * sums_.y,
                                      image.value - gain * sums_.vv - offset * sums_.v,
                                      image.one - gain * sums_.v - offset * pixels_);
  }

  // Sum of the squares of that difference.
  double Squared(const ImageSums& image, double gain, double offset) const {
    return image.gray - 2 * gain * image.value - 2 * offset * image.one + gain * gain * sums_.vv +
           2 * gain * offset * sums_.v + offset * offset * pixels_;
  }

 private:
  TemplateSums sums_;
  double pixels_;
  Eigen::Matrix4d inverse_;
};

}  // namespace

void PatchAlignmentOptions::Check() const {
  if (half_size < 2 || half_size > kMostHalf) throw InputError("alignment.half_size: has to be in 2...20 pixels");
  if (max_iterations < 1) throw InputError("alignment.max_iterations: has to be at least 1");
  if (!(tolerance > 0)) throw InputError("alignment.tolerance: has to be positive");
  if (!(max_distance > 0)) throw InputError("alignment.max_distance: has to be positive");
  if (!(min_correlation < 1)) throw InputError("alignment.min_correlation: has to be below 1");
}

std::optional<Eigen::Vector2d> AlignPatch(const PatchAlignmentOptions& options, const cv::Mat& reference,
                                          const Eigen::Vector2d& reference_pixel,
                                          const Eigen::Matrix2d& reference_from_current, const cv::Mat& current,
                                          const Eigen::Vector2d& guess) {
  const int half = options.half_size;
  const int sampled = (2 * half + 1 + kWideBlock - 1) / kWideBlock * kWideBlock + kPixelGroup;
  WarpedPatch gray;
  if (!WarpPatch(half, reference, reference_pixel, reference_from_current, sampled, gray)) return std::nullopt;
  Template patch;
  TakeGradients(half, sampled, gray, patch);
  const Alignment alignment(patch);
  const double variance = alignment.Variance();
  if (!(variance > kLeastVariance)) return std::nullopt;

  Eigen::Vector2d pixel = guess;
  Eigen::Vector2d shift = Eigen::Vector2d::Constant(HUGE_VAL);
  double gain = 1;
  double offset = 0;
  double last_squared = HUGE_VAL;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const float x = static_cast<float>(pixel.x());
    const float y = static_cast<float>(pixel.y());
    const float reach = static_cast<float>(half);
    if (!Inside(current, x - reach, y - reach) || !Inside(current, x + reach, y + reach)) return std::nullopt;
    const ImageSums image = SumsOf(patch, current, x - reach, y - reach);
    const double squared = alignment.Squared(image, gain, offset);
    const bool gains_nothing = squared >= last_squared && shift.norm() <= kRoundingSteps * options.tolerance;
    const Eigen::Vector4d step = alignment.Step(image, gain, offset);
    if (!step.allFinite()) return std::nullopt;
    // The template's gradients stand for the image's, up to the gain.
    shift = -2 * step.head<2>() / std::max(0.1, gain);
    pixel += shift;
    gain += step[2];
    offset += step[3];
    if ((pixel - guess).norm() > options.max_distance) return std::nullopt;
    last_squared = squared;
    if (shift.norm() > options.tolerance && !gains_nothing) continue;
    // Share of the patch's variance that the image explains is the square of the correlation.
    const double explained = 1.0 - squared / std::max(1e-6, gain * gain * variance);
    if (gain < 0.2 || explained < options.min_correlation * options.min_correlation) return std::nullopt;
    return pixel;
  }
  return std::nullopt;
}

void PrefetchPatch(const PatchAlignmentOptions& options, const cv::Mat& reference,
                   const Eigen::Vector2d& reference_pixel) {
  const int reach = options.half_size + 2;
  const cv::Rect image(0, 0, reference.cols, reference.rows);
  const cv::Rect patch = image & cv::Rect(static_cast<int>(reference_pixel.x()) - reach,
                                          static_cast<int>(reference_pixel.y()) - reach, 2 * reach + 1, 2 * reach + 1);
  for (int row = patch.y; row < patch.y + patch.height; ++row) {
    const uchar* pixels = reference.ptr<uchar>(row) + patch.x;
    __builtin_prefetch(pixels);
    __builtin_prefetch(pixels + patch.width - 1);
  }
}

}  // namespace turnscale

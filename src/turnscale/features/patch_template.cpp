// SPDX-License-Identifier: MIT
#include "turnscale/features/patch_template.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <opencv2/core/hal/intrin.hpp>

#include "turnscale/features/avx2.h"

namespace turnscale {
namespace {

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

// Gray levels of a patch with one more pixel all around, and the zeros that a padded row of gradients reads besides.
constexpr int kMostWarpedWidth = kMostPatchWidth + kPatchBlock;
using WarpedPatch = std::array<std::int16_t, (kMostPatchSide + 2) * kMostWarpedWidth>;

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

void TakeGradients(int half, int sampled, const WarpedPatch& gray, PatchTemplate& patch) {
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

}  // namespace

bool MakeTemplate(int half, const cv::Mat& reference, const Eigen::Vector2d& pixel,
                  const Eigen::Matrix2d& reference_from_current, PatchTemplate& patch) {
  patch.side = 2 * half + 1;
  patch.width = (patch.side + kPatchBlock - 1) / kPatchBlock * kPatchBlock;
  const int sampled = patch.width + kPixelGroup;
  WarpedPatch gray;
  if (!WarpPatch(half, reference, pixel, reference_from_current, sampled, gray)) return false;
  TakeGradients(half, sampled, gray, patch);
  return true;
}

}  // namespace turnscale

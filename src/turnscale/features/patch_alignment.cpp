// SPDX-License-Identifier: MIT
#include "turnscale/features/patch_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <Eigen/Cholesky>
#include <opencv2/core/hal/intrin.hpp>

#include "turnscale/base/error.h"
#include "turnscale/features/avx2.h"

namespace turnscale {
namespace {

// Sum over the patch, gray levels squared: what is flatter looks like anything.
constexpr float kLeastVariance = 1;

// Rows of a patch are processed in groups of this many pixels. Sums are kept per lane and added in a fixed order.
constexpr int kLanes = cv::v_float32x4::nlanes;
constexpr int kMostHalf = 20;
constexpr int kMostWidth = (2 * kMostHalf + kLanes) / kLanes * kLanes;

bool Inside(const cv::Mat& image, float x, float y) {
  return x >= 0 && y >= 0 && x < static_cast<float>(image.cols - 1) && y < static_cast<float>(image.rows - 1);
}

cv::v_float32x4 LoadGray(const uchar* pixels) {
  std::uint32_t four = 0;
  std::memcpy(&four, pixels, sizeof four);  // v_load_expand_q takes them to be aligned
  cv::v_uint16x8 low;
  cv::v_uint16x8 high;
  cv::v_expand(cv::v_reinterpret_as_u8(cv::v_setall_u32(four)), low, high);
  cv::v_uint32x4 first;
  cv::v_uint32x4 second;
  cv::v_expand(low, first, second);
  return cv::v_cvt_f32(cv::v_reinterpret_as_s32(first));
}

float Sum(const cv::v_float32x4& lanes) {
  std::array<float, kLanes> values;
  cv::v_store(values.data(), lanes);
  return (values[0] + values[1]) + (values[2] + values[3]);
}

// Samples that are computed together. A gather reads four pixels where two are needed: so many beyond them.
constexpr int kWide = 8;
constexpr int kWideReach = 2;

// Gray levels at points on a line, in fixed point: coordinates in 1/65536 pixel, weights in 1/1024.
class LineSampler {
 public:
  LineSampler(const cv::Mat& image, const Eigen::Vector2d& step)
      : image_(image), dx_(Fixed(step.x())), dy_(Fixed(step.y())) {}

  void StartAt(const Eigen::Vector2d& point) {
    x_ = Fixed(point.x()) + kHalfWeight;
    y_ = Fixed(point.y()) + kHalfWeight;
  }

  float Next() {
    const uchar* top = image_.data + static_cast<size_t>(y_ >> kBits) * image_.step + static_cast<size_t>(x_ >> kBits);
    const uchar* bottom = top + image_.step;
    const int right = Weight(x_);
    const int down = Weight(y_);
    const int above = (top[0] << kWeightBits) + right * (top[1] - top[0]);
    const int below = (bottom[0] << kWeightBits) + right * (bottom[1] - bottom[0]);
    x_ += dx_;
    y_ += dy_;
    return static_cast<float>((above << kWeightBits) + down * (below - above)) / (1 << (2 * kWeightBits));
  }

#if TURNSCALE_WITH_AVX2
  // Whether coordinates and addresses in this image fit in 32 bits.
  static bool IsSmall(const cv::Mat& image) {
    constexpr int kMost = 1 << (31 - kBits);
    return image.cols < kMost && image.rows < kMost && image.step * image.rows < size_t{1} << 31;
  }

  // The next `count` gray levels, eight at a time, and up to seven copies of the last one. Reads up to kWideReach
  // pixels to the right of what Next reads.
  TURNSCALE_AVX2 void NextWide(int count, float* values) const {
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
      // A power of two, so that the product has the bits of the quotient.
      constexpr float kUnit = 1.0F / (1 << (2 * kWeightBits));
      _mm256_storeu_ps(values + first, _mm256_mul_ps(_mm256_cvtepi32_ps(sum), _mm256_set1_ps(kUnit)));
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
// Rows are padded to whole groups with zeros.
struct Template {
  int side = 0;
  int width = 0;  // of a padded row
  std::array<float, (2 * kMostHalf + 1) * kMostWidth> value;
  std::array<float, (2 * kMostHalf + 1) * kMostWidth> by_x;
  std::array<float, (2 * kMostHalf + 1) * kMostWidth> by_y;
  std::array<float, kMostWidth> in_patch;  // of one row: 1, in the padding 0
  Eigen::Matrix4f normal_matrix;           // of x, y, gain, offset
  float middle = 0;                        // gray level of the middle pixel
  float variance = 0;                      // sum of squared deviations from the mean
};

// Samples the patch with one more pixel all around for the gradients. False where it leaves the image.
bool SampleTemplate(int half, const cv::Mat& reference, const Eigen::Vector2d& pixel,
                    const Eigen::Matrix2d& reference_from_current, Template& patch) {
  constexpr int kMostSide = 2 * kMostHalf + 3;
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
  std::array<float, kMostSide * kMostSide + kWide> values;
  LineSampler sampler(reference, reference_from_current.col(0));
#if TURNSCALE_WITH_AVX2
  const bool wide = HasAvx2() && LineSampler::IsSmall(reference) && inside(kWideReach);
#endif
  for (int row = 0; row < side; ++row) {
    sampler.StartAt(start + row * reference_from_current.col(1));
    float* of_row = &values[row * side];
#if TURNSCALE_WITH_AVX2
    if (wide) {
      sampler.NextWide(side, of_row);
      continue;
    }
#endif
    for (int column = 0; column < side; ++column) of_row[column] = sampler.Next();
  }
  // Sums of squares keep their digits where a bright patch has little contrast.
  patch.middle = values[(half + 1) * side + half + 1];
  patch.side = side - 2;
  patch.width = (patch.side + kLanes - 1) / kLanes * kLanes;
  for (int column = 0; column < patch.width; ++column) patch.in_patch[column] = column < patch.side ? 1.0F : 0.0F;
  for (int row = 0; row < patch.side; ++row) {
    const float* centre = &values[(row + 1) * side + 1];
    float* value = &patch.value[row * patch.width];
    float* by_x = &patch.by_x[row * patch.width];
    float* by_y = &patch.by_y[row * patch.width];
    for (int column = 0; column < patch.side; ++column) {
      value[column] = centre[column] - patch.middle;
      by_x[column] = 0.5F * (centre[column + 1] - centre[column - 1]);
      by_y[column] = 0.5F * (centre[column + side] - centre[column - side]);
    }
    for (int column = patch.side; column < patch.width; ++column) value[column] = by_x[column] = by_y[column] = 0;
  }
  return true;
}

void BuildNormalMatrix(Template& patch) {
  cv::v_float32x4 xx = cv::v_setzero_f32();
  cv::v_float32x4 xy = xx, yy = xx, xv = xx, yv = xx, vv = xx, x = xx, y = xx, v = xx;
  for (int i = 0; i < patch.side * patch.width; i += kLanes) {
    const cv::v_float32x4 by_x = cv::v_load(&patch.by_x[i]);
    const cv::v_float32x4 by_y = cv::v_load(&patch.by_y[i]);
    const cv::v_float32x4 value = cv::v_load(&patch.value[i]);
    xx += by_x * by_x;
    xy += by_x * by_y;
    yy += by_y * by_y;
    xv += by_x * value;
    yv += by_y * value;
    vv += value * value;
    x += by_x;
    y += by_y;
    v += value;
  }
  const float pixels = static_cast<float>(patch.side * patch.side);
  Eigen::Matrix4f& N = patch.normal_matrix;
  N << Sum(xx), Sum(xy), Sum(xv), Sum(x),  //
      0, Sum(yy), Sum(yv), Sum(y),         //
      0, 0, Sum(vv), Sum(v),               //
      0, 0, 0, pixels;
  N.triangularView<Eigen::StrictlyLower>() = N.transpose();
  patch.variance = N(2, 2) - N(2, 3) * N(2, 3) / pixels;
}

// Difference of the image and the template at a place: its sums times the template's derivatives by x, y, gain and
// offset, and squared.
struct Residual {
  Eigen::Vector4f gradient;
  float squared = 0;
};

// The image around the patch; copied where reading whole groups of pixels would leave the image.
class PatchView {
 public:
  PatchView(const cv::Mat& image, int row, int column, int rows, int width)
      : pixels_(image.ptr<uchar>(row) + column), step_(image.step) {
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

  const uchar* Row(int row) const { return pixels_ + static_cast<size_t>(row) * step_; }

 private:
  static constexpr size_t kStep = kMostWidth + kLanes;

  std::array<uchar, (2 * kMostHalf + 2) * kStep> copy_;
  const uchar* pixels_;
  size_t step_;
};

// (x, y) is the top left pixel of the patch.
Residual Compare(const Template& patch, const cv::Mat& image, float x, float y, float gain, float offset) {
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const PatchView view(image, row, column, patch.side + 1, patch.width);
  const cv::v_float32x4 right = cv::v_setall_f32(x - static_cast<float>(column));
  const cv::v_float32x4 down = cv::v_setall_f32(y - static_cast<float>(row));
  const cv::v_float32x4 gains = cv::v_setall_f32(gain);
  const cv::v_float32x4 offsets = cv::v_setall_f32(offset);
  cv::v_float32x4 sum = cv::v_setzero_f32();
  cv::v_float32x4 sum_x = sum, sum_y = sum, sum_value = sum, sum_squared = sum;
  for (int k = 0; k < patch.width; k += kLanes) {
    const auto interpolated = [&](int i) {
      const uchar* pixels = view.Row(i) + k;
      const cv::v_float32x4 left = LoadGray(pixels);
      return left + right * (LoadGray(pixels + 1) - left);
    };
    const cv::v_float32x4 in_patch = cv::v_load(&patch.in_patch[k]);
    cv::v_float32x4 above = interpolated(0);
    for (int i = 0; i < patch.side; ++i) {
      const cv::v_float32x4 below = interpolated(i + 1);
      const int at = i * patch.width + k;
      const cv::v_float32x4 value = cv::v_load(&patch.value[at]);
      const cv::v_float32x4 residual = in_patch * (above + down * (below - above) - gains * value - offsets);
      sum_x += residual * cv::v_load(&patch.by_x[at]);
      sum_y += residual * cv::v_load(&patch.by_y[at]);
      sum_value += residual * value;
      sum += residual;
      sum_squared += residual * residual;
      above = below;
    }
  }
  return {{Sum(sum_x), Sum(sum_y), Sum(sum_value), Sum(sum)}, Sum(sum_squared)};
}

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
  Template patch;
  if (!SampleTemplate(half, reference, reference_pixel, reference_from_current, patch)) return std::nullopt;
  BuildNormalMatrix(patch);
  if (!(patch.variance > kLeastVariance)) return std::nullopt;
  const Eigen::LDLT<Eigen::Matrix4f> factor(patch.normal_matrix);

  Eigen::Vector2d pixel = guess;
  float gain = 1;
  float offset = patch.middle;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const float x = static_cast<float>(pixel.x());
    const float y = static_cast<float>(pixel.y());
    const float reach = static_cast<float>(half);
    if (!Inside(current, x - reach, y - reach) || !Inside(current, x + reach, y + reach)) return std::nullopt;
    const auto [gradient, squared] = Compare(patch, current, x - reach, y - reach, gain, offset);
    const Eigen::Vector4f step = factor.solve(gradient);
    if (!step.allFinite()) return std::nullopt;
    // The template's gradients stand for the image's, up to the gain.
    const Eigen::Vector2d shift = -step.head<2>().cast<double>() / std::max(0.1F, gain);
    pixel += shift;
    gain += step[2];
    offset += step[3];
    if ((pixel - guess).norm() > options.max_distance) return std::nullopt;
    if (shift.norm() > options.tolerance) continue;
    // Share of the patch's variance that the image explains is the square of the correlation.
    const double explained = 1.0 - squared / std::max(1e-6F, gain * gain * patch.variance);
    if (gain < 0.2F || explained < options.min_correlation * options.min_correlation) return std::nullopt;
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

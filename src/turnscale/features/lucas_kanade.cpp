// SPDX-License-Identifier: MIT
#include "turnscale/features/lucas_kanade.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <opencv2/core/hal/intrin.hpp>

namespace turnscale {
namespace {

// Pixels are processed in groups of this many, as 16-bit integers in 1/32 of a gray level.
constexpr int kGroup = cv::v_int16x8::nlanes;
constexpr int kGrayBits = 5;
constexpr float kGrayLevel = 1 << kGrayBits;

// Texture below which a patch is flat, gray levels squared.
constexpr float kLeastTexture = 0.1F;

constexpr int kMostFlowWidth = (kMostFlowWindow + kGroup - 1) / kGroup * kGroup;

// Gradients are taken across one more pixel on each side.
constexpr int kMostSampledRows = kMostFlowWindow + 2;
constexpr int kMostSampledWidth = kMostFlowWidth + kGroup;

cv::v_int16x8 LoadPixels(const uchar* pixels) { return cv::v_reinterpret_as_s16(cv::v_load_expand(pixels)); }

// A patch at a fraction of a pixel: bilinear interpolation with weights in 1/32768.
class Interpolation {
 public:
  // (x, y) is the top left pixel of the patch.
  Interpolation(const cv::Mat& image, float x, float y)
      : step_(static_cast<std::ptrdiff_t>(image.step)),
        corner_(image.data + std::ptrdiff_t{cvFloor(y)} * step_ + cvFloor(x)),
        right_(Weight(x - std::floor(x))),
        down_(Weight(y - std::floor(y))) {}

  // Between two columns of a row, a group from `column` on.
  cv::v_int16x8 InRow(int row, int column) const {
    const uchar* pixels = corner_ + row * step_ + column;
    const cv::v_int16x8 left = LoadPixels(pixels);
    return (left << kGrayBits) + cv::v_mul_hi((LoadPixels(pixels + 1) - left) << (kGrayBits + 1), right_);
  }

  cv::v_int16x8 Between(const cv::v_int16x8& above, const cv::v_int16x8& below) const {
    return above + cv::v_mul_hi((below - above) << 1, down_);
  }

 private:
  static cv::v_int16x8 Weight(float fraction) {
    return cv::v_setall_s16(static_cast<std::int16_t>(std::min(32767.0F, fraction * 32768.0F)));
  }

  std::ptrdiff_t step_;
  const uchar* corner_;
  cv::v_int16x8 right_;
  cv::v_int16x8 down_;
};

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

// (x, y) is the top left pixel of the patch.
void CutOut(const cv::Mat& image, float x, float y, int window, Patch& patch) {
  patch.width = (window + kGroup - 1) / kGroup * kGroup;
  const int sampled = patch.width + kGroup;
  std::array<std::int16_t, kMostSampledRows * kMostSampledWidth> gray;
  const Interpolation interpolation(image, x - 1, y - 1);
  for (int column = 0; column < sampled; column += kGroup) {
    cv::v_int16x8 above = interpolation.InRow(0, column);
    for (int row = 0; row < window + 2; ++row) {
      const cv::v_int16x8 below = interpolation.InRow(row + 1, column);
      cv::v_store(&gray[row * sampled + column], interpolation.Between(above, below));
      above = below;
    }
  }
  const auto is_inside = [](float at, int size) { return at >= 0 && at <= static_cast<float>(size - 1); };
  std::array<std::int16_t, kMostFlowWidth> counts{};
  for (int column = 0; column < window; ++column)
    counts[column] = is_inside(x + static_cast<float>(column), image.cols) ? -1 : 0;
  PatchSum xx;
  PatchSum xy;
  PatchSum yy;
  for (int row = 0; row < window; ++row) {
    const bool row_counts = is_inside(y + static_cast<float>(row), image.rows);
    cv::v_int32x4 row_xx = cv::v_setzero_s32();
    cv::v_int32x4 row_xy = row_xx;
    cv::v_int32x4 row_yy = row_xx;
    for (int column = 0; column < patch.width; column += kGroup) {
      const std::int16_t* centre = &gray[(row + 1) * sampled + column + 1];
      const cv::v_int16x8 inside = row_counts ? cv::v_load(&counts[column]) : cv::v_setzero_s16();
      const cv::v_int16x8 by_x = inside & ((cv::v_load(centre + 1) - cv::v_load(centre - 1)) >> 1);
      const cv::v_int16x8 by_y = inside & ((cv::v_load(centre + sampled) - cv::v_load(centre - sampled)) >> 1);
      const int at = row * patch.width + column;
      cv::v_store(&patch.gray[at], cv::v_load(centre));
      cv::v_store(&patch.by_x[at], by_x);
      cv::v_store(&patch.by_y[at], by_y);
      row_xx += cv::v_dotprod(by_x, by_x);
      row_xy += cv::v_dotprod(by_x, by_y);
      row_yy += cv::v_dotprod(by_y, by_y);
    }
    xx.Add(row_xx);
    xy.Add(row_xy);
    yy.Add(row_yy);
  }
  patch.xx = xx.Total();
  patch.xy = xy.Total();
  patch.yy = yy.Total();
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

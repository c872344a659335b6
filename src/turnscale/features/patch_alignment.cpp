// SPDX-License-Identifier: MIT
#include "turnscale/features/patch_alignment.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "turnscale/base/error.h"
#include "turnscale/features/patch_sums.h"
#include "turnscale/features/patch_template.h"

namespace turnscale {
namespace {

// Sum over the patch, gray levels squared: what is flatter looks like anything.
constexpr double kLeastVariance = 1 << (2 * kPatchGrayBits);
// Where contrast is low, the rounding of gray levels moves the minimum: steps of up to so many times the tolerance may
// no longer reduce the difference.
constexpr double kRoundingSteps = 5;
bool Inside(const cv::Mat& image, float x, float y) {
  return x >= 0 && y >= 0 && x < static_cast<float>(image.cols - 1) && y < static_cast<float>(image.rows - 1);
}
// Least squares for x, y (in two pixels), gain and offset of the brightness.
class Alignment {
 public:
  explicit Alignment(const PatchTemplate& patch) : sums_(SumsOf(patch)), pixels_(patch.side * patch.side) {
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

  struct Step {
    Eigen::Vector4d change;  // of the unknowns
    double gained = 0;       // by which it reduces the sum of squares
  };

  // What the difference of the image and the template, of this gain and offset, adds to the unknowns.
  Step StepFrom(const ImageSums& image, double gain, double offset) const {
    const Eigen::Vector4d right(
        image.by_x - gain * sums_.xv - offset * sums_.x, image.by_y - gain * sums_.yv - offset * sums_.y,
        image.value - gain * sums_.vv - offset * sums_.v, image.one - gain * sums_.v - offset * pixels_);
    const Eigen::Vector4d change = inverse_ * right;
    return {change, change.dot(right)};
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
  if (half_size < 2 || half_size > kMostPatchHalf) throw InputError("half_size: has to be in 2...20 pixels");
  if (max_iterations < 1) throw InputError("max_iterations: has to be at least 1");
  if (!(tolerance > 0)) throw InputError("tolerance: has to be positive");
  if (!(max_distance > 0)) throw InputError("max_distance: has to be positive");
  if (!(min_correlation < 1)) throw InputError("min_correlation: has to be below 1");
}

std::optional<Eigen::Vector2d> AlignPatch(const PatchAlignmentOptions& options, const cv::Mat& reference,
                                          const Eigen::Vector2d& reference_pixel,
                                          const Eigen::Matrix2d& reference_from_current, const cv::Mat& current,
                                          const Eigen::Vector2d& guess) {
  const int half = options.half_size;
  PatchTemplate patch;
  if (!MakeTemplate(half, reference, reference_pixel, reference_from_current, patch)) return std::nullopt;
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
    const Alignment::Step step = alignment.StepFrom(image, gain, offset);
    if (!step.change.allFinite()) return std::nullopt;
    // The template's gradients stand for the image's, up to the gain.
    shift = -2 * step.change.head<2>() / std::max(0.1, gain);
    pixel += shift;
    gain += step.change[2];
    offset += step.change[3];
    if ((pixel - guess).norm() > options.max_distance) return std::nullopt;
    last_squared = squared;
    if (shift.norm() > options.tolerance && !gains_nothing) continue;
    // Share of the patch's variance that the image explains is the square of the correlation.
    const double explained = 1.0 - (squared - step.gained) / std::max(1e-6, gain * gain * variance);
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

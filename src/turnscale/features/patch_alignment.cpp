// SPDX-License-Identifier: MIT
#include "turnscale/features/patch_alignment.h"

#include <algorithm>
#include <vector>

#include <Eigen/Cholesky>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

// Sum over the patch, gray levels squared: what is flatter looks like anything.
constexpr float kLeastVariance = 1;

bool Inside(const cv::Mat& image, float x, float y) {
  return x >= 0 && y >= 0 && x < static_cast<float>(image.cols - 1) && y < static_cast<float>(image.rows - 1);
}

// Bilinear weights of the four pixels around a point; the same for all points that are whole pixels away.
struct Bilinear {
  int column;
  int row;
  float top_left, top_right, bottom_left, bottom_right;

  Bilinear(float x, float y) : column(static_cast<int>(x)), row(static_cast<int>(y)) {
    const float right = x - static_cast<float>(column);
    const float down = y - static_cast<float>(row);
    bottom_right = right * down;
    bottom_left = down - bottom_right;
    top_right = right - bottom_right;
    top_left = 1 - right - bottom_left;
  }

  float operator()(const uchar* top, const uchar* bottom) const {
    return top_left * static_cast<float>(top[0]) + top_right * static_cast<float>(top[1]) +
           bottom_left * static_cast<float>(bottom[0]) + bottom_right * static_cast<float>(bottom[1]);
  }
};

// (x, y) is Inside.
float Sample(const cv::Mat& image, float x, float y) {
  const Bilinear weights(x, y);
  return weights(image.ptr<uchar>(weights.row) + weights.column, image.ptr<uchar>(weights.row + 1) + weights.column);
}

// The patch as the current image should show it, and how it changes with position, gain and offset.
struct Template {
  std::vector<Eigen::Vector4f> jacobian;  // by x, by y, by gain (the value itself), by offset (one)
  Eigen::Matrix4f normal_matrix = Eigen::Matrix4f::Zero();
  float variance = 0;  // sum of squared deviations from the mean

  float value(size_t i) const { return jacobian[i][2]; }
};

std::optional<Template> MakeTemplate(int half, const cv::Mat& reference, const Eigen::Vector2d& pixel,
                                     const Eigen::Matrix2d& reference_from_current) {
  const int side = 2 * half + 3;  // one more all around for the gradients
  const Eigen::Matrix2f axes = reference_from_current.cast<float>();
  const auto at = [&, center = Eigen::Vector2f(pixel.cast<float>())](int row, int column) -> Eigen::Vector2f {
    return center + static_cast<float>(column - half - 1) * axes.col(0) +
           static_cast<float>(row - half - 1) * axes.col(1);
  };
  for (const Eigen::Vector2f& corner : {at(0, 0), at(0, side - 1), at(side - 1, 0), at(side - 1, side - 1)})
    if (!Inside(reference, corner.x(), corner.y())) return std::nullopt;
  std::vector<float> values(static_cast<size_t>(side) * side);
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const Eigen::Vector2f sample = at(row, column);
      values[static_cast<size_t>(row) * side + column] = Sample(reference, sample.x(), sample.y());
    }
  Template patch;
  patch.jacobian.reserve(values.size());
  float sum = 0;
  float sum_of_squares = 0;
  for (int row = 1; row < side - 1; ++row)
    for (int column = 1; column < side - 1; ++column) {
      const float* value = &values[static_cast<size_t>(row) * side + column];
      patch.jacobian.emplace_back(0.5F * (value[1] - value[-1]), 0.5F * (value[side] - value[-side]), value[0], 1.0F);
      patch.normal_matrix += patch.jacobian.back() * patch.jacobian.back().transpose();
      sum += value[0];
      sum_of_squares += value[0] * value[0];
    }
  patch.variance = sum_of_squares - sum * sum / static_cast<float>(patch.jacobian.size());
  return patch;
}

}  // namespace

void PatchAlignmentOptions::Check() const {
  if (half_size < 2 || half_size > 20) throw InputError("alignment.half_size: has to be in 2...20 pixels");
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
  const std::optional<Template> patch = MakeTemplate(half, reference, reference_pixel, reference_from_current);
  if (!patch || !(patch->variance > kLeastVariance)) return std::nullopt;
  const Eigen::LDLT<Eigen::Matrix4f> factor(patch->normal_matrix);

  Eigen::Vector2d pixel = guess;
  float gain = 1;
  float offset = 0;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    const float x = static_cast<float>(pixel.x());
    const float y = static_cast<float>(pixel.y());
    const float reach = static_cast<float>(half);
    if (!Inside(current, x - reach, y - reach) || !Inside(current, x + reach, y + reach)) return std::nullopt;
    Eigen::Vector4f gradient = Eigen::Vector4f::Zero();
    float squared = 0;
    size_t i = 0;
    const Bilinear weights(x - reach, y - reach);
    for (int row = 0; row <= 2 * half; ++row) {
      const uchar* top = current.ptr<uchar>(weights.row + row) + weights.column;
      const uchar* bottom = current.ptr<uchar>(weights.row + row + 1) + weights.column;
      for (int column = 0; column <= 2 * half; ++column, ++i) {
        const float residual = weights(top + column, bottom + column) - gain * patch->value(i) - offset;
        gradient += residual * patch->jacobian[i];
        squared += residual * residual;
      }
    }
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
    const double explained = 1.0 - squared / std::max(1e-6F, gain * gain * patch->variance);
    if (gain < 0.2F || explained < options.min_correlation * options.min_correlation) return std::nullopt;
    return pixel;
  }
  return std::nullopt;
}

}  // namespace turnscale

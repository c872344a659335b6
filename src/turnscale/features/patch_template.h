// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "turnscale/features/gray_interpolation.h"

namespace turnscale {

/// Gray levels of a patch are integers in 1/32.
constexpr int kPatchGrayBits = 5;
using PatchInterpolation = GrayInterpolation<kPatchGrayBits>;

/// Rows are padded to whole blocks of this many pixels.
constexpr int kPatchBlock = 2 * kPixelGroup;
constexpr int kMostPatchHalf = 20;
constexpr int kMostPatchSide = 2 * kMostPatchHalf + 1;
constexpr int kMostPatchWidth = (kMostPatchSide + kPatchBlock - 1) / kPatchBlock * kPatchBlock;

/// The patch as the current image should show it, less the gray level of its middle, and how it changes with position.
/// Rows are padded to whole blocks with zeros.
struct PatchTemplate {
  int side = 0;
  int width = 0;            ///< of a padded row
  std::int16_t middle = 0;  ///< gray level of the middle pixel
  std::array<std::int16_t, kMostPatchSide * kMostPatchWidth> value;
  std::array<std::int16_t, kMostPatchSide * kMostPatchWidth> by_x;  ///< per two pixels
  std::array<std::int16_t, kMostPatchSide * kMostPatchWidth> by_y;
  std::array<std::int16_t, kMostPatchWidth> in_patch;  ///< of one row: all bits set, in the padding none
};

/// Makes the template of a square patch of 2 `half` + 1 pixels a side (`half` at most kMostPatchHalf):
/// `reference_from_current` times the offsets from its middle are offsets from `pixel` of the reference image. False
/// where that, with one more pixel all around, leaves the image.
bool MakeTemplate(int half, const cv::Mat& reference, const Eigen::Vector2d& pixel,
                  const Eigen::Matrix2d& reference_from_current, PatchTemplate& patch);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <opencv2/core.hpp>

#include "turnscale/features/patch_template.h"

namespace turnscale {

/// Sums over a patch, gray levels in 1/2^kPatchGrayBits: of those that an image shows, less the template's middle,
/// times the template's gradients, its value, 1, and themselves.
struct ImageSums {
  double by_x = 0, by_y = 0, value = 0, one = 0, gray = 0;
};

/// Sums of products of the template's gradients and values, and of 1.
struct TemplateSums {
  double xx = 0, xy = 0, yy = 0, xv = 0, yv = 0, vv = 0, x = 0, y = 0, v = 0;
};

/// Exact, with the same bits from SSE2, AVX2 and plain C++.
TemplateSums SumsOf(const PatchTemplate& patch);

/// The same. (x, y) is the top left pixel of the patch, all of which is inside of the image, and one more row and
/// column.
ImageSums SumsOf(const PatchTemplate& patch, const cv::Mat& image, float x, float y);

}  // namespace turnscale

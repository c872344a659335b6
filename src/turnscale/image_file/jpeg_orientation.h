// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// Orientation of a stored image by EXIF's numbers, 1 to 8.
constexpr int kUpright = 1;

/// Orientation that the EXIF data of a JPEG state; kUpright if the bytes are no JPEG, or state none or no valid one.
int JpegOrientation(std::span<const uint8_t> bytes);

/// The stored pixels rotated and mirrored as they are to be shown. Those of kUpright are not copied.
cv::Mat TurnedUpright(const cv::Mat& stored, int orientation);

}  // namespace turnscale

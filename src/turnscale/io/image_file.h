// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// An image as 8-bit gray, or why there is none.
struct GrayImage {
  cv::Mat gray;         ///< empty if the file is unusable
  std::string problem;  ///< "name: why"; empty if there is none
};

/// Reads an image file; colour and 16-bit become 8-bit gray, and the stored rows are taken as they are (a camera's
/// calibration knows nothing of EXIF orientation). Files that end too early are refused, not filled up.
GrayImage ReadGrayImage(const std::filesystem::path& path);

/// Any image type as 8-bit gray.
cv::Mat ToGray8(const cv::Mat& image);

/// Whether the bytes of a PNG, JPEG, BMP or binary PGM/PPM stop before the image is complete. Decoders fill such an
/// image up in silence. Other formats count as complete.
bool EndsEarly(std::span<const uint8_t> bytes);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// Reads which pixels to use: an image whose black pixels (0) are to be left out, as 8-bit gray. Throws InputError
/// where the file cannot be read, or leaves out nothing or the whole image.
cv::Mat ReadMask(const std::filesystem::path& path);

/// Throws InputError where the mask is not of the images' size.
void CheckMaskSize(const std::filesystem::path& path, const cv::Mat& mask, const cv::Size& images);

}  // namespace turnscale

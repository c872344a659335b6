// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// The PNG file of an 8-bit gray image, packed fast rather than small. The same image gives the same bytes. Throws
/// InternalError if it cannot be encoded.
std::string EncodePng(const cv::Mat& gray);

/// The JPEG file of an 8-bit gray or BGR image, of a quality from 1 to 100 as in libjpeg. It begins with a JFIF header
/// and has no comments. The same image gives the same bytes. Throws InternalError if it cannot be encoded.
std::string EncodeJpeg(const cv::Mat& image, int quality);

}  // namespace turnscale

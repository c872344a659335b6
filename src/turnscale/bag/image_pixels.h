// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include <opencv2/core/mat.hpp>

#include "turnscale/bag/messages.h"

namespace turnscale {

/// The pixels of an image message: 8-bit or 16-bit, gray or BGR (with or without alpha); a colour filter's (bayer_*)
/// are interpolated to BGR. Throws MalformedData where the message does not hold so many bytes, or
/// has an encoding that CheckEncoding refuses.
cv::Mat PixelsOf(const BagImage& image);

/// Throws InputError with the encodings that PixelsOf knows if it does not know this one. `where`: for the message.
void CheckEncoding(std::string_view encoding, const std::string& where);

/// BGR of a picture that was decoded from a compressed message whose format says that its gray values are those of a
/// colour filter ("bayer_rggb8; jpeg compressed"); other pictures as they are.
cv::Mat WithColour(const cv::Mat& picture, std::string_view format);

}  // namespace turnscale

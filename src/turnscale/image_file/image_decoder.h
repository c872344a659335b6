// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// The pixels of an image file.
struct ImagePixels {
  cv::Mat gray;         ///< 8 or 16 bit as stored; empty if the bytes are no readable image
  bool colour = false;  ///< the file has colours
  /// The file states the greatest level of its 16-bit pixels, and they are stretched from it.
  bool range_is_stated = false;
};

/// Decodes a PNG, JPEG, BMP, PBM/PGM/PPM or TIFF (without tiles, not packed as JPEG) of at most `most_pixels` pixels.
/// Levels are stretched to the range of 8 or 16 bits. Colours become gray as in cv::COLOR_BGR2GRAY (those of a JPEG by
/// its own luma); alpha and orientation are ignored. A damaged image is not decoded in part: it has no pixels. The same
/// bytes give the same pixels.
ImagePixels DecodePixels(std::span<const uint8_t> bytes, int64_t most_pixels);

}  // namespace turnscale

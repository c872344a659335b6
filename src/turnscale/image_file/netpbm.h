// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "turnscale/image_file/image_decoder.h"

namespace turnscale {

/// The header of a binary PGM or PPM.
struct NetpbmHeader {
  int channels = 1;         ///< 3 of a PPM
  int width = 0;            ///< pixels
  int height = 0;           ///< pixels
  int greatest_level = 0;   ///< up to 65535; from 256 on, levels have two bytes
  size_t pixels_begin = 0;  ///< bytes before the pixels

  bool is_deep() const { return greatest_level > 0xFF; }
  /// Bytes of the pixels.
  size_t pixels_size() const { return size_t{1} * width * height * channels * (is_deep() ? 2 : 1); }
};

/// Whether the bytes begin as a binary PGM or PPM.
bool IsBinaryNetpbm(std::span<const uint8_t> bytes);

/// The header of bytes that begin so; nothing if it is damaged or incomplete.
std::optional<NetpbmHeader> HeaderOfNetpbm(std::span<const uint8_t> bytes);

/// Decodes a binary PGM or PPM of at most `most_pixels` pixels, the pixels of the first image if there are several.
/// libavcodec copies such images twice more, and stretches levels with rounding errors: 254 of 254 becomes 0. No pixels
/// if the header is damaged or the pixels are incomplete.
ImagePixels DecodeBinaryNetpbm(std::span<const uint8_t> bytes, int64_t most_pixels);

/// The pixels of a whole PGM whose levels fill 8 bits, without a copy: the image shares the memory of `file` (a row of
/// CV_8U). A new copy of a large image costs more than its tracking. Empty if the file is of another kind or damaged.
cv::Mat PgmInPlace(const cv::Mat& file);

}  // namespace turnscale

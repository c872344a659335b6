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
  /// Bytes of header and pixels; a shorter file is incomplete.
  size_t file_size() const { return pixels_begin + pixels_size(); }
  /// Bytes of the pixels.
  size_t pixels_size() const { return size_t{1} * width * height * channels * (is_deep() ? 2 : 1); }
};

/// Whether the bytes begin as a binary PGM or PPM.
bool IsBinaryNetpbm(std::span<const uint8_t> bytes);

/// Nothing if the bytes are of another kind, or the header is damaged or incomplete.
std::optional<NetpbmHeader> HeaderOfNetpbm(std::span<const uint8_t> bytes);

/// Decodes a binary PGM or PPM of at most `most_pixels` pixels; the first image if there are several. No pixels if the
/// header is damaged or pixels are missing.
ImagePixels DecodeBinaryNetpbm(std::span<const uint8_t> bytes, int64_t most_pixels);

/// The pixels of a complete PGM with 8 bits in full range (greatest level 255), without a copy: the image shares the
/// memory of `file`, a row of CV_8U. Empty for all other files.
cv::Mat PgmInPlace(const cv::Mat& file);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace turnscale {

/// Eight bytes that a PNG begins with.
constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";

/// A chunk of a PNG: length, type, data and checksum.
using PngChunk = std::span<const uint8_t>;

/// What the first chunk says, with the numbers of the PNG specification.
struct PngHeader {
  uint32_t width = 0;
  uint32_t height = 0;
  int depth = 0;  ///< bits of a sample
  int colour = 0;
  int compression = 0;
  int filter = 0;
  bool interlaced = false;
};

constexpr int kPngGray = 0;
constexpr int kPngPalette = 3;

/// Chunks of a file that begins with the signature. Those that do not change the pixels are left out: their damage does
/// no harm, and a text can be packed to a thousandth of its size. The last one may be cut off.
std::vector<PngChunk> PngChunks(std::span<const uint8_t> png);

/// Whether the chunk is of this type, of four letters.
bool IsPngChunk(PngChunk chunk, std::string_view type);
/// Whether the chunk is as long as it says, and its checksum is that of its type and data.
bool IsUndamaged(PngChunk chunk);

/// Nothing if the first chunk is no header.
std::optional<PngHeader> HeaderOfPng(const std::vector<PngChunk>& chunks);

/// Bytes of the rows of an image, each with the number of its filter, before they are packed.
uint64_t UnpackedPngSize(const PngHeader& header);

enum class PngData { kShort, kExact, kLong, kDamaged };

/// Unpacks the chunks' data into `unpacked` and says how it fits. The checksum of the data is tested where it fits
/// exactly.
PngData UnpackPng(const std::vector<PngChunk>& chunks, std::span<uint8_t> unpacked);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include <algorithm>
#include <optional>
#include <span>
#include <string_view>

#include "turnscale/frames/frame_reader.h"
#include "turnscale/image_file/first_bytes.h"
#include "turnscale/image_file/netpbm.h"
#include "turnscale/image_file/png_chunks.h"

namespace turnscale {
namespace {

using Bytes = std::span<const uint8_t>;

size_t BigEndian(Bytes bytes, size_t at, int count) {
  size_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[at + i];
  return value;
}

bool PngEndsEarly(Bytes bytes) {
  return std::ranges::none_of(PngChunks(bytes), [](PngChunk chunk) { return IsPngChunk(chunk, "IEND"); });
}

// Segments with a length, and between them coded data in which FF is followed by 00 or a restart marker.
bool JpegEndsEarly(Bytes bytes) {
  constexpr uint8_t kEndOfImage = 0xD9;
  constexpr uint8_t kStartOfScan = 0xDA;
  size_t at = 2;
  bool coded = false;
  while (at + 1 < bytes.size()) {
    const uint8_t marker = bytes[at + 1];
    if (bytes[at] != 0xFF || marker == 0xFF) {
      ++at;
    } else if (coded && (marker == 0 || (marker >= 0xD0 && marker <= 0xD7))) {
      at += 2;
    } else if (marker == kEndOfImage) {
      return false;
    } else if (at + 3 < bytes.size()) {
      coded = marker == kStartOfScan;
      at += 2 + BigEndian(bytes, at + 2, 2);
    } else {
      return true;
    }
  }
  return true;
}

bool BmpEndsEarly(Bytes bytes) {
  if (bytes.size() < 26) return true;
  size_t size = 0;
  for (int i = 3; i >= 0; --i) size = size << 8 | bytes[2 + i];
  return bytes.size() < size;
}

bool NetpbmEndsEarly(Bytes bytes) {
  const std::optional<NetpbmHeader> header = HeaderOfNetpbm(bytes);
  return header && bytes.size() < header->file_size();
}

// Height and width of the frame header, the first segment of its kind.
std::optional<uint64_t> JpegPixels(Bytes bytes) {
  size_t at = 2;
  while (at + 9 <= bytes.size()) {
    const uint8_t marker = bytes[at + 1];
    if (bytes[at] != 0xFF || marker == 0xFF) {
      ++at;
      continue;
    }
    const bool table = marker == 0xC4 || marker == 0xC8 || marker == 0xCC;
    if (marker >= 0xC0 && marker <= 0xCF && !table) return BigEndian(bytes, at + 5, 2) * BigEndian(bytes, at + 7, 2);
    at += 2 + BigEndian(bytes, at + 2, 2);
  }
  return std::nullopt;
}

}  // namespace

std::optional<uint64_t> AnnouncedPixels(Bytes bytes) {
  if (StartsWith(bytes, kPngSignature) && bytes.size() >= 24) return BigEndian(bytes, 16, 4) * BigEndian(bytes, 20, 4);
  if (StartsWith(bytes, "\xFF\xD8\xFF")) return JpegPixels(bytes);
  return std::nullopt;
}

bool EndsEarly(Bytes bytes) {
  if (StartsWith(bytes, kPngSignature)) return PngEndsEarly(bytes);
  if (StartsWith(bytes, "\xFF\xD8\xFF")) return JpegEndsEarly(bytes);
  if (StartsWith(bytes, "BM")) return BmpEndsEarly(bytes);
  if (IsBinaryNetpbm(bytes)) return NetpbmEndsEarly(bytes);
  return false;
}

}  // namespace turnscale

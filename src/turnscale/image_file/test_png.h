// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <libdeflate.h>

namespace turnscale {

using Bytes = std::vector<uint8_t>;

inline void AppendBigEndian(Bytes& bytes, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<uint8_t>(value >> shift));
}

inline void AppendChunk(Bytes& png, const std::string& name, const Bytes& data) {
  AppendBigEndian(png, static_cast<uint32_t>(data.size()));
  Bytes covered(name.begin(), name.end());
  covered.insert(covered.end(), data.begin(), data.end());
  png.insert(png.end(), covered.begin(), covered.end());
  AppendBigEndian(png, static_cast<uint32_t>(libdeflate_crc32(0, covered.data(), covered.size())));
}

/// What the first chunk says.
struct PngKind {
  int width = 0;
  int height = 0;
  int depth = 8;
  int colour = 0;  // 0 gray, 2 RGB, 3 palette, 4 gray and alpha, 6 RGBA
  int interlace = 0;
};

/// A file of `rows` as PNG packs them: each with its filter before it.
inline Bytes Png(const PngKind& header, const Bytes& rows, const Bytes& palette = {},
                 const std::function<void(Bytes&)>& before_data = {}) {
  const std::string signature = "\x89PNG\r\n\x1a\n";
  Bytes png(signature.begin(), signature.end());
  Bytes first;
  AppendBigEndian(first, static_cast<uint32_t>(header.width));
  AppendBigEndian(first, static_cast<uint32_t>(header.height));
  for (const int value : {header.depth, header.colour, 0, 0, header.interlace})
    first.push_back(static_cast<uint8_t>(value));
  AppendChunk(png, "IHDR", first);
  if (!palette.empty()) AppendChunk(png, "PLTE", palette);
  if (before_data) before_data(png);
  const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> compressor(
      libdeflate_alloc_compressor(6), libdeflate_free_compressor);
  Bytes packed(libdeflate_zlib_compress_bound(compressor.get(), rows.size()));
  packed.resize(libdeflate_zlib_compress(compressor.get(), rows.data(), rows.size(), packed.data(), packed.size()));
  AppendChunk(png, "IDAT", packed);
  AppendChunk(png, "IEND", {});
  return png;
}

}  // namespace turnscale

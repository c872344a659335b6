// SPDX-License-Identifier: MIT
#include "turnscale/image_file/png_chunks.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <memory>
#include <new>

#include <libdeflate.h>

namespace turnscale {
namespace {

constexpr size_t kLengthSize = 4;
constexpr size_t kBeforeData = 8;  // length and type
constexpr size_t kChecksumSize = 4;
constexpr size_t kAroundData = kBeforeData + kChecksumSize;

uint32_t NumberAt(PngChunk bytes, size_t at) {
  uint32_t number = 0;
  for (size_t i = 0; i < 4; ++i) number = number << 8 | bytes[at + i];
  return number;
}

struct FreeDecompressor {
  void operator()(libdeflate_decompressor* decompressor) const { libdeflate_free_decompressor(decompressor); }
};

}  // namespace

std::vector<PngChunk> PngChunks(std::span<const uint8_t> png) {
  constexpr uint8_t kAncillary = 0x20;
  std::vector<PngChunk> chunks;
  png = png.subspan(kPngSignature.size());
  while (png.size() >= kAroundData) {
    const PngChunk chunk = png.first(std::min(size_t{NumberAt(png, 0)} + kAroundData, png.size()));
    if ((chunk[kLengthSize] & kAncillary) == 0) chunks.push_back(chunk);
    png = png.subspan(chunk.size());
  }
  return chunks;
}

bool IsPngChunk(PngChunk chunk, std::string_view type) {
  return chunk.size() >= kBeforeData && std::memcmp(chunk.data() + kLengthSize, type.data(), type.size()) == 0;
}

bool IsUndamaged(PngChunk chunk) {
  if (chunk.size() != size_t{NumberAt(chunk, 0)} + kAroundData) return false;
  const size_t at = chunk.size() - kChecksumSize;
  return libdeflate_crc32(0, chunk.data() + kLengthSize, at - kLengthSize) == NumberAt(chunk, at);
}

std::optional<PngHeader> HeaderOfPng(const std::vector<PngChunk>& chunks) {
  constexpr size_t kSize = 25;
  if (chunks.empty() || !IsPngChunk(chunks[0], "IHDR") || chunks[0].size() != kSize) return std::nullopt;
  const PngChunk data = chunks[0].subspan(kBeforeData);
  PngHeader header;
  header.width = NumberAt(data, 0);
  header.height = NumberAt(data, 4);
  header.depth = data[8];
  header.colour = data[9];
  header.compression = data[10];
  header.filter = data[11];
  header.interlaced = data[12] != 0;
  return header;
}

uint64_t UnpackedPngSize(const PngHeader& header) {
  struct Pass {
    uint64_t x, y, step_x, step_y;
  };
  constexpr Pass kWhole[] = {{0, 0, 1, 1}};
  constexpr Pass kPasses[] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                              {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
  constexpr uint64_t kChannels[] = {1, 0, 3, 1, 2, 0, 4};
  const size_t colour = std::min(static_cast<size_t>(header.colour), std::size(kChannels) - 1);
  const uint64_t bits = static_cast<uint64_t>(header.depth) * kChannels[colour];
  uint64_t size = 0;
  for (const Pass& pass : header.interlaced ? std::span<const Pass>(kPasses) : std::span<const Pass>(kWhole)) {
    const uint64_t columns = (header.width + pass.step_x - 1 - pass.x) / pass.step_x;
    const uint64_t rows = (header.height + pass.step_y - 1 - pass.y) / pass.step_y;
    if (columns > 0) size += rows * (1 + (columns * bits + 7) / 8);
  }
  return size;
}

PngData UnpackPng(const std::vector<PngChunk>& chunks, std::span<uint8_t> unpacked) {
  std::vector<uint8_t> packed;
  for (const PngChunk chunk : chunks)
    if (IsPngChunk(chunk, "IDAT") && chunk.size() >= kAroundData)
      packed.insert(packed.end(), chunk.begin() + kBeforeData, chunk.end() - kChecksumSize);
  const std::unique_ptr<libdeflate_decompressor, FreeDecompressor> decompressor(libdeflate_alloc_decompressor());
  if (!decompressor) throw std::bad_alloc();
  switch (libdeflate_zlib_decompress(decompressor.get(), packed.data(), packed.size(), unpacked.data(), unpacked.size(),
                                     nullptr)) {
    case LIBDEFLATE_SUCCESS:
      return PngData::kExact;
    case LIBDEFLATE_SHORT_OUTPUT:
      return PngData::kShort;
    case LIBDEFLATE_INSUFFICIENT_SPACE:
      return PngData::kLong;
    default:
      return PngData::kDamaged;
  }
}

}  // namespace turnscale

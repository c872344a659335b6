// SPDX-License-Identifier: MIT
#include "turnscale/image_file/image_encoder.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <string_view>

#include <libdeflate.h>
#include <turbojpeg.h>

#include "turnscale/base/error.h"
#include "turnscale/image_file/png_chunks.h"

namespace turnscale {
namespace {

constexpr int kFastest = 1;  // of libdeflate's levels: noise cannot be packed, higher ones only take longer
constexpr char kSubFilter = 1;

void AppendBigEndian(std::string& bytes, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(value >> shift & 0xFF));
}

void AppendChunk(std::string& png, std::string_view type, std::string_view data) {
  AppendBigEndian(png, static_cast<uint32_t>(data.size()));
  const size_t covered = png.size();
  png.append(type).append(data);
  AppendBigEndian(png, libdeflate_crc32(0, png.data() + covered, png.size() - covered));
}

std::string Header(const cv::Size& size) {
  std::string header;
  AppendBigEndian(header, static_cast<uint32_t>(size.width));
  AppendBigEndian(header, static_cast<uint32_t>(size.height));
  constexpr char kDepth = 8;
  for (const char field : {kDepth, static_cast<char>(kPngGray), '\0', '\0', '\0'}) header.push_back(field);
  return header;
}

// Each pixel less the one to its left.
std::string FilteredRows(const cv::Mat& gray) {
  std::string rows;
  rows.reserve((gray.cols + size_t{1}) * gray.rows);
  for (int y = 0; y < gray.rows; ++y) {
    const uint8_t* row = gray.ptr<uint8_t>(y);
    rows.push_back(kSubFilter);
    uint8_t left = 0;
    for (int x = 0; x < gray.cols; ++x) {
      rows.push_back(static_cast<char>(row[x] - left));
      left = row[x];
    }
  }
  return rows;
}

std::string Packed(const std::string& data) {
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(kFastest), &libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  std::string packed(libdeflate_zlib_compress_bound(compressor.get(), data.size()), '\0');
  packed.resize(libdeflate_zlib_compress(compressor.get(), data.data(), data.size(), packed.data(), packed.size()));
  return packed;
}

}  // namespace

std::string EncodePng(const cv::Mat& gray) {
  Ensure(gray.type() == CV_8UC1 && !gray.empty(), "a PNG takes an 8-bit gray image");
  std::string png(kPngSignature);
  AppendChunk(png, "IHDR", Header(gray.size()));
  AppendChunk(png, "IDAT", Packed(FilteredRows(gray)));
  AppendChunk(png, "IEND", {});
  return png;
}

std::string EncodeJpeg(const cv::Mat& image, int quality) {
  Ensure((image.type() == CV_8UC1 || image.type() == CV_8UC3) && !image.empty(), "a JPEG takes an 8-bit image");
  Ensure(quality >= 1 && quality <= 100, "the quality of a JPEG is from 1 to 100");
  const std::unique_ptr<void, decltype(&tjDestroy)> compressor(tjInitCompress(), &tjDestroy);
  if (!compressor) throw std::bad_alloc();
  const bool gray = image.channels() == 1;
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  // Other transforms give other bytes on other processors.
  const int result = tjCompress2(compressor.get(), image.data, image.cols, static_cast<int>(image.step), image.rows,
                                 gray ? TJPF_GRAY : TJPF_BGR, &bytes, &size, gray ? TJSAMP_GRAY : TJSAMP_420, quality,
                                 TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, decltype(&tjFree)> owner(bytes, &tjFree);
  Ensure(result == 0, "an image cannot be encoded as JPEG");
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace turnscale

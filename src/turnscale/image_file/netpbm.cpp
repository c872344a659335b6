// SPDX-License-Identifier: MIT
#include "turnscale/image_file/netpbm.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <system_error>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace turnscale {
namespace {

using Bytes = std::span<const uint8_t>;

// Beyond any image; the product of two is far from running over.
constexpr int kMostSide = 1'000'000;

bool IsSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// Whitespace and comments between two words of the header.
const char* SkipSpace(const char* at, const char* end) {
  at = std::find_if_not(at, end, IsSpace);
  while (at != end && *at == '#') at = std::find_if_not(std::find(at, end, '\n'), end, IsSpace);
  return at;
}

}  // namespace

bool IsBinaryNetpbm(Bytes bytes) { return bytes.size() > 2 && bytes[0] == 'P' && (bytes[1] == '5' || bytes[1] == '6'); }

std::optional<NetpbmHeader> HeaderOfNetpbm(Bytes bytes) {
  if (!IsBinaryNetpbm(bytes)) return std::nullopt;
  NetpbmHeader header;
  header.channels = bytes[1] == '6' ? 3 : 1;
  const char* const begin = reinterpret_cast<const char*>(bytes.data());
  const char* const end = begin + bytes.size();
  const char* at = begin + 2;
  for (int* const value : {&header.width, &header.height, &header.greatest_level}) {
    const char* const word = SkipSpace(at, end);
    if (word == at) return std::nullopt;
    const auto [after, error] = std::from_chars(word, end, *value);
    if (error != std::errc() || *value <= 0) return std::nullopt;
    at = after;
  }
  if (header.width > kMostSide || header.height > kMostSide || header.greatest_level > 0xFFFF) return std::nullopt;
  // One character of whitespace ends the header.
  if (at == end || !IsSpace(*at)) return std::nullopt;
  header.pixels_begin = static_cast<size_t>(at + 1 - begin);
  return header;
}

cv::Mat PgmInPlace(const cv::Mat& file) {
  const Bytes bytes(file.data, file.total());
  const std::optional<NetpbmHeader> header = HeaderOfNetpbm(bytes);
  if (!header || header->channels != 1 || header->greatest_level != 0xFF || bytes.size() < header->file_size()) {
    return {};
  }
  const auto begin = static_cast<int>(header->pixels_begin);
  cv::Mat image = file.colRange(begin, begin + static_cast<int>(header->pixels_size())).reshape(1, header->height);
  // An image of its own: filters would take the rest of the file for pixels beyond the border.
  image.flags &= ~cv::Mat::SUBMATRIX_FLAG;
  image.datastart = image.data;
  image.dataend = image.datalimit = image.data + image.total();
  return image;
}

// Without libavcodec, which copies such images twice more, and stretches levels with rounding errors: 254 of 254
// becomes 0.
ImagePixels DecodeBinaryNetpbm(Bytes bytes, int64_t most_pixels) {
  const std::optional<NetpbmHeader> header = HeaderOfNetpbm(bytes);
  if (!header || int64_t{header->width} * header->height > most_pixels || bytes.size() < header->file_size()) {
    return {};
  }
  const uint8_t* const stored = bytes.data() + header->pixels_begin;
  cv::Mat levels(header->height, header->width, CV_MAKETYPE(header->is_deep() ? CV_16U : CV_8U, header->channels));
  if (header->is_deep()) {
    auto* const level = levels.ptr<uint16_t>();
    for (size_t i = 0; i < header->pixels_size() / 2; ++i)
      level[i] = static_cast<uint16_t>(stored[2 * i] << 8 | stored[2 * i + 1]);
  } else {
    std::copy_n(stored, header->pixels_size(), levels.data);
  }
  const int range = header->is_deep() ? 0xFFFF : 0xFF;
  ImagePixels pixels{levels, header->channels > 1};
  if (pixels.colour) cv::cvtColor(levels, pixels.gray, cv::COLOR_RGB2GRAY);
  if (header->greatest_level != range)
    pixels.gray.convertTo(pixels.gray, -1, static_cast<double>(range) / header->greatest_level);
  pixels.range_is_stated = header->is_deep() && header->greatest_level != range;
  return pixels;
}

}  // namespace turnscale

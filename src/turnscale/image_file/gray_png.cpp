// SPDX-License-Identifier: MIT
#include "turnscale/image_file/gray_png.h"

#include <algorithm>
#include <climits>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>

namespace turnscale {
namespace {

// Of left, above and above left, the one that is closest to left + above - above left; of equal ones the first.
int Paeth(int left, int above, int above_left) {
  const int to_left = std::abs(above - above_left);
  const int to_above = std::abs(left - above_left);
  const int to_above_left = std::abs(left + above - 2 * above_left);
  if (to_left <= to_above && to_left <= to_above_left) return left;
  return to_above <= to_above_left ? above : above_left;
}

// Adds to each byte what the filter predicts from the bytes before. `above`: the row before, without its filter. False
// for a filter that does not exist.
bool Unfilter(int filter, const uint8_t* filtered, const uint8_t* above, int width, uint8_t* row) {
  const auto with_left = [&](auto predicted) {
    int left = 0;
    for (int x = 0; x < width; ++x) {
      left = (filtered[x] + predicted(left, x)) & 0xFF;
      row[x] = static_cast<uint8_t>(left);
    }
  };
  switch (filter) {
    case 0:
      std::copy_n(filtered, width, row);
      return true;
    case 1:
      with_left([](int left, int) { return left; });
      return true;
    case 2:
      for (int x = 0; x < width; ++x) row[x] = static_cast<uint8_t>(filtered[x] + above[x]);
      return true;
    case 3:
      with_left([&](int left, int x) { return (left + above[x]) / 2; });
      return true;
    case 4:
      with_left([&](int left, int x) { return Paeth(left, above[x], x > 0 ? above[x - 1] : 0); });
      return true;
    default:
      return false;
  }
}

}  // namespace

cv::Mat DecodeGrayPng(const std::vector<PngChunk>& chunks) {
  const std::optional<PngHeader> header = HeaderOfPng(chunks);
  if (!header || header->depth != 8 || header->colour != kPngGray || header->interlaced || header->compression != 0 ||
      header->filter != 0 || header->width == 0 || header->height == 0 || header->width >= INT_MAX ||
      header->height > INT_MAX || !IsPngChunk(chunks.back(), "IEND")) {
    return {};
  }
  for (size_t i = 0; i < chunks.size(); ++i) {
    const bool expected = i == 0 || i + 1 == chunks.size() || IsPngChunk(chunks[i], "IDAT");
    if (!expected || !IsUndamaged(chunks[i])) return {};
  }
  const int width = static_cast<int>(header->width);
  const size_t stride = size_t{header->width} + 1;
  const size_t size = stride * header->height;
  // The size is what the header says, the data may be short: nothing is filled in before.
  const auto rows = std::make_unique_for_overwrite<uint8_t[]>(size);
  if (UnpackPng(chunks, {rows.get(), size}) != PngData::kExact) return {};
  cv::Mat gray(static_cast<int>(header->height), width, CV_8UC1);
  const std::vector<uint8_t> before_first(header->width, 0);
  const uint8_t* above = before_first.data();
  for (int y = 0; y < gray.rows; ++y) {
    const uint8_t* stored = rows.get() + static_cast<size_t>(y) * stride;
    if (!Unfilter(stored[0], stored + 1, above, width, gray.ptr(y))) return {};
    above = gray.ptr(y);
  }
  return gray;
}

}  // namespace turnscale

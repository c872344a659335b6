// SPDX-License-Identifier: MIT
#include "turnscale/image_file/jpeg_orientation.h"

#include <optional>
#include <string_view>

#include <opencv2/core.hpp>

#include "turnscale/image_file/first_bytes.h"

namespace turnscale {
namespace {

using namespace std::string_view_literals;
using Bytes = std::span<const uint8_t>;

// Numbers at any place of some bytes; nothing beyond their end.
class NumbersAt {
 public:
  NumbersAt(Bytes bytes, bool big_endian) : bytes_(bytes), big_endian_(big_endian) {}

  std::optional<uint32_t> Short(uint64_t at) const { return Number(at, 2); }
  std::optional<uint32_t> Long(uint64_t at) const { return Number(at, 4); }

 private:
  std::optional<uint32_t> Number(uint64_t at, unsigned size) const {
    if (bytes_.size() < size || at > bytes_.size() - size) return std::nullopt;
    uint32_t number = 0;
    for (unsigned i = 0; i < size; ++i) number = number << 8U | bytes_[at + (big_endian_ ? i : size - 1 - i)];
    return number;
  }

  Bytes bytes_;
  bool big_endian_;
};

// The orientation in EXIF data, which are laid out as a TIFF; nothing where there is none.
std::optional<int> OrientationInTiff(Bytes tiff) {
  constexpr uint32_t kOrientationTag = 0x0112;
  constexpr uint32_t kShortType = 3;
  constexpr uint64_t kEntrySize = 12;
  const bool big_endian = StartsWith(tiff, "MM\0*"sv);
  if (!big_endian && !StartsWith(tiff, "II*\0"sv)) return std::nullopt;
  const NumbersAt numbers(tiff, big_endian);
  const std::optional<uint32_t> directory = numbers.Long(4);
  if (!directory) return std::nullopt;
  const uint32_t entries = numbers.Short(*directory).value_or(0);
  for (uint32_t i = 0; i < entries; ++i) {
    const uint64_t entry = uint64_t{*directory} + 2 + i * kEntrySize;
    const std::optional<uint32_t> tag = numbers.Short(entry);
    if (!tag) return std::nullopt;
    if (*tag != kOrientationTag) continue;
    const std::optional<uint32_t> value = numbers.Short(entry + 8);
    const bool valid =
        numbers.Short(entry + 2) == kShortType && numbers.Long(entry + 4) == 1U && value && *value >= 1 && *value <= 8;
    return valid ? std::optional(static_cast<int>(*value)) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

int JpegOrientation(Bytes bytes) {
  constexpr std::string_view kExif = "Exif\0\0"sv;
  constexpr uint8_t kApp1 = 0xE1;
  constexpr uint8_t kStartOfScan = 0xDA;
  constexpr uint8_t kEndOfImage = 0xD9;
  if (!StartsWith(bytes, "\xFF\xD8\xFF")) return kUpright;
  const NumbersAt numbers(bytes, /*big_endian=*/true);
  for (size_t at = 2; at + 4 <= bytes.size() && bytes[at] == 0xFF;) {
    const uint8_t marker = bytes[at + 1];
    if (marker == 0xFF) {
      ++at;
      continue;
    }
    if (marker == kStartOfScan || marker == kEndOfImage) break;
    const size_t length = numbers.Short(at + 2).value_or(0);
    if (length < 2 || length > bytes.size() - at - 2) break;
    const Bytes content = bytes.subspan(at + 4, length - 2);
    if (marker == kApp1 && StartsWith(content, kExif))
      return OrientationInTiff(content.subspan(kExif.size())).value_or(kUpright);
    at += 2 + length;
  }
  return kUpright;
}

cv::Mat TurnedUpright(const cv::Mat& stored, int orientation) {
  cv::Mat turned;
  switch (orientation) {
    case 2:
      cv::flip(stored, turned, 1);
      return turned;
    case 3:
      cv::rotate(stored, turned, cv::ROTATE_180);
      return turned;
    case 4:
      cv::flip(stored, turned, 0);
      return turned;
    case 5:
      cv::transpose(stored, turned);
      return turned;
    case 6:
      cv::rotate(stored, turned, cv::ROTATE_90_CLOCKWISE);
      return turned;
    case 7:
      cv::transpose(stored, turned);
      cv::rotate(turned, turned, cv::ROTATE_180);
      return turned;
    case 8:
      cv::rotate(stored, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
      return turned;
    default:
      return stored;
  }
}

}  // namespace turnscale

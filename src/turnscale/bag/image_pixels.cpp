// SPDX-License-Identifier: MIT
#include "turnscale/bag/image_pixels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "turnscale/bag/byte_reader.h"
#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"

namespace turnscale {
namespace {

constexpr int kNoConversion = -1;
// Pixels of a side. More is a damaged message.
constexpr uint32_t kLongestSide = 1 << 16;

struct ImageEncoding {
  std::string_view name;
  int type;
  int conversion = kNoConversion;  // to BGR
};

// OpenCV names the order of a colour filter by the second and third pixel of the second row.
constexpr std::array<ImageEncoding, 17> kEncodings = {{{"mono8", CV_8UC1},
                                                       {"mono16", CV_16UC1},
                                                       {"bgr8", CV_8UC3},
                                                       {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
                                                       {"bgra8", CV_8UC4},
                                                       {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR},
                                                       {"8UC1", CV_8UC1},
                                                       {"16UC1", CV_16UC1},
                                                       {"8UC3", CV_8UC3},
                                                       {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2BGR},
                                                       {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2BGR},
                                                       {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2BGR},
                                                       {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2BGR},
                                                       {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2BGR},
                                                       {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2BGR},
                                                       {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2BGR},
                                                       {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2BGR}}};

std::optional<ImageEncoding> FindEncoding(std::string_view name) {
  const auto found =
      std::find_if(kEncodings.begin(), kEncodings.end(), [&](const auto& encoding) { return encoding.name == name; });
  return found == kEncodings.end() ? std::nullopt : std::optional(*found);
}

cv::Mat Converted(const cv::Mat& stored, int conversion) {
  if (conversion == kNoConversion) return stored;
  constexpr int kSmallestFilter = 3;
  const bool filter = stored.channels() == 1;
  if (filter && (stored.cols < kSmallestFilter || stored.rows < kSmallestFilter))
    throw MalformedData("an image is too small for its colour filter");
  cv::Mat converted;
  cv::cvtColor(stored, converted, conversion);
  return converted;
}

}  // namespace

void CheckEncoding(std::string_view encoding, const std::string& where) {
  if (FindEncoding(encoding)) return;
  throw InputError(
      fmt::format("{}: image encoding '{}' is not supported; record mono8, mono16, bgr8, rgb8, bgra8, rgba8 or bayer_*",
                  where, Printable(encoding.substr(0, 32))));
}

cv::Mat PixelsOf(const BagImage& image) {
  const std::optional<ImageEncoding> encoding = FindEncoding(image.encoding);
  if (!encoding) throw MalformedData("an image has an unknown encoding");
  if (image.width == 0 || image.height == 0 || image.width > kLongestSide || image.height > kLongestSide)
    throw MalformedData(fmt::format("an image of {}x{} pixels", image.width, image.height));
  const size_t row = image.width * CV_ELEM_SIZE(encoding->type);
  const uint64_t needed = uint64_t{image.step} * (image.height - 1) + row;
  if (image.step < row || image.data.size() < needed) {
    throw MalformedData(fmt::format("an image of {}x{} pixels in {} has {} bytes, {} a row", image.width, image.height,
                                    encoding->name, image.data.size(), image.step));
  }
  // Copied, as the message's bytes last until the next one and need not be aligned.
  cv::Mat stored(static_cast<int>(image.height), static_cast<int>(image.width), encoding->type);
  for (int y = 0; y < stored.rows; ++y)
    std::copy_n(image.data.data() + static_cast<size_t>(y) * image.step, row, stored.ptr<uint8_t>(y));
  if (stored.depth() == CV_16U && image.big_endian != (std::endian::native == std::endian::big)) {
    for (int y = 0; y < stored.rows; ++y) {
      auto* values = stored.ptr<uint16_t>(y);
      std::transform(values, values + stored.cols, values,
                     [](uint16_t value) { return static_cast<uint16_t>(value << 8 | value >> 8); });
    }
  }
  return Converted(stored, encoding->conversion);
}

cv::Mat WithColour(const cv::Mat& picture, std::string_view format) {
  const std::optional<ImageEncoding> encoding = FindEncoding(format.substr(0, format.find(';')));
  if (!encoding || !encoding->name.starts_with("bayer_") || picture.channels() != 1) return picture;
  return Converted(picture, encoding->conversion);
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/io/frame_reader.h"

#include <climits>
#include <fstream>
#include <iterator>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "turnscale/image_file/image_decoder.h"
#include "turnscale/image_file/netpbm.h"

namespace turnscale {
namespace {

class ImageListReader : public FrameReader {
 public:
  explicit ImageListReader(std::vector<std::filesystem::path> images) : images_(std::move(images)) {}

  std::optional<DriveImage> Read() override {
    if (next_ == images_.size()) return std::nullopt;
    const std::filesystem::path& path = images_[next_++];
    DriveImage image;
    image.image = ReadGrayImage(path);
    image.name = path.string();
    return image;
  }

 private:
  std::vector<std::filesystem::path> images_;
  size_t next_ = 0;
};

DecodedImage Decoded(std::span<const uint8_t> bytes, int64_t most_pixels) {
  if (EndsEarly(bytes)) return {{}, false, "is truncated"};
  const ImagePixels decoded = DecodePixels(bytes, most_pixels);
  if (!decoded.gray.empty()) return {decoded.gray, decoded.colour, ""};
  const bool is_tiff = bytes.size() > 1 && bytes[0] == bytes[1] && (bytes[0] == 'I' || bytes[0] == 'M');
  return {{},
          false,
          is_tiff ? "is not a readable TIFF; one with tiles, of floating-point numbers or packed as JPEG has to be "
                    "converted, for example to PNG"
                  : "is not a readable image"};
}

}  // namespace

cv::Mat ToGray8(const cv::Mat& image) {
  cv::Mat gray = image;
  if (image.channels() == 3) cv::cvtColor(image, gray, cv::COLOR_BGR2GRAY);
  if (image.channels() == 4) cv::cvtColor(image, gray, cv::COLOR_BGRA2GRAY);
  if (gray.depth() == CV_16U) gray.convertTo(gray, CV_8U, 1.0 / 256.0);
  return gray.depth() == CV_8U && gray.channels() == 1 ? gray : cv::Mat();
}

GrayImage ReadGrayImage(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return {{}, name + ": cannot be opened"};
  stream.seekg(0, std::ios::end);
  const std::streamoff size = stream.tellg();
  if (size <= 0) return {{}, name + ": is empty"};
  if (size > INT_MAX) return {{}, name + ": is larger than 2 GB"};
  const cv::Mat bytes(1, static_cast<int>(size), CV_8U);
  stream.seekg(0);
  if (!stream.read(reinterpret_cast<char*>(bytes.data), size)) return {{}, name + ": cannot be read"};
  // The copy of a large image would take as long as its tracking.
  if (const cv::Mat gray = PgmInPlace(bytes); !gray.empty()) return {gray, ""};
  const DecodedImage decoded = DecodeImage({bytes.data, bytes.total()});
  if (!decoded.problem.empty()) return {{}, name + ": " + decoded.problem};
  const cv::Mat gray = ToGray8(decoded.pixels);
  return {gray, gray.empty() ? name + ": is not a readable image" : ""};
}

DecodedImage DecodeImage(std::span<const uint8_t> bytes) { return Decoded(bytes, INT_MAX); }

DecodedImage DecodeJpegOrPng(std::span<const uint8_t> bytes) {
  constexpr int64_t kMostPixels = 100'000'000;
  const std::optional<uint64_t> pixels = AnnouncedPixels(bytes);
  if (!pixels) return {{}, false, "is neither JPEG nor PNG"};
  if (*pixels == 0 || *pixels > kMostPixels) return {{}, false, "is not a readable image"};
  return Decoded(bytes, kMostPixels);
}

std::unique_ptr<FrameReader> ReadImages(std::vector<std::filesystem::path> images) {
  return std::make_unique<ImageListReader>(std::move(images));
}

}  // namespace turnscale

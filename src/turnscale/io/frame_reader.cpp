// SPDX-License-Identifier: MIT
#include "turnscale/io/frame_reader.h"

#include <fstream>
#include <iterator>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

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
  std::vector<uint8_t> bytes(static_cast<size_t>(size));
  stream.seekg(0);
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), size)) return {{}, name + ": cannot be read"};
  const DecodedImage decoded = DecodeImage(bytes);
  if (!decoded.problem.empty()) return {{}, name + ": " + decoded.problem};
  const cv::Mat gray = ToGray8(decoded.pixels);
  return {gray, gray.empty() ? name + ": is not a readable image" : ""};
}

DecodedImage DecodeImage(std::span<const uint8_t> bytes) {
  if (EndsEarly(bytes)) return {{}, "is truncated"};
  // The decoder only reads.
  const cv::Mat stored(1, static_cast<int>(bytes.size()), CV_8UC1, const_cast<uint8_t*>(bytes.data()));
  DecodedImage image;
  try {
    image.pixels = cv::imdecode(stored, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    image.pixels = cv::Mat();
  }
  if (image.pixels.empty()) image.problem = "is not a readable image";
  return image;
}

DecodedImage DecodeJpegOrPng(std::span<const uint8_t> bytes) {
  constexpr uint64_t kMostPixels = 100'000'000;
  const std::optional<uint64_t> pixels = AnnouncedPixels(bytes);
  if (!pixels) return {{}, "is neither JPEG nor PNG"};
  if (*pixels == 0 || *pixels > kMostPixels) return {{}, "is not a readable image"};
  return DecodeImage(bytes);
}

std::unique_ptr<FrameReader> ReadImages(std::vector<std::filesystem::path> images) {
  return std::make_unique<ImageListReader>(std::move(images));
}

}  // namespace turnscale

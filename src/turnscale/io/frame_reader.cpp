// SPDX-License-Identifier: MIT
#include "turnscale/io/frame_reader.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

class ImageListReader : public FrameReader {
 public:
  explicit ImageListReader(std::vector<std::filesystem::path> images) : images_(std::move(images)) {}

  std::optional<GrayImage> Read() override {
    if (next_ == images_.size()) return std::nullopt;
    return ReadGrayImage(images_[next_++]);
  }

 private:
  std::vector<std::filesystem::path> images_;
  size_t next_ = 0;
};

class VideoReader : public FrameReader {
 public:
  explicit VideoReader(const cv::VideoCapture& capture) : capture_(capture) {}

  std::optional<GrayImage> Read() override {
    cv::Mat image;
    if (!capture_.read(image)) return std::nullopt;
    // The decoder may reuse its buffer for the next frame.
    return GrayImage{image.channels() == 1 ? image.clone() : ToGray8(image), ""};
  }

 private:
  cv::VideoCapture capture_;
};

cv::VideoCapture Open(const std::filesystem::path& path) {
  // One backend where there is a choice: each has its own idea of colours and rates, and prints its own complaints.
  const bool has_ffmpeg = cv::videoio_registry::hasBackend(cv::CAP_FFMPEG);
  cv::VideoCapture capture(path.string(), has_ffmpeg ? cv::CAP_FFMPEG : cv::CAP_ANY);
  if (!capture.isOpened()) {
    throw InputError(path.string() + ": cannot be opened as a video; give a video or a folder of images");
  }
  return capture;
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
  std::vector<uint8_t> bytes(static_cast<size_t>(size));
  stream.seekg(0);
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), size)) return {{}, name + ": cannot be read"};
  if (EndsEarly(bytes)) return {{}, name + ": is truncated"};
  GrayImage image;
  try {
    image.gray =
        ToGray8(cv::imdecode(bytes, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION));
  } catch (const cv::Exception&) {
    image.gray = cv::Mat();
  }
  if (image.gray.empty()) image.problem = name + ": is not a readable image";
  return image;
}

std::unique_ptr<FrameReader> ReadImages(std::vector<std::filesystem::path> images) {
  return std::make_unique<ImageListReader>(std::move(images));
}

VideoStream OpenVideo(const std::filesystem::path& path) {
  cv::VideoCapture capture = Open(path);
  const double fps = capture.get(cv::CAP_PROP_FPS);
  const double count = capture.get(cv::CAP_PROP_FRAME_COUNT);
  VideoStream stream;
  // Containers without a rate report 0, NaN, or their clock's ticks.
  stream.fps = std::isfinite(fps) && fps > 0 && fps <= 1000 ? fps : 0.0;
  stream.count = count > 0 && count < std::numeric_limits<int>::max() ? static_cast<int>(count) : 0;
  stream.reader = std::make_unique<VideoReader>(capture);
  return stream;
}

int CountVideoFrames(const std::filesystem::path& path) {
  cv::VideoCapture capture = Open(path);
  int count = 0;
  while (capture.grab()) ++count;
  return count;
}

}  // namespace turnscale

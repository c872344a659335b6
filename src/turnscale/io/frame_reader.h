// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// An image as 8-bit gray, or why there is none.
struct GrayImage {
  cv::Mat gray;         ///< empty if the file is unusable
  std::string problem;  ///< "name: why"; empty if there is none
};

/// Reads an image file; colour and 16-bit become 8-bit gray, and the stored rows are taken as they are (a camera's
/// calibration knows nothing of EXIF orientation). Files that end too early are refused, not filled up.
GrayImage ReadGrayImage(const std::filesystem::path& path);

/// Any image type as 8-bit gray.
cv::Mat ToGray8(const cv::Mat& image);

/// Whether the bytes of a PNG, JPEG, BMP or binary PGM/PPM stop before the image is complete. Decoders fill such an
/// image up in silence. Other formats count as complete.
bool EndsEarly(std::span<const uint8_t> bytes);

/// Yields the images of a drive one by one.
class FrameReader {
 public:
  virtual ~FrameReader() = default;
  /// The next image, or why it is unusable; empty at the end.
  virtual std::optional<GrayImage> Read() = 0;
};

std::unique_ptr<FrameReader> ReadImages(std::vector<std::filesystem::path> images);

/// A video and what its header tells.
struct VideoStream {
  std::unique_ptr<FrameReader> reader;
  double fps = 0;  ///< 0 where the header does not tell
  int count = 0;   ///< frames that the header promises
};

/// Throws InputError where the file is no video that can be decoded.
VideoStream OpenVideo(const std::filesystem::path& path);

/// Frames that the video really holds: steps through all of it.
int CountVideoFrames(const std::filesystem::path& path);

}  // namespace turnscale

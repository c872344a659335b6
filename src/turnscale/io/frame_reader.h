// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "turnscale/io/image_file.h"

namespace turnscale {

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

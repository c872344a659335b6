// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>

#include <opencv2/core.hpp>

#include "turnscale/frames/video_writer.h"
#include "turnscale/simulation/rig.h"

namespace turnscale {

/// Names in a simulated drive's folder.
constexpr const char* kImageFolder = "image_0";
constexpr const char* kVideoFile = "video.mp4";

/// Where the images of a drive go: `video.mp4` if the rig records a video, else numbered PNG images in `image_0/`.
class ImageOutput {
 public:
  /// `folder` exists. Throws as VideoWriter does.
  ImageOutput(const std::filesystem::path& folder, const Rig& rig);

  /// The next image, and what the camera says of its time (seconds; of a video only). Throws OutputError where the
  /// system refuses to write.
  void Write(const cv::Mat& image, double stamp);
  /// Completes the video. Throws OutputError where the system refuses to write.
  void Finish();

 private:
  std::filesystem::path images_;
  std::optional<VideoWriter> video_;
  int count_ = 0;
};

}  // namespace turnscale

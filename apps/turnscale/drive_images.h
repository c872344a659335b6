// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <opencv2/core/mat.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/io/drive_input.h"
#include "turnscale/io/image_source.h"

namespace turnscale {

/// Threads that OpenCV may use where the user does not say. The library leaves that to the program.
constexpr int kImageThreads = 2;

/// What the commands that run the odometry over images have in common.
struct ImageArguments {
  std::filesystem::path input;
  std::optional<std::filesystem::path> camera;
  std::optional<std::filesystem::path> timestamps;
  std::optional<double> fps;
  std::optional<std::filesystem::path> settings;
  std::optional<int> max_frames;
  bool quiet = false;
};

/// A drive's images with the camera that took them.
struct DriveImages {
  /// Throws InputError where there are no images, no times or no calibration.
  explicit DriveImages(const ImageArguments& arguments);

  DriveInput drive;
  std::filesystem::path camera_file;
  CameraModel camera;
  ImageSource source;
  int expected = 0;  ///< frames to come up to `max_frames`; 0 where nothing tells
};

/// Why the calibration does not seem to be that of the image's camera; empty where it may be. A file that names an
/// image size is checked against it by the source.
std::string DoubtOf(const DriveImages& images, const cv::Mat& image);

}  // namespace turnscale

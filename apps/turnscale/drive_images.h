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

/// Threads that OpenCV may use by default. The library leaves the number to the program.
constexpr int kImageThreads = 2;

/// Arguments common to the commands that run the odometry on images.
struct ImageArguments {
  std::filesystem::path input;
  std::optional<std::filesystem::path> camera;
  std::optional<std::filesystem::path> timestamps;
  std::optional<double> fps;
  std::optional<std::filesystem::path> settings;
  std::optional<int> max_frames;
  bool quiet = false;
};

/// The images of a drive and their camera.
struct DriveImages {
  /// Throws InputError where there are no images, no times or no calibration.
  explicit DriveImages(const ImageArguments& arguments);

  DriveInput drive;
  std::filesystem::path camera_file;
  CameraModel camera;
  ImageSource source;
  int expected = 0;  ///< number of frames, limited by `max_frames`; 0 if unknown
};

/// Why the intrinsics are implausible for the image; empty if plausible. An image size in the file is checked by the
/// image source.
std::string DoubtOf(const DriveImages& images, const cv::Mat& image);

}  // namespace turnscale

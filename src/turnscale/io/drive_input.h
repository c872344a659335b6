// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

namespace turnscale {

/// What INPUT turned out to be: either images in natural order, or a video; and the files that came with them.
struct DriveInput {
  std::filesystem::path path;  ///< the folder that holds the images, or the video
  std::vector<std::filesystem::path> images;
  bool is_video = false;
  std::optional<std::filesystem::path> camera_file;  ///< `calib.txt`, else `camera.yaml`, beside the images
  std::optional<std::filesystem::path> times_file;   ///< `times.txt` beside the images
};

/// Detects the kind of INPUT: a KITTI folder (`image_0/` or `images/`, with `calib.txt` or
/// `camera.yaml`, and `times.txt`), a folder of images, a
/// folder with one video, or a video file. Throws InputError where it is none of these.
DriveInput FindDrive(const std::filesystem::path& input);

}  // namespace turnscale

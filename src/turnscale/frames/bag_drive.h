// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/camera/camera_model.h"

namespace turnscale {

/// The images of a topic of one bag, or of several that continue one another.
struct BagDrive {
  std::vector<std::filesystem::path> bags;
  std::string topic;
  int images = 0;           ///< as the bags' indices say
  int64_t first_stamp = 0;  ///< header stamp of the first image, nanoseconds
  /// The first bag with camera infos of the images, where one has them.
  std::optional<std::filesystem::path> camera_bag = {};
};

/// Finds the topic of images. Throws InputError where none is given (empty) and the bags have several, which it lists,
/// where a bag has no images on it, and where a bag begins before the one before it.
BagDrive FindBagDrive(const std::vector<std::filesystem::path>& bags, const std::string& topic);

/// The camera of a drive's images, from a topic of the bags.
struct BagCamera {
  std::string name;  ///< bag and topic, for messages
  CameraModel model;
};

/// From the first camera info beside the images' topic; nothing where there is none, or the camera is not calibrated.
/// Throws InputError for a camera that CameraModel does not know.
std::optional<BagCamera> ReadBagCamera(const BagDrive& drive);

}  // namespace turnscale

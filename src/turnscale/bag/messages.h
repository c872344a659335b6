// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "turnscale/bag/bag_reader.h"

namespace turnscale {

/// sensor_msgs/Image. Views into the message's bytes.
struct BagImage {
  int64_t stamp = 0;  ///< of the header, nanoseconds
  uint32_t width = 0;
  uint32_t height = 0;
  std::string_view encoding;
  bool big_endian = false;
  uint32_t step = 0;  ///< bytes of a row
  std::span<const uint8_t> data;
};

/// sensor_msgs/CompressedImage. Views into the message's bytes.
struct BagCompressedImage {
  int64_t stamp = 0;
  std::string_view format;  ///< such as "jpeg", or "bayer_rggb8; jpeg compressed"
  std::span<const uint8_t> data;
};

/// sensor_msgs/CameraInfo.
struct BagCameraInfo {
  int64_t stamp = 0;
  uint32_t width = 0;
  uint32_t height = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{};
  std::array<double, 12> p{};
  uint32_t binning_x = 0;
  uint32_t binning_y = 0;
  std::array<uint32_t, 4> roi{};  ///< x offset, y offset, height, width
};

/// Each throws MalformedData where the bytes are no such message.
BagImage ReadBagImage(const BagMessage& message);
BagCompressedImage ReadBagCompressedImage(const BagMessage& message);
BagCameraInfo ReadBagCameraInfo(const BagMessage& message);

/// Header stamp of an image or compressed image.
int64_t ReadBagStamp(const BagMessage& message);

/// Seconds of a stamp, as if its decimal number were read from a file of times.
double SecondsOfStamp(int64_t nanoseconds);

}  // namespace turnscale

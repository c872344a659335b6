// SPDX-License-Identifier: MIT
#include <fstream>
#include <stdexcept>

#include "street_drive.h"

namespace turnscale {

StreetDrive PlainStreetDrive(int frames) {
  StreetDrive drive = StreetDriveWithoutImages({.frames = frames});
  std::ifstream file(TURNSCALE_STREET_DRIVE, std::ios::binary);
  for (size_t i = 0; i < drive.times.size(); ++i) {
    cv::Mat image(drive.camera.height, drive.camera.width, CV_8U);
    file.read(image.ptr<char>(), static_cast<std::streamsize>(image.total()));
    drive.images.push_back(image);
  }
  if (!file) throw std::runtime_error(TURNSCALE_STREET_DRIVE ": is incomplete; build it anew");
  return drive;
}

}  // namespace turnscale

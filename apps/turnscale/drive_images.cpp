// SPDX-License-Identifier: MIT
#include "drive_images.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/camera/camera_file.h"

namespace turnscale {
namespace {

std::filesystem::path CameraFileFor(const ImageArguments& arguments, const DriveInput& drive) {
  if (arguments.camera) return *arguments.camera;
  if (drive.camera_file) return *drive.camera_file;
  throw InputError(arguments.input.string() + ": has no calib.txt or camera.yaml; give --camera FILE");
}

// 0 if known neither from the video header nor from the user.
int ExpectedFrames(int count, std::optional<int> max_frames) {
  if (!max_frames) return count;
  return count > 0 ? std::min(*max_frames, count) : *max_frames;
}

}  // namespace

DriveImages::DriveImages(const ImageArguments& arguments)
    : drive(FindDrive(arguments.input)),
      camera_file(CameraFileFor(arguments, drive)),
      camera(ReadCameraFile(camera_file)),
      source(drive, {arguments.timestamps, arguments.fps, camera.width, camera.height, camera_file.string()}),
      expected(ExpectedFrames(source.count(), arguments.max_frames)) {}

std::string DoubtOf(const DriveImages& images, const cv::Mat& image) {
  constexpr double kFarOff = 0.15;  // of the image's width or height
  const Pinhole& pinhole = images.camera.pinhole;
  const bool named = images.camera.width > 0;
  const bool central =
      std::abs(pinhole.cx / image.cols - 0.5) < kFarOff && std::abs(pinhole.cy / image.rows - 0.5) < kFarOff;
  if (image.empty() || named || central) return {};
  return fmt::format(
      "{}: the principal point ({:.0f}, {:.0f}) is far from the centre of {}x{} images; check that this is the right "
      "camera",
      images.camera_file.string(), pinhole.cx, pinhole.cy, image.cols, image.rows);
}

}  // namespace turnscale

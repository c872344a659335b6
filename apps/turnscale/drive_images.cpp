// SPDX-License-Identifier: MIT
#include "drive_images.h"

#include <algorithm>

#include "turnscale/base/error.h"
#include "turnscale/camera/camera_file.h"

namespace turnscale {
namespace {

std::filesystem::path CameraFileFor(const ImageArguments& arguments, const DriveInput& drive) {
  if (arguments.camera) return *arguments.camera;
  if (drive.camera_file) return *drive.camera_file;
  throw InputError(arguments.input.string() + ": comes without a calibration of its own; give --camera FILE");
}

// 0 where neither a video's header nor the user tells.
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

}  // namespace turnscale

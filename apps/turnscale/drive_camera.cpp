// SPDX-License-Identifier: MIT
#include "drive_camera.h"

#include <memory>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "interrupt.h"
#include "turnscale/base/error.h"
#include "turnscale/io/terminal.h"

namespace turnscale {
namespace {

constexpr double kUsualView = 70;
constexpr double kNarrowestView = 20;
constexpr double kWidestView = 150;

double ViewOf(const ImageArguments& arguments) {
  const double view = arguments.field_of_view.value_or(kUsualView);
  if (!(view >= kNarrowestView && view <= kWidestView))
    throw InputError(fmt::format("--fov {}: give the horizontal field of view in degrees, {} to {}", view,
                                 kNarrowestView, kWidestView));
  return view;
}

// The drive's images from its first one on.
ImageStream Images(const ImageArguments& arguments, const DriveInput& drive, Progress& progress, int& pass) {
  ++pass;
  auto source = std::make_shared<ImageSource>(drive, SourceOptions(arguments));
  return [&arguments, &progress, &pass, source, read = 0]() mutable -> std::optional<TimedImage> {
    if (Interrupted() || (arguments.max_frames && read == *arguments.max_frames)) return std::nullopt;
    std::optional<SourceFrame> frame = source->Next();
    if (!frame) return std::nullopt;
    progress.Update(++read, fmt::format("estimating the camera, pass {}", pass));
    return TimedImage{std::move(frame->gray), frame->time};
  };
}

std::optional<cv::Size> ImageSize(const ImageArguments& arguments, const DriveInput& drive) {
  ImageSource source(drive, SourceOptions(arguments));
  while (const std::optional<SourceFrame> frame = source.Next())
    if (!frame->gray.empty()) return frame->gray.size();
  return std::nullopt;
}

}  // namespace

void AddCameraOptions(CLI::App& command, ImageArguments& arguments) {
  CLI::Option* camera = command.add_option(
      "--camera", arguments.camera,
      "Intrinsics: KITTI calib.txt, OpenCV, ORB-SLAM or Kalibr YAML [calib.txt or camera.yaml in the "
      "input folder; else estimated from the turns of the drive]");
  command
      .add_option(
          "--fov", arguments.field_of_view,
          fmt::format("Estimate the intrinsics, starting from this horizontal field of view, degrees [{}]", kUsualView))
      ->excludes(camera);
  command.add_flag("--camera-refine", arguments.refine_camera,
                   "Estimate the intrinsics, starting from the given ones, and use the estimate");
}

std::optional<FoundCamera> EstimateCamera(const ImageArguments& arguments, DriveImages& images,
                                          const OdometryOptions& options, const cv::Mat& mask) {
  if (!images.camera_file.empty() && !arguments.refine_camera) return std::nullopt;
  const double view = ViewOf(arguments);
  if (images.camera.width == 0) {
    const std::optional<cv::Size> size = ImageSize(arguments, images.drive);
    // The run itself says what is wrong with such a drive.
    if (!size) return std::nullopt;
    if (images.camera_file.empty()) images.camera = CameraOfView(view, size->width, size->height);
    images.camera.width = size->width;
    images.camera.height = size->height;
  }
  // The run itself refuses such a mask.
  if (!mask.empty() && mask.size() != cv::Size(images.camera.width, images.camera.height)) return std::nullopt;
  CatchInterrupts();
  Progress progress(0, arguments.quiet);
  int pass = 0;
  const std::optional<FoundCamera> found = CalibrateFromDrive(
      {}, options, images.camera, [&] { return Images(arguments, images.drive, progress, pass); }, mask);
  progress.Finish();
  if (Interrupted()) return std::nullopt;
  if (!found) {
    progress.Warn(images.camera_file.empty()
                      ? fmt::format("no turn from which the camera's focal length can be estimated; a field of view of "
                                    "{:.0f} degrees is assumed: give --camera FILE or --fov DEGREES",
                                    view)
                      : std::string("no turn from which the camera's focal length can be estimated; the intrinsics "
                                    "are used as given"));
    return std::nullopt;
  }
  if (!found->converged)
    progress.Warn("the estimate of the camera did not converge; its standard deviation may be too small");
  images.camera = found->camera;
  return found;
}

}  // namespace turnscale

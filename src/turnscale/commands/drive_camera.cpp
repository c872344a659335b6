// SPDX-License-Identifier: MIT
#include "turnscale/commands/drive_camera.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/geometry/angle.h"
#include "turnscale/io/terminal.h"
#include "turnscale/run/full_size.h"

namespace turnscale {
namespace {

// Of a focal length that is assumed, or that follows from a given field of view, relative: makers round it, and often
// state that of the diagonal.
constexpr double kAssumedSigma = 0.3;
constexpr double kStatedSigma = 0.15;
constexpr double kNarrowestView = 20;
constexpr double kWidestView = 150;

double ViewOf(const ImageArguments& arguments) {
  const double view = arguments.field_of_view.value_or(kUsualView);
  if (!(view >= kNarrowestView && view <= kWidestView))
    throw InputError(fmt::format("--fov {}: give the horizontal field of view in degrees, {} to {}", view,
                                 kNarrowestView, kWidestView));
  return view;
}

// The drive's images. What is wrong with one of them the run itself says, when it comes to it.
// `times`: of all images that were read so far, from the drive's first one on. A pass that begins later begins among
// them, and counts those before it, too.
ImageStream Images(const ImageArguments& arguments, const DriveImages& images, const CommandHooks& hooks,
                   const ImageOptions& image_options, std::optional<double> from, const std::string& work,
                   std::vector<double>& times) {
  ImageSourceOptions options = SourceOptions(arguments, images.given, image_options);
  if (from) options.start += *from;
  auto source = std::make_shared<ImageSource>(images.drive, options);
  auto progress = std::make_shared<Progress>(0, arguments.quiet);
  return [&arguments, &hooks, &times, work, source, progress, read = 0,
          passed = 0]() mutable -> std::optional<TimedImage> {
    if (hooks.interrupted()) throw Interruption();
    if (arguments.max_frames && passed + read >= *arguments.max_frames) return std::nullopt;
    try {
      std::optional<SourceFrame> frame = source->Next();
      if (!frame) return std::nullopt;
      if (read == 0) passed = static_cast<int>(std::ranges::lower_bound(times, frame->time) - times.begin());
      if (times.empty() || frame->time > times.back()) times.push_back(frame->time);
      progress->Update(++read, work);
      return TimedImage{std::move(frame->gray), frame->time};
    } catch (const InputError&) {
      return std::nullopt;
    }
  };
}

std::string NoTurn(const ImageArguments& arguments, double least_turn_deg, double view, bool assumed) {
  const std::string what = fmt::format(
      "no turn of at least {:.0f} degrees, from which the camera's focal length could be estimated; ", least_turn_deg);
  if (!assumed) return what + "the intrinsics are used as given";
  if (arguments.field_of_view)
    return what + fmt::format("--fov {:g} is used: a calibration is more accurate", *arguments.field_of_view);
  return what + fmt::format(
                    "a horizontal field of view of {:.0f} degrees is assumed, and the shape of the path depends on it: "
                    "give --camera "
                    "FILE or --fov DEGREES",
                    view);
}

}  // namespace

CameraEstimate EstimateCamera(const ImageArguments& arguments, DriveImages& images, const Settings& settings,
                              const CommandHooks& hooks, const std::function<void(const std::string&)>& on_pass) {
  const bool assumed = images.given.name.empty();
  if (!assumed && !arguments.refine_camera) return {};
  if (assumed && arguments.refine_camera)
    throw InputError(arguments.field_of_view
                         ? "--camera-refine: needs a calibration, and --fov replaces it; leave out one of the two"
                         : "--camera-refine: there are no intrinsics to refine; give --camera FILE, or leave it out");
  const double view = ViewOf(arguments);
  // The run itself says what is wrong with such a drive.
  if (images.full_size.empty()) return {};
  const cv::Size size = images.scaling.Scaled(images.full_size);
  const CameraModel given = images.camera;
  if (assumed)
    images.camera = (arguments.field_of_view ? CameraOfView : CameraOfLongerView)(view, size.width, size.height,
                                                                                  images.source.pixel_aspect());
  images.camera.read_direction = given.read_direction;
  images.camera.width = size.width;
  images.camera.height = size.height;
  if (assumed)
    images.camera.focal_sigma = (arguments.field_of_view ? kStatedSigma : kAssumedSigma) * images.camera.pinhole.fx;
  const int most_passes = MostPasses(settings.self_calibration, assumed);
  int pass = 0;
  std::vector<double> times;
  const std::optional<FoundCamera> found = CalibrateFromDrive(
      settings.self_calibration, settings.odometry, {images.camera, assumed},
      [&](std::optional<double> from) {
        const std::string work = fmt::format("estimating the intrinsics, pass {} of at most {}", ++pass, most_passes);
        on_pass(work);
        return Images(arguments, images, hooks, settings.images, from, work, times);
      },
      images.mask);
  if (!found) {
    const double used = 2 * InDegrees(std::atan(0.5 * size.width / images.camera.pinhole.fx));
    return {std::nullopt, NoTurn(arguments, settings.odometry.calibration_check.min_turn_deg, used, assumed)};
  }
  images.camera = found->camera;
  // The run reads the same images: it knows of their readout what was known before.
  images.camera.readout = given.readout;
  images.camera.readout_sigma = given.readout_sigma;
  images.camera.read_direction = given.read_direction;
  return {
      AtFullSize(images.scaling, *found),
      found->converged
          ? ""
          : "the estimate of the intrinsics did not converge; the stated sigma of the focal length may be too small"};
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/commands/drive_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core/utility.hpp>

#include "turnscale/base/error.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/camera/ray_difference.h"
#include "turnscale/commands/argument_checks.h"
#include "turnscale/commands/drive_camera.h"
#include "turnscale/frames/image_rotation.h"
#include "turnscale/frames/mask_file.h"
#include "turnscale/frames/seen_images.h"
#include "turnscale/geometry/angle.h"
#include "turnscale/io/terminal.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/odometry.h"
#include "turnscale/run/drive_recorder.h"
#include "turnscale/run/frame_warnings.h"
#include "turnscale/run/image_warnings.h"
#include "turnscale/run/missing_path.h"
#include "turnscale/run/run_summary.h"
#include "turnscale/run/settings.h"

namespace turnscale {
namespace {

GivenCamera CameraFor(const ImageArguments& arguments, const DriveInput& drive) {
  if (arguments.camera) return {arguments.camera->string(), ReadCameraFile(*arguments.camera), false};
  if (arguments.camera_object) return *arguments.camera_object;
  if (arguments.field_of_view) return {};
  if (drive.camera_file) return {drive.camera_file->string(), ReadCameraFile(*drive.camera_file), true};
  if (!drive.bags) return {};
  const std::optional<BagCamera> camera = ReadBagCamera(*drive.bags);
  return camera ? GivenCamera{camera->name, camera->model, true} : GivenCamera();
}

// Not checked where the size is not known, as then there is no image to use it with.
cv::Mat GivenMask(const std::optional<std::filesystem::path>& file, const cv::Size& size) {
  if (!file) return {};
  cv::Mat mask = ReadMask(*file);
  if (!size.empty()) CheckMaskSize(*file, mask, size);
  return mask;
}

// 0 if known neither from the video header nor from the user.
int ExpectedFrames(int count, std::optional<int> max_frames) {
  if (!max_frames) return count;
  return count > 0 ? std::min(*max_frames, count) : *max_frames;
}

namespace fs = std::filesystem;

// The first frame after initialisation without a measured pose; empty if there is none.
std::optional<int> FirstLost(const std::vector<FrameResult>& frames) {
  bool started = false;
  for (const FrameResult& frame : frames) {
    const bool tracked = frame.state == TrackingState::kTracked;
    if (frame.state == TrackingState::kRepeated) continue;
    if (started && !tracked) return frame.frame;
    started = started || tracked;
  }
  return std::nullopt;
}

std::vector<Trajectory> Stretches(std::span<const FrameResult> frames) {
  std::vector<Trajectory> stretches;
  bool open = false;
  for (const FrameResult& frame : frames) {
    // The step continues to the next image that is not a duplicate.
    if (frame.state == TrackingState::kRepeated) continue;
    const bool tracked = frame.is_measured();
    if (tracked && !open) stretches.emplace_back();
    if (tracked) stretches.back().push_back({frame.time, *frame.world_from_camera});
    open = tracked;
  }
  return stretches;
}

// As if the camera had been turned on the car as at the end all the time.
void TurnToLast(const MountCalibration& mount, std::vector<FrameResult>& frames) {
  for (FrameResult& frame : frames) {
    if (!frame.world_from_camera) continue;
    Eigen::Quaterniond& rotation = frame.world_from_camera->rotation;
    rotation = rotation * mount.FrameFromLast(frame.frame);
  }
}

// Why the stretches are not the whole path of the drive; empty if they are. `before`: the images before the map.
std::string WhyIncomplete(const std::vector<FrameResult>& frames, const ImageSource& source, const SeenImages& before) {
  // A way that is missing makes a lever arm from the distance too long by the same share; a tape is hardly better than
  // this. A map needs some images to begin, so that the first two seconds do not count (IsLate).
  constexpr double kLeastShare = 0.02;
  if (!source.left_out().empty()) return source.left_out().front();
  const std::optional<MissingPart> unmapped = PartBeforeMap(frames);
  if (unmapped && IsLate(*unmapped, frames, kLeastShare))
    if (std::string why =
            LateBeginningText(SinceFirst(*unmapped, source.first_time()), static_cast<int>(frames.size()), before);
        !why.empty())
      return why;
  if (const auto lost = FirstLost(frames)) return fmt::format("tracking was lost at frame {}", *lost);
  if (!source.Lacks().empty()) return source.Lacks();
  return source.EndsEarly();
}

enum class LoopEnd { kEndOfDrive, kInterrupted };

// Processes the frames up to the end of the drive or of the part that was asked for, or to an interrupt. A run stops
// otherwise (RunDrive): it reads one frame more, to say whether the drive goes on.
LoopEnd ProcessFrames(const ImageArguments& arguments, ImageSource& source, const CommandHooks& hooks,
                      const Odometry& odometry, Progress& progress, DriveRecorder& recorder) {
  while (!(arguments.max_frames && recorder.frames() >= *arguments.max_frames)) {
    const std::optional<SourceFrame> frame = source.Next();
    if (hooks.interrupted()) return LoopEnd::kInterrupted;
    if (!frame) {
      for (const std::string& warning : {source.NoticeAtEnd(), source.EndsEarly()})
        if (!warning.empty()) progress.Warn(warning);
      return LoopEnd::kEndOfDrive;
    }
    if (!frame->notice.empty()) progress.Warn(frame->notice);
    ProcessFrame(*frame, recorder, progress);
    progress.Update(recorder.frames(), fmt::format("{} keyframes", odometry.map().keyframes.size()));
  }
  return LoopEnd::kEndOfDrive;
}

// What to do about a calibration whose principal point is not in the middle of the images.
std::string SizeAdvice(const Pinhole& pinhole, const cv::Size& size) {
  constexpr double kSameFactor = 1.1;
  constexpr double kOtherSize = 1.2;
  const double across = 2 * pinhole.cx / size.width;
  const double down = 2 * pinhole.cy / size.height;
  const double factor = std::sqrt(across * down);
  const bool is_scaled = across > 0 && down > 0 && std::max(across / down, down / across) < kSameFactor &&
                         std::max(factor, 1 / factor) > kOtherSize;
  if (!is_scaled) return "check that the calibration is of this camera, and of images of this size";
  // The principal point of a camera is only about in the middle.
  constexpr double kNear = 1.06;
  constexpr std::array kUsual = {0.25, 1 / 3.0, 0.5, 2 / 3.0, 0.75, 4 / 3.0, 1.5, 2.0, 3.0, 4.0};
  const auto* const usual =
      std::ranges::find_if(kUsual, [&](double f) { return std::max(f / factor, factor / f) < kNear; });
  return fmt::format(
      "the calibration seems to be of images {:.3g} times as wide and as high: divide its fx, fy, cx and cy by this "
      "factor",
      usual != kUsual.end() ? *usual : factor);
}

// Images that are too small, and a calibration that may be of others.
std::vector<std::string> DoubtsOf(const DriveImages& images) {
  constexpr double kFarOff = 0.08;  // of the image's width or height
  constexpr double kOtherShape = 0.02;
  constexpr int kLeastWidth = 240;  // pixels; at 160, recorded drives came out up to 48 % too long
  const cv::Size& size = images.full_size;
  if (size.empty()) return {};
  std::vector<std::string> doubts;
  if (size.width < kLeastWidth)
    doubts.push_back(
        fmt::format("the images are {}x{} pixels, too small for a reliable path: give images at least {} pixels wide",
                    size.width, size.height, kLeastWidth));
  if (images.given.name.empty()) return doubts;
  // The name of a bag's camera is no file.
  if (std::error_code none; fs::is_regular_file(images.given.name, none))
    if (std::string doubt = DoubtOfLens(images.given.name); !doubt.empty()) doubts.push_back(std::move(doubt));
  const CameraModel& given = images.given.model;
  const bool central = std::abs(given.pinhole.cx / size.width - 0.5) < kFarOff &&
                       std::abs(given.pinhole.cy / size.height - 0.5) < kFarOff;
  if (given.width == 0 && !central)
    doubts.push_back(fmt::format("{}: the principal point ({:.0f}, {:.0f}) is far from the centre of {}x{} images; {}",
                                 images.given.name, given.pinhole.cx, given.pinhole.cy, size.width, size.height,
                                 SizeAdvice(given.pinhole, size)));
  // Only where the video says that its pixels are not square: most say nothing.
  const double shape = given.pinhole.fy / given.pinhole.fx;
  const double aspect = images.source.pixel_aspect();
  if (aspect != 1 && std::abs(shape / aspect - 1) > kOtherShape)
    doubts.push_back(fmt::format(
        "{}: fy / fx is {:.3f}, but it is {:.3f} by the pixel aspect ratio that the video states; check that the "
        "calibration is for these images",
        images.given.name, shape, aspect));
  return doubts;
}

// One line where a drive is read without a calibration though a file of one lies beside it; else empty. Beside a video
// is its folder, beside a folder of images also the one that it is in: KITTI has image_0/ beside calib.txt.
std::string UnusedCamera(const ImageArguments& arguments, const DriveImages& images) {
  std::error_code none;
  if (!images.given.name.empty() || arguments.field_of_view) return {};
  const fs::path& input = arguments.inputs.front();
  std::vector<fs::path> folders = {input.parent_path()};
  const bool is_folder = !fs::is_regular_file(input, none);
  if (is_folder) {
    if (images.drive.images.empty()) return {};
    // With the dots and links of a path, its folder is not what stands before its last name.
    folders = {images.drive.path, fs::canonical(images.drive.path, none).parent_path()};
  }
  for (const fs::path& folder : folders) {
    for (const char* name : {"calib.txt", "camera.yaml"}) {
      const fs::path file = folder / name;
      if (fs::is_regular_file(file, none))
        return fmt::format("{}: is not used; give --camera {} if it is this camera's{}", file.string(), file.string(),
                           is_folder ? "" : ", or the folder as the input");
    }
  }
  return {};
}

// One line where the calibration that was found beside the input and another one there are not of the same camera; else
// empty.
std::string OtherCamera(const ImageArguments& arguments, const DriveImages& images) {
  constexpr double kSame = 0.3 / kDegreesPerRadian;
  const DriveInput& drive = images.drive;
  if (!drive.camera_file || !drive.unused_camera_file || images.full_size.empty()) return {};
  const bool is_chosen = arguments.camera || arguments.camera_object || arguments.field_of_view;
  if (is_chosen) return {};
  CameraModel used;
  CameraModel other;
  try {
    used = ReadCameraFile(*drive.camera_file);
    other = ReadCameraFile(*drive.unused_camera_file);
  } catch (const InputError&) {
    // The name alone does not make it a calibration.
    return {};
  }
  // The files are of the images before they are rotated.
  cv::Size size = images.full_size;
  if (arguments.rotate % 180 != 0) std::swap(size.width, size.height);
  const std::optional<RayDifference> difference = LargestRayDifference(used, other, size.width, size.height);
  if (difference && difference->angle < kSame) return {};
  return fmt::format(
      "{}: is used, with the focal length {:.4g} pixels; {} beside it has another calibration, {:.4g} pixels{}: "
      "give --camera with the right one, or take away the other",
      drive.camera_file->string(), used.pinhole.fx, drive.unused_camera_file->filename().string(), other.pinhole.fx,
      other.lens == used.lens ? "" : " and another lens model");
}

}  // namespace

ImageSourceOptions SourceOptions(const ImageArguments& arguments, const GivenCamera& given,
                                 const ImageOptions& image_options) {
  ImageSourceOptions options;
  options.timestamps = arguments.timestamps;
  options.fps = arguments.fps;
  if (!arguments.start.empty()) options.start = ParseDriveTime("--start", arguments.start);
  if (!arguments.end.empty()) options.end = ParseDriveTime("--end", arguments.end);
  options.rotate = arguments.rotate;
  options.width = given.model.width;
  options.height = given.model.height;
  if (given.is_of_stored && arguments.rotate % 180 != 0) std::swap(options.width, options.height);
  options.camera_file = given.name;
  options.images = image_options;
  return options;
}

std::string ImageArguments::Name() const {
  if (inputs.size() < 2) return inputs.empty() ? std::string() : inputs.front().string();
  return fmt::format("{} and {} more", inputs.front().string(), inputs.size() - 1);
}

void CheckImageArguments(const ImageArguments& arguments) {
  if (arguments.inputs.empty()) throw InputError("input: give the images of a drive");
  RefuseBoth({"--timestamps", arguments.timestamps.has_value()}, {"--fps", arguments.fps.has_value()});
  RefuseBoth({"--camera", arguments.camera || arguments.camera_object}, {"--fov", arguments.field_of_view.has_value()});
  if (arguments.max_frames && *arguments.max_frames < 1)
    throw InputError(fmt::format("--max-frames {}: give at least 1", *arguments.max_frames));
}

DriveImages OpenImages(const ImageArguments& arguments, const ImageOptions& image_options) {
  DriveInput drive = FindDrive(arguments.inputs, arguments.topic, arguments.mask.value_or(fs::path()));
  GivenCamera given = CameraFor(arguments, drive);
  ImageSource source(drive, SourceOptions(arguments, given, image_options));
  const cv::Size full_size = source.FullSize().value_or(cv::Size());
  if (given.is_of_stored) given = {given.name, Rotated(given.model, arguments.rotate, full_size), false};
  const ImageScaling scaling(full_size, image_options);
  CameraModel camera = scaling.Scaled(given.model);
  // Images that were rotated and encoded anew do not tell how the sensor has read them, but the file may.
  if (!camera.is_read_direction_stated) camera.read_direction = source.read_direction();
  const cv::Mat mask = scaling.ScaledMask(GivenMask(arguments.mask, full_size));
  const int expected = ExpectedFrames(source.count(), arguments.max_frames);
  return {std::move(drive), std::move(given), std::move(source), full_size, scaling, camera, mask, expected};
}

std::vector<std::string> WarningsOf(const ImageArguments& arguments, const DriveImages& images) {
  std::vector<std::string> warnings = images.source.left_out();
  if (!images.source.notice().empty()) warnings.push_back(images.source.notice());
  if (std::string unused = UnusedCamera(arguments, images); !unused.empty()) warnings.push_back(std::move(unused));
  if (std::string other = OtherCamera(arguments, images); !other.empty()) warnings.push_back(std::move(other));
  for (std::string& doubt : DoubtsOf(images)) warnings.push_back(std::move(doubt));
  return warnings;
}

namespace {

// Of poses that carry their frames' numbers as times.
Trajectory AtRate(Trajectory poses, double fps) {
  for (StampedPose& pose : poses) pose.time /= fps;
  return poses;
}

}  // namespace

TimedTrajectory ReadTimedTrajectory(const std::filesystem::path& path,
                                    const std::optional<std::filesystem::path>& timestamps, std::optional<double> fps) {
  if (fps && !(std::isfinite(*fps) && *fps > 0)) {
    throw InputError(fmt::format("--fps {}: give frames per second, above 0", *fps));
  }
  TrajectoryFile file = ReadTrajectoryFile(path);
  if (file.format != TrajectoryFormat::kKitti) {
    // SLAM that knows no times numbers its frames there.
    const bool numbers =
        std::ranges::all_of(file.poses, [](const StampedPose& pose) { return pose.time == std::floor(pose.time); });
    if (!fps && !timestamps) return {std::move(file.poses), true, numbers};
    if (fps && numbers) return {AtRate(std::move(file.poses), *fps), true};
    throw InputError(fmt::format("{}: has timestamps; leave out {}", path.string(), fps ? "--fps" : "--timestamps"));
  }
  if (fps) return {AtRate(std::move(file.poses), *fps), true};
  const std::filesystem::path times = timestamps ? *timestamps : FindPoseTimes(path);
  if (times.empty()) return {std::move(file.poses), false};
  return {ReadTrajectory(path, ReadFrameTimes(times).times), true};
}

DriveMotion MotionFromTrajectory(const fs::path& path, const std::optional<fs::path>& timestamps,
                                 std::optional<double> fps, std::optional<AxisConvention> axes) {
  constexpr double kUsualInterval = 0.1;
  DriveMotion motion;
  motion.input = path.string();
  TimedTrajectory trajectory = ReadTimedTrajectory(path, timestamps, fps);
  motion.timed = trajectory.timed;
  if (!motion.timed) {
    for (StampedPose& pose : trajectory.poses) pose.time *= kUsualInterval;
    motion.note = "no timestamps: 10 frames per second assumed";
  }
  if (trajectory.whole_numbers) motion.note = "the times are whole numbers; if they are numbers of frames, give --fps";
  const AxisConvention found = axes ? *axes : FindAxisConvention(StepsAlong(trajectory.poses));
  if (!axes && found != AxisConvention::kCamera) {
    motion.note +=
        std::string(motion.note.empty() ? "" : "; ") +
        "vehicle axes detected (x forward); y left and z up assumed, and angles are those of a camera that looks "
        "along x; if y is right and z down, yaw and pitch have the opposite sign: give --axes frd";
  }
  if (const auto gap = FirstGap(trajectory.poses)) {
    motion.incomplete = fmt::format("the trajectory has a gap after {:.1f} s", *gap);
  }
  motion.stretches.push_back(InCameraAxes(std::move(trajectory.poses), found));
  return motion;
}

DriveMotion MotionFromImages(const ImageArguments& arguments, const CommandHooks& hooks) {
  CheckImageArguments(arguments);
  Settings settings = arguments.settings ? ReadSettings(*arguments.settings) : Settings();
  settings.odometry = WithoutMetres(settings.odometry);
  settings.Check();
  DriveImages images = OpenImages(arguments, settings.images);
  cv::setNumThreads(kImageThreads);
  hooks.begun();
  for (const std::string& warning : WarningsOf(arguments, images)) Warn(hooks, warning);
  const CameraEstimate estimate = EstimateCamera(arguments, images, settings, hooks);
  Odometry odometry(settings.odometry, images.camera);
  if (!images.mask.empty()) odometry.SetMask(images.mask);
  Progress progress(images.expected, arguments.quiet);
  SendWarnings(progress, hooks);
  if (!estimate.warning.empty()) progress.Warn(estimate.warning);
  DriveRecorder recorder(odometry, images.scaling);
  Attempts attempts;
  LoopEnd end = LoopEnd::kEndOfDrive;
  attempts.Try([&] { end = ProcessFrames(arguments, images.source, hooks, odometry, progress, recorder); });
  progress.Finish();
  attempts.Try([&] { recorder.Finish(); });
  DriveMotion motion;
  motion.input = arguments.Name();
  if (estimate.found)
    motion.note = fmt::format("intrinsics estimated from the drive: focal length {} pixels",
                              FocalLengthText(estimate.found->camera));
  auto [frames, scale, blending] = recorder.Refined();
  constexpr auto kError = "the rotation and the lever arm may be wrong";
  const ImageFindings findings{.is_upside_down = odometry.is_upside_down(),
                               .rotated = arguments.rotate,
                               .blending = blending,
                               .contradicted_calibration = scale.contradicted_calibration,
                               .doubtful_calibration = {},
                               .is_calibration_refined = estimate.found.has_value(),
                               .has_distortion = images.camera.lens != LensModel::kPinhole,
                               .consequences = {}};
  for (const std::string& warning : ImageWarnings(findings, images.source.first_time(), kError, kError))
    progress.Warn(warning);
  if (const std::string warning = ContradictedReadoutText(scale); !warning.empty()) progress.Warn(warning);
  const MountCalibration& mount = odometry.mount();
  const std::vector<MountJump> jumps = mount.jumps();
  for (std::size_t i = 0; i < jumps.size(); ++i) {
    const bool last = i + 1 == jumps.size();
    progress.Warn(CameraJumpText(jumps[i], images.source.first_time()) +
                  (last ? "; the rotation is that after it, for other drives than this one" : ""));
  }
  if (!jumps.empty()) TurnToLast(mount, frames);
  const int moved_at = mount.moves() > 0 ? odometry.map().keyframes[mount.current().first_keyframe].frame : 0;
  std::string moved;
  if (moved_at > 0) {
    moved = fmt::format("the camera was moved on the car before frame {} (at {:.1f} s)", moved_at,
                        frames[moved_at].time - images.source.first_time());
    progress.Warn(moved + ": only what follows is used");
  }
  motion.calibration_sigma = scale.calibration_sigma;
  motion.stretches = Stretches(std::span(frames).subspan(moved_at));
  if (motion.stretches.empty()) attempts.RethrowFirst();
  if (!moved.empty())
    motion.incomplete = moved;
  else if (!motion.stretches.empty())
    motion.incomplete = WhyIncomplete(frames, images.source, recorder.seen());
  if (end == LoopEnd::kInterrupted)
    motion.stopped = {kInterruptedExitCode, fmt::format("interrupted after {} frames", recorder.frames())};
  if (!attempts.failures().empty()) motion.stopped = FailureOf(attempts.failures().front());
  if (motion.stopped) motion.incomplete = motion.stopped->message;
  return motion;
}

}  // namespace turnscale

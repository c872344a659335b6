// SPDX-License-Identifier: MIT
#include "drive_motion.h"

#include <fmt/format.h>

#include "interrupt.h"
#include "turnscale/base/error.h"
#include "turnscale/calibration/axis_convention.h"
#include "turnscale/calibration/step_gatherer.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/io/frame_times.h"
#include "turnscale/io/image_source.h"
#include "turnscale/io/progress.h"
#include "turnscale/io/settings.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/odometry/odometry.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

std::vector<Trajectory> Stretches(const std::vector<FrameResult>& frames) {
  std::vector<Trajectory> stretches;
  bool open = false;
  for (const FrameResult& frame : frames) {
    const bool tracked = frame.state == TrackingState::kTracked && frame.world_from_camera;
    if (tracked && !open) stretches.emplace_back();
    if (tracked) stretches.back().push_back({frame.time, *frame.world_from_camera});
    open = tracked;
  }
  return stretches;
}

fs::path CameraFileFor(const ImageArguments& arguments, const DriveInput& drive) {
  if (arguments.camera) return *arguments.camera;
  if (drive.camera_file) return *drive.camera_file;
  throw InputError(arguments.input.string() + ": comes without a calibration of its own; give --camera FILE");
}

}  // namespace

DriveMotion MotionFromTrajectory(const fs::path& path, const std::optional<fs::path>& timestamps) {
  constexpr double kUsualInterval = 0.1;
  DriveMotion motion;
  motion.input = path.string();
  TrajectoryFile file = ReadTrajectoryFile(path);
  if (file.format == TrajectoryFormat::kKitti) {
    const fs::path times = timestamps ? *timestamps : FindPoseTimes(path);
    if (!times.empty()) {
      file = ReadTrajectoryFile(path, ReadFrameTimes(times).times);
    } else {
      for (StampedPose& pose : file.poses) pose.time *= kUsualInterval;
      motion.note = "no times: taken as 10 frames a second";
    }
  } else if (timestamps) {
    throw InputError(timestamps->string() + ": is of no use, as " + path.string() + " has times of its own");
  }
  if (FindAxisConvention(StepsAlong(file.poses)) == AxisConvention::kVehicle) {
    file.poses = InCameraAxes(std::move(file.poses));
    motion.note += std::string(motion.note.empty() ? "" : "; ") +
                   "vehicle axes found (x forward, y left, z up): angles are those of a camera that looks along x";
  }
  motion.stretches.push_back(std::move(file.poses));
  return motion;
}

DriveMotion MotionFromImages(const ImageArguments& arguments) {
  OdometryOptions options = arguments.settings ? ReadSettings(*arguments.settings) : OdometryOptions();
  options.vehicle.lever_arm.reset();
  options.Check();
  const DriveInput drive = FindDrive(arguments.input);
  const fs::path camera_file = CameraFileFor(arguments, drive);
  const CameraModel camera = ReadCameraFile(camera_file);
  ImageSource source(drive, {arguments.timestamps, arguments.fps, camera.width, camera.height, camera_file.string()});
  Odometry odometry(options, camera);
  CatchInterrupts();
  Progress progress(arguments.max_frames.value_or(source.count()), arguments.quiet);
  int processed = 0;
  while (!Interrupted() && !(arguments.max_frames && processed >= *arguments.max_frames)) {
    const std::optional<SourceFrame> frame = source.Next();
    if (!frame) break;
    if (frame->gray.empty()) {
      progress.Warn(fmt::format("frame {}: {}; skipped", frame->index, frame->problem));
      odometry.ProcessUnreadable(frame->time);
    } else {
      odometry.Process(frame->gray, frame->time);
    }
    progress.Update(++processed, fmt::format("{} keyframes", odometry.map().keyframes.size()));
  }
  progress.Finish();
  odometry.Finish();
  DriveMotion motion;
  motion.input = arguments.input.string();
  motion.stretches = Stretches(odometry.RefinedFrames());
  if (Interrupted()) motion.note = fmt::format("interrupted after {} frames", processed);
  return motion;
}

}  // namespace turnscale

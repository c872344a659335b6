// SPDX-License-Identifier: MIT
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <opencv2/core/utility.hpp>

#include "commands.h"
#include "common_options.h"
#include "interrupt.h"
#include "program.h"
#include "turnscale/base/error.h"
#include "turnscale/commands/command_hooks.h"
#include "turnscale/commands/version.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/terminal.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/kinematics/turn_detector.h"
#include "turnscale/simulation/drive_recorder.h"
#include "turnscale/simulation/image_output.h"
#include "turnscale/simulation/rig.h"
#include "turnscale/simulation/route.h"
#include "turnscale/simulation/world.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr double kGarageSeconds = 60;
constexpr double kStreetSeconds = 120;
constexpr int kMaxThreads = 1024;
constexpr double kMinSeconds = 5;
constexpr double kMaxSeconds = 1800;

struct SimulateArguments {
  std::string world;
  fs::path out;
  unsigned seed = 1;
  std::optional<fs::path> rig;
  bool video = false;
  std::optional<double> seconds;
  std::optional<fs::path> follow;
  std::optional<fs::path> times;
  double texture_contrast = 1;
  std::optional<int> threads;
  std::optional<int> max_frames;
  bool quiet = false;
};

void Check(const SimulateArguments& arguments) {
  if (arguments.seconds && !(*arguments.seconds >= kMinSeconds && *arguments.seconds <= kMaxSeconds)) {
    throw InputError(fmt::format("--seconds {}: give {} to {}", *arguments.seconds, kMinSeconds, kMaxSeconds));
  }
  if (!(arguments.texture_contrast >= 0 && arguments.texture_contrast <= 1)) {
    throw InputError(fmt::format("--texture-contrast {}: give 0 to 1", arguments.texture_contrast));
  }
  if (arguments.threads && (*arguments.threads < 1 || *arguments.threads > kMaxThreads)) {
    throw InputError(fmt::format("--threads {}: give 1 to {}", *arguments.threads, kMaxThreads));
  }
  if (arguments.follow && arguments.world != "street") {
    throw InputError(
        fmt::format("--follow: only a street can follow a recorded trajectory, not a {}", arguments.world));
  }
}

Trajectory ReadFollowed(const SimulateArguments& arguments) {
  const fs::path& path = *arguments.follow;
  TrajectoryFile file = ReadTrajectoryFile(path);
  if (file.format == TrajectoryFormat::kKitti) {
    const fs::path times = arguments.times ? *arguments.times : FindPoseTimes(path);
    if (times.empty()) throw InputError(path.string() + ": has no timestamps; give --times FILE");
    file = ReadTrajectoryFile(path, ReadFrameTimes(times).times);
  } else if (arguments.times) {
    throw InputError(arguments.times->string() + ": is not needed, since " + path.string() + " has timestamps");
  }
  Trajectory trajectory = std::move(file.poses);
  if (arguments.seconds) {
    const double end = trajectory.front().time + *arguments.seconds;
    std::erase_if(trajectory, [&](const StampedPose& pose) { return pose.time > end; });
  }
  return trajectory;
}

World MakeFollowingStreet(const SimulateArguments& arguments, const Rig& rig) {
  const Trajectory trajectory = ReadFollowed(arguments);
  try {
    const RecordedPath path = RearAxlePath(trajectory, rig.mount.VehicleFromCamera());
    return MakeStreetAlong(arguments.seed, path.points, path.speeds);
  } catch (const InputError& error) {
    // Errors of the trajectory do not name its file.
    throw InputError(arguments.follow->string() + ": " + error.what());
  }
}

// Approximate duration; empty if given by the followed trajectory.
std::optional<double> Seconds(const SimulateArguments& arguments) {
  if (arguments.seconds || arguments.follow) return arguments.seconds;
  return arguments.world == "garage" ? kGarageSeconds : kStreetSeconds;
}

World MakeWorld(const SimulateArguments& arguments, const Rig& rig) {
  if (arguments.follow) return MakeFollowingStreet(arguments, rig);
  const double seconds = Seconds(arguments).value();
  return arguments.world == "garage" ? MakeGarage(arguments.seed, seconds) : MakeStreet(arguments.seed, seconds);
}

// With the values of a preset, or of a file.
Rig BaseRig(const SimulateArguments& arguments) {
  const RigPreset preset = arguments.follow ? RigPreset::kKitti : RigPreset::kPaper;
  if (!arguments.rig) return MakeRig(preset);
  const std::optional<RigPreset> named = FindRigPreset(arguments.rig->string());
  return named ? MakeRig(*named) : ReadRig(*arguments.rig, preset);
}

Rig RigFor(const SimulateArguments& arguments) {
  Rig rig = BaseRig(arguments);
  if (arguments.video) rig.recorder.video = true;
  return rig;
}

// One line where a drive takes longer than was asked for; else empty.
std::string LongerThanAsked(const SimulateArguments& arguments, double seconds) {
  constexpr double kApproximate = 1.25;
  if (!arguments.seconds || arguments.follow || seconds < kApproximate * *arguments.seconds) return {};
  return fmt::format("--seconds {}: the shortest {} drive takes {:.1f} s; --max-frames ends it earlier",
                     *arguments.seconds, arguments.world, seconds);
}

// The command that estimates the drive in metres. Without a turn, only the height of the camera gives the scale.
std::string NextCommand(const std::string& input, const CameraMount& mount, double turned) {
  // The angles of all curves count here, also of those that are too gentle to be turns.
  constexpr double kSurelyTurns = 3;
  std::string command = fmt::format("turnscale run {} --lever-arm {:g}", input, mount.lever_arm);
  if (turned < kSurelyTurns * TurnDetectorOptions().min_region_angle)
    command += fmt::format(" --camera-height {:g}", mount.height);
  return command;
}

// Returns the exit code.
int Simulate(const SimulateArguments& arguments) {
  Check(arguments);
  const Rig rig = RigFor(arguments);
  const int threads = arguments.threads.value_or(static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
  cv::setNumThreads(threads);
  World world = MakeWorld(arguments, rig);
  for (RepeatedPattern& pattern : world.scene.patterns)
    pattern.contrast = static_cast<float>(arguments.texture_contrast);
  CatchInterrupts();
  bool lighting = false;
  std::optional<Progress> progress;
  const auto report = [&](int done, int frames) {
    if (!lighting) {
      lighting = true;
      if (const std::string longer = LongerThanAsked(arguments, frames / rig.rate_hz); !longer.empty())
        PrintMessage("warning: " + longer);
      if (!arguments.quiet) PrintMessage(fmt::format("{} of {} frames: lighting the scene", arguments.world, frames));
      return !Interrupted();
    }
    // Begins now, so that the rate is that of the frames.
    if (!progress) progress.emplace(frames, arguments.quiet);
    progress->Update(done);
    return !Interrupted();
  };
  const DriveOrigin origin = {Version(), arguments.world, Seconds(arguments), arguments.follow,
                              arguments.texture_contrast};
  const auto start = std::chrono::steady_clock::now();
  const Recording recording = RecordDrive(std::move(world), rig, arguments.seed,
                                          {arguments.out, arguments.max_frames, threads, origin}, report);
  if (progress) progress->Finish();
  if (!recording.complete) {
    return Report({kInterruptedExitCode, fmt::format("interrupted after {} frames; {} is incomplete", recording.frames,
                                                     arguments.out.string())});
  }
  if (arguments.quiet) return 0;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::string out = arguments.out.string();
  const std::string input = rig.recorder.video ? (arguments.out / kVideoFile).string() : out;
  PrintText(fmt::format("drive   {} frames, {:.1f} s, {:.1f} m, {:.0f} deg of turning\n", recording.frames,
                        recording.seconds, recording.metres, recording.turned * kDegreesPerRadian) +
            fmt::format("cost    {:.1f} s, {:.2f} frames/s\n", seconds, recording.frames / seconds) +
            fmt::format("files   {}\nnext    {}\n", out, NextCommand(input, rig.mount, recording.turned)));
  return 0;
}

}  // namespace

void AddSimulateCommand(CLI::App& app) {
  CLI::App* simulate = app.add_subcommand(kSimulateCommand.name, kSimulateCommand.what);
  auto arguments = std::make_shared<SimulateArguments>();
  simulate->add_option("world", arguments->world, "garage or street")
      ->required()
      ->check(CLI::IsMember({"garage", "street"}));
  simulate->add_option("--out", arguments->out, "Folder for the drive")->required();
  simulate->add_option("--seed", arguments->seed, "Seed of the scene, the drive and the sensor noise")
      ->capture_default_str();
  simulate->add_option(
      "--rig", arguments->rig,
      "paper, kitti, dashcam, or a YAML file with camera, mount, car, sensor, windscreen and recorder, "
      "such as rig.yaml of another drive [paper; with --follow kitti]");
  simulate->add_flag("--video", arguments->video, "Write video.mp4 rather than images; the rig dashcam always does");
  simulate->add_option(
      "--seconds", arguments->seconds,
      "Approximate duration; the shortest garage drive takes 15, the shortest street drive 12 [garage 60, "
      "street 120]");
  CLI::Option* follow = simulate->add_option(
      "--follow", arguments->follow,
      "Build the street along a recorded metric trajectory: TUM or KITTI poses of a camera mounted like the rig's");
  simulate
      ->add_option("--times", arguments->times,
                   fmt::format("Times of the --follow poses, {} [times.txt beside the --follow file]", kTimesPerLine))
      ->needs(follow);
  simulate
      ->add_option("--texture-contrast", arguments->texture_contrast,
                   "Contrast of all textures, 1 (unchanged) to 0 (uniform)")
      ->capture_default_str();
  simulate->add_option("--threads", arguments->threads, "Number of threads; does not affect the images [all cores]");
  simulate->add_option("--max-frames", arguments->max_frames, "Stop after this many frames")
      ->check(CLI::Range(1, 1'000'000'000));
  simulate->add_flag("--quiet", arguments->quiet, "Print warnings and errors only");
  simulate->footer(
      "Example:\n  turnscale simulate garage --out drives/garage --seed 7\n"
      "  turnscale run drives/garage --lever-arm 1.5\n\n"
      "Output: a KITTI folder (image_0/ or video.mp4, calib.txt, times.txt, poses.txt) with camera.yaml, "
      "vehicle.yaml,\n"
      "truth.csv, floor_plan.csv, rig.yaml and drive.yaml. times.txt is written last: a folder without it is "
      "incomplete.\n"
      "Where the recorded trajectory stops, the simulated car creeps on at 0.2 m/s; reversing is not reproduced.");
  simulate->callback([arguments] {
    if (const int exit_code = Simulate(*arguments); exit_code != 0) throw CLI::RuntimeError(exit_code);
  });
}

}  // namespace turnscale

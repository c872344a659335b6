// SPDX-License-Identifier: MIT
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "commands.h"
#include "common_options.h"
#include "interrupt.h"
#include "turnscale/base/file_text.h"
#include "turnscale/commands/run_command.h"
#include "turnscale/commands/version.h"
#include "turnscale/io/terminal.h"
#include "turnscale/live/live_page.h"
#include "turnscale/odometry/odometry.h"
#include "turnscale/run/settings.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

struct LiveArguments {
  bool live = false;
  std::string address = "127.0.0.1:0";
};

// The page that shows the run while it goes on.
class LiveView {
 public:
  LiveView(const RunArguments& arguments, const std::string& address, int frames, double first_time)
      : state_(arguments.images.Name(), Version(), frames, first_time,
               arguments.no_report ? "" : fs::absolute(arguments.out / kReportFile).lexically_normal().string()),
        page_(ParseLiveAddress("--live-address", address), state_) {
    PrintText("live    " + page_.address() + "\n");
  }

  void WaitWhilePaused() const { page_.WaitWhilePaused(Interrupted); }
  void Add(const SourceFrame& frame, const FrameResult& result, const Odometry& odometry) {
    state_.Add(frame.gray, result, odometry);
  }
  void Warn(const std::string& warning) { state_.AddWarning(warning); }
  void SetPhase(const std::string& phase) { state_.SetPhase(phase); }
  // An interrupt ends the wait for viewers, unless it has ended the run already.
  void Finish(const fs::path& report, bool interrupted) {
    page_.Finish(FileText(report).value_or(""), [interrupted] { return !interrupted && Interrupted(); });
  }

 private:
  LiveState state_;
  LivePage page_;
};

// Says what went wrong; returns the exit code.
int ReportEnd(const RunEnd& end) {
  const std::optional<RunFailure> failure = FailureOfRun(end);
  if (!failure) return 0;
  for (const std::string& other : failure->others) PrintMessage("warning: " + other);
  Failure first = failure->first;
  if (failure->kept) first.message += "; the results so far are in " + end.summary.drive.given.folder;
  return Report(first);
}

// Returns the exit code.
int RunImages(const RunArguments& arguments, const LiveArguments& live_arguments) {
  EndOnInterrupts();
  std::optional<LiveView> live;
  RunHooks hooks;
  hooks.interrupted = Interrupted;
  hooks.begun = CatchInterrupts;
  if (live_arguments.live) {
    hooks.opened = [&](int frames, double first_time) {
      live.emplace(arguments, live_arguments.address, frames, first_time);
    };
    hooks.warn = [&](const std::string& warning) { live->Warn(warning); };
    hooks.phase = [&](const std::string& phase) { live->SetPhase(phase); };
    hooks.before_frame = [&] { live->WaitWhilePaused(); };
    hooks.watch = [&](const SourceFrame& frame, const FrameResult& result, const Odometry& odometry) {
      live->Add(frame, result, odometry);
    };
  }
  const RunEnd end = ExecuteRun(arguments, hooks);
  if (live) live->Finish(end.written ? arguments.out / kReportFile : fs::path(), end.interrupted);
  const bool has_nothing = !end.nothing_tracked.empty() || (end.interrupted && !end.begun);
  if (end.failures.empty() && !has_nothing) {
    if (!arguments.images.quiet)
      PrintText(SummaryText(end.summary));
    else if (end.summary.drive.wants_metres() && !end.summary.scale.is_metric())
      PrintMessage("warning: " + UpToScaleText(end.summary.scale.pending_reason));
  }
  return ReportEnd(end);
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  CLI::App* run = app.add_subcommand("run", "Estimate the trajectory of a drive from its images.");
  auto arguments = std::make_shared<RunArguments>();
  auto live_arguments = std::make_shared<LiveArguments>();
  run->add_option("input", arguments->images.inputs,
                  "KITTI folder (with the images in image_0/ or images/), folder of images, video, several "
                  "consecutive clips, folder of clips, or bags (.bag, .mcap, .db3); a folder can also contain "
                  "calib.txt or camera.yaml, and times.txt")
      ->required();
  AddCameraOptions(*run, arguments->images);
  CLI::Option* timestamps =
      run->add_option("--timestamps", arguments->images.timestamps,
                      fmt::format("Times of the frames, {} [times.txt in the input folder]", kTimesPerLine));
  run->add_option("--fps", arguments->images.fps,
                  "Frames per second; overrides times.txt, a video's own time stamps and the header stamps of a bag")
      ->excludes(timestamps);
  run->add_option("--lever-arm", arguments->car.lever_arm,
                  "Horizontal distance from the rear axle forward to the camera, metres; without it, --camera-height "
                  "and --vehicle the trajectory is up to scale");
  run->add_option("--lever-arm-sigma", arguments->car.lever_arm_sigma,
                  fmt::format("Standard deviation of --lever-arm, metres [{}]", kTapeSigma));
  run->add_option(
      "--camera-height", arguments->car.camera_height,
      "Height of the camera above the road, metres, or H,SIGMA: gives metric scale without a turn, and checks the "
      "lever arm [estimated in turns; SIGMA: 1 % of H]");
  run->add_option("--vehicle", arguments->car.vehicle,
                  "YAML file of the car: car.yaml of an earlier run, or calibration.yaml of calibrate. Lever arm, side "
                  "slip, camera rotation and camera height are taken from it and refined; other options override it");
  AddSideSlipOptions(*run, arguments->car.side_slip, arguments->car.side_slip_sigma);
  run->add_option(
      "--camera-rotation", arguments->car.camera_rotation,
      "Camera-to-vehicle rotation: yaw,pitch,roll in degrees, positive to the right, up, to the right; a YAML file "
      "with yaw_deg, pitch_deg, roll_deg, such as calibrate writes; or auto: estimated during the drive [that of "
      "--vehicle or "
      "--settings, else auto]");
  run->add_option(
         "--method", arguments->car.method,
         "How metric scale is obtained. smoothed: one estimate along the drive, from all turns; turns: each turn's "
         "scale from this turn alone, to which a final bundle adjustment constrains it; paper: the same for each pair "
         "of consecutive keyframes in a turn (equation (22) of the paper by Kim et al.) [smoothed]")
      ->check(CLI::IsMember(ScaleMethodNames()));
  run->add_option("--frame", arguments->frame, "Write poses of the camera or of the vehicle (rear axle)")
      ->check(CLI::IsMember({"camera", "vehicle"}))
      ->capture_default_str();
  run->add_option("--threads", arguments->threads, "Number of threads; does not affect the result")
      ->capture_default_str();
  run->add_option("--settings", arguments->images.settings,
                  "YAML file with settings, such as settings.yaml of another run");
  run->add_option("--out", arguments->out, "Folder for the results")->capture_default_str();
  AddTruthOptions(*run, arguments->truth);
  run->add_flag("--no-report", arguments->no_report, "Write no page (report.html) and no thumbnails");
  CLI::Option* live =
      run->add_flag("--live", live_arguments->live, "Show the run while it goes on: prints the address of a page");
  run->add_option("--live-address", live_arguments->address,
                  "Where the page listens: HOST:PORT of this machine; port 0: a free one")
      ->needs(live)
      ->capture_default_str();
  AddPartOptions(*run, arguments->images);
  run->add_option("--max-frames", arguments->images.max_frames, "Stop after this many frames")
      ->check(CLI::Range(1, 1'000'000'000));
  run->add_flag("--quiet", arguments->images.quiet, "Print warnings and errors only");
  run->footer(
      "Examples:\n  turnscale run drive.mp4 --lever-arm 1.45 --out out/drive\n"
      "  turnscale run next.mp4 --vehicle out/drive/car.yaml --camera out/drive/camera.yaml --out out/next\n"
      "  turnscale run DCIM/ --camera out/drive/camera.yaml --lever-arm 1.45 --start 1:30 --end 12:00\n\n"
      "Output: trajectory.tum and trajectory.kitti.txt (refined, every frame), live.tum (online: each pose as\n"
      "estimated at its frame), trajectory.csv, speed.csv, turns.csv, scale.csv, camera_rotation.csv, map.ply,\n"
      "car.yaml (estimated parameters of the car, for --vehicle),\n"
      "camera.yaml (intrinsics, if estimated), mask.png (pixels left out, if any), settings.yaml, summary.json and\n"
      "report.html, a page that shows them. Ctrl-C stops after the current frame\n"
      "and keeps the results so far (exit code 130).");
  run->callback([arguments, live_arguments] {
    if (const int exit_code = RunImages(*arguments, *live_arguments); exit_code != 0)
      throw CLI::RuntimeError(exit_code);
  });
}

}  // namespace turnscale

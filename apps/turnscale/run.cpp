// SPDX-License-Identifier: MIT
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <opencv2/core/utility.hpp>

#include "car_arguments.h"
#include "commands.h"
#include "drive_images.h"
#include "interrupt.h"
#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/progress.h"
#include "turnscale/io/run_summary.h"
#include "turnscale/io/run_writer.h"
#include "turnscale/io/settings.h"
#include "turnscale/odometry/odometry.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

struct RunArguments {
  ImageArguments images;
  std::optional<double> lever_arm;
  std::optional<double> lever_arm_sigma;
  std::optional<double> side_slip;
  std::optional<double> side_slip_sigma;
  std::string camera_rotation;
  std::optional<std::string> method;
  std::string frame = "camera";
  int threads = kImageThreads;
  fs::path out = "out";
};

// Settings file, overridden by the command line. Checked here so that messages name the option.
OdometryOptions OptionsFrom(const RunArguments& arguments) {
  OdometryOptions options = arguments.images.settings ? ReadSettings(*arguments.images.settings) : OdometryOptions();
  if (arguments.lever_arm) options.vehicle.lever_arm = CheckedLeverArm(*arguments.lever_arm);
  if (arguments.lever_arm_sigma) options.vehicle.lever_arm_sigma = CheckedLeverArmSigma(*arguments.lever_arm_sigma);
  if (arguments.side_slip) {
    options.vehicle.side_slip = CheckedSideSlip(*arguments.side_slip);
    options.vehicle.side_slip_sigma = kGivenSideSlipSigma * *arguments.side_slip;
  }
  if (arguments.side_slip_sigma) options.vehicle.side_slip_sigma = CheckedSideSlipSigma(*arguments.side_slip_sigma);
  if (arguments.camera_rotation == "auto") {
    options.vehicle.calibrate_camera = true;
  } else if (!arguments.camera_rotation.empty()) {
    options.vehicle.vehicle_from_camera = ReadCameraRotation(arguments.camera_rotation);
    options.vehicle.calibrate_camera = false;
  }
  if (arguments.method)
    options.scale.method = *arguments.method == "paper"   ? ScaleMethod::kPaper
                           : *arguments.method == "turns" ? ScaleMethod::kTurns
                                                          : ScaleMethod::kSmoothed;
  if (arguments.threads < 1) throw InputError(fmt::format("--threads {}: give at least 1", arguments.threads));
  options.Check();
  return options;
}

// One drive from its first image to its files.
class Run {
 public:
  explicit Run(const RunArguments& arguments)
      : arguments_(arguments),
        options_(OptionsFrom(arguments)),
        images_(arguments.images),
        odometry_(options_, images_.camera) {}

  // Returns the exit code.
  int Go() {
    cv::setNumThreads(arguments_.threads);
    // Before the folder is made: an image of the wrong size leaves no trace.
    std::optional<SourceFrame> frame = images_.source.Next();
    writer_.emplace(RunWriterOptions{
        arguments_.out, arguments_.frame == "vehicle" ? PoseFrame::kVehicle : PoseFrame::kCamera, options_.vehicle});
    writer_->WriteText("settings.yaml", SettingsText(odometry_.options()));
    CatchInterrupts();
    Progress progress(images_.expected, arguments_.images.quiet);
    if (const std::string doubt = frame ? DoubtOf(images_, frame->gray) : ""; !doubt.empty()) progress.Warn(doubt);
    try {
      for (; frame && !Interrupted() && !Enough(); frame = images_.source.Next()) Process(*frame, progress);
      if (Interrupted())
        summary_.stopped = fmt::format("interrupted after {} frames", processed_);
      else if (Enough() && frame)
        summary_.stopped = fmt::format("--max-frames {}", *arguments_.images.max_frames);
      else if (!Enough() && EndedEarly()) {
        summary_.stopped = fmt::format("the video ends after {} of {} frames", processed_, images_.source.count());
        progress.Warn(fmt::format("{}: {}", images_.drive.path.string(), summary_.stopped));
      }
    } catch (const InputError& error) {
      progress.Finish();
      summary_.stopped = error.what();
      WriteResults();
      throw;
    }
    progress.Finish();
    WriteResults();
    if (!arguments_.images.quiet) WriteStandardOutput(SummaryText(summary_));
    if (!Interrupted()) return 0;
    fmt::print(stderr, "turnscale: {}; the results so far are in {}\n", summary_.stopped, arguments_.out.string());
    return kInterruptedExitCode;
  }

 private:
  bool Enough() const { return arguments_.images.max_frames && processed_ >= *arguments_.images.max_frames; }

  // Some containers only estimate how many frames they hold; a sound video may have a few less.
  bool EndedEarly() const {
    constexpr int kFewFrames = 2;
    const int missing = images_.source.count() - processed_;
    return missing > kFewFrames && missing > images_.source.count() / 100;
  }

  void Process(const SourceFrame& frame, Progress& progress) {
    FrameResult result;
    if (frame.gray.empty()) {
      progress.Warn(fmt::format("frame {}: {}; skipped", frame.index, frame.problem));
      summary_.unreadable.push_back({frame.index, frame.problem});
      result = odometry_.ProcessUnreadable(frame.time);
    } else {
      result = odometry_.Process(frame.gray, frame.time);
    }
    ++processed_;
    writer_->SetFirstCameraRotation(odometry_.mount().At(0));
    if (writer_->Add(result, odometry_.revision(), odometry_.scale_state())) {
      writer_->Rewrite(odometry_.RefinedFrames(), odometry_.scale_state());
    }
    if (const int moves = odometry_.mount().moves(); moves > moves_) {
      moves_ = moves;
      progress.Warn(fmt::format(
          "frame {}: the camera was moved since the last turn; re-estimating the camera-to-vehicle rotation",
          frame.index));
    }
    progress.Update(processed_, fmt::format("{} keyframes, scale {}", odometry_.map().keyframes.size(),
                                            ScaleStateName(odometry_.scale_state())));
  }

  void WriteResults() {
    odometry_.Finish();
    const std::vector<FrameResult> refined = odometry_.RefinedFrames();
    writer_->SetFirstCameraRotation(odometry_.mount().At(0));
    writer_->Rewrite(refined, odometry_.scale_state());
    const RefinedScale scale = odometry_.Refined();
    writer_->WriteTurns(scale.turns);
    writer_->WriteMap(odometry_.RefinedMap(), odometry_.scale_state());
    summary_.version = TURNSCALE_VERSION;
    summary_.input = arguments_.images.input.string();
    summary_.camera = images_.camera_file.string();
    summary_.pose_frame = arguments_.frame;
    summary_.folder = arguments_.out.string();
    summary_.vehicle = options_.vehicle;
    summary_.scale_state = odometry_.scale_state();
    if (odometry_.options().lens.enabled) summary_.lens = {odometry_.lens().correction(), odometry_.lens().sigma()};
    if (options_.vehicle.calibrate_camera) {
      const Mount& mount = odometry_.mount().current();
      summary_.mount = {YawPitchRollFromRotation(mount.vehicle_from_camera), mount.sigma, mount.found,
                        odometry_.mount().moves()};
    }
    Summarize(refined, scale, summary_);
    for (const std::string& warning : summary_.warnings) fmt::print(stderr, "warning: {}\n", warning);
    summary_.cost = MeasureCost();
    writer_->WriteText("summary.json", SummaryJson(summary_));
  }

  RunArguments arguments_;
  OdometryOptions options_;
  DriveImages images_;
  Odometry odometry_;
  std::optional<RunWriter> writer_;
  int processed_ = 0;
  int moves_ = 0;  // of the camera on the car, reported so far
  RunSummary summary_;
};

}  // namespace

void AddRunCommand(CLI::App& app) {
  CLI::App* run = app.add_subcommand("run", "Estimate the trajectory of a drive from its images.");
  auto arguments = std::make_shared<RunArguments>();
  run->add_option("input", arguments->images.input,
                  "KITTI folder (image_0/ or images/, calib.txt or camera.yaml, times.txt), folder of images, or video")
      ->required();
  run->add_option(
      "--camera", arguments->images.camera,
      "Intrinsics: KITTI calib.txt, OpenCV, ORB-SLAM or Kalibr YAML [calib.txt or camera.yaml in the input folder]");
  CLI::Option* timestamps =
      run->add_option("--timestamps", arguments->images.timestamps,
                      "Times of the frames in seconds, one per line [times.txt in the input folder]");
  run->add_option("--fps", arguments->images.fps, "Frames per second; overrides times.txt and a video's own rate")
      ->excludes(timestamps);
  run->add_option(
      "--lever-arm", arguments->lever_arm,
      "Distance from the rear axle forward to the camera, metres; without it the trajectory is up to scale");
  run->add_option("--lever-arm-sigma", arguments->lever_arm_sigma,
                  fmt::format("Standard deviation of --lever-arm, metres [{}]", kTapeSigma));
  run->add_option("--side-slip", arguments->side_slip,
                  fmt::format("Slip-angle coefficient c in L_eff = L - c v^2: slip angle of the rear axle per lateral "
                              "acceleration, rad per m/s^2 (= s^2/m); 0: no slip. Refined from the drive unless its "
                              "sigma is 0 [{}]",
                              kUsualSideSlip));
  run->add_option(
      "--side-slip-sigma", arguments->side_slip_sigma,
      fmt::format("Standard deviation of c, s^2/m; 0: c is not refined [{}; {:.0f} % of a given --side-slip]",
                  kUsualSideSlipSigma, 100 * kGivenSideSlipSigma));
  run->add_option(
      "--camera-rotation", arguments->camera_rotation,
      "Camera-to-vehicle rotation: yaw,pitch,roll in degrees (to the right, up, to the right); a YAML file "
      "with yaw_deg, pitch_deg, roll_deg, such as calibrate writes; or auto: estimated during the drive [auto]");
  run->add_option(
         "--method", arguments->method,
         "How metric scale is obtained. smoothed: one estimate along the drive, from all turns; turns: map adjusted "
         "with "
         "the length of each turn constrained to its single-turn scale; paper: map adjusted with each step of a turn "
         "constrained to the length from (22) [smoothed]")
      ->check(CLI::IsMember({"smoothed", "turns", "paper"}));
  run->add_option("--frame", arguments->frame, "Write poses of the camera or of the vehicle (rear axle)")
      ->check(CLI::IsMember({"camera", "vehicle"}))
      ->capture_default_str();
  run->add_option("--threads", arguments->threads, "Threads for image operations; do not change the result")
      ->capture_default_str();
  run->add_option("--settings", arguments->images.settings,
                  "YAML file with settings, such as settings.yaml of another run");
  run->add_option("--out", arguments->out, "Folder for the results")->capture_default_str();
  run->add_option("--max-frames", arguments->images.max_frames, "Stop after this many frames")
      ->check(CLI::Range(1, 1'000'000'000));
  run->add_flag("--quiet", arguments->images.quiet, "Print warnings and errors only");
  run->footer(
      "Example:\n  turnscale run drive.mp4 --camera cam.yaml --lever-arm 1.45 --out out/drive\n\n"
      "Output: trajectory.tum and trajectory.kitti.txt (refined, every frame), live.tum (online: each pose as\n"
      "estimated at its frame), trajectory.csv, turns.csv, map.ply, settings.yaml and summary.json. Ctrl-C stops\n"
      "after the current frame and keeps the results so far (exit code 130).");
  run->callback([arguments] {
    if (const int exit_code = Run(*arguments).Go(); exit_code != 0) throw CLI::RuntimeError(exit_code);
  });
}

}  // namespace turnscale

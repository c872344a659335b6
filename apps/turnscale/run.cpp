// SPDX-License-Identifier: MIT
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <opencv2/core/utility.hpp>

#include "argument_checks.h"
#include "commands.h"
#include "drive_camera.h"
#include "drive_source.h"
#include "interrupt.h"
#include "run_page.h"
#include "turnscale/base/error.h"
#include "turnscale/base/file_text.h"
#include "turnscale/io/run_drive.h"
#include "turnscale/io/settings.h"
#include "turnscale/io/terminal.h"
#include "turnscale/io/vehicle_file.h"
#include "turnscale/live/live_page.h"
#include "turnscale/odometry/odometry.h"
#include "turnscale/report/run_report.h"
#include "turnscale/report/thumbnails.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

struct RunArguments {
  ImageArguments images;
  std::optional<double> lever_arm;
  std::optional<double> lever_arm_sigma;
  std::optional<std::string> camera_height;
  std::optional<fs::path> vehicle;
  std::optional<double> side_slip;
  std::optional<double> side_slip_sigma;
  std::string camera_rotation;
  std::optional<std::string> method;
  std::string frame = "camera";
  int threads = kImageThreads;
  fs::path out = "out";
  TruthFiles truth;
  bool no_report = false;
  bool live = false;
  std::string live_address = "127.0.0.1:0";
};

// Settings file, overridden by the command line. Checked here so that messages name the option.
OdometryOptions OptionsFrom(const RunArguments& arguments) {
  OdometryOptions options = arguments.images.settings ? ReadSettings(*arguments.images.settings) : OdometryOptions();
  if (arguments.vehicle) ReadVehicleFile(*arguments.vehicle, options.vehicle);
  if (arguments.lever_arm) {
    options.vehicle.lever_arm = CheckedLeverArm(*arguments.lever_arm);
    if (arguments.vehicle) options.vehicle.lever_arm_sigma = kTapeSigma;
    options.vehicle.height_correlation = 0;
  }
  if (arguments.lever_arm_sigma) options.vehicle.lever_arm_sigma = CheckedLeverArmSigma(*arguments.lever_arm_sigma);
  if (arguments.camera_height) {
    const CameraHeight height = ParseCameraHeight(*arguments.camera_height);
    options.vehicle.camera_height = height.metres;
    options.vehicle.camera_height_sigma = height.sigma;
    options.vehicle.height_correlation = options.vehicle.height_slip_correlation = 0;
  }
  if (arguments.side_slip) {
    options.vehicle.side_slip = CheckedSideSlip(*arguments.side_slip);
    options.vehicle.side_slip_sigma = kGivenSideSlipSigma * *arguments.side_slip;
    options.vehicle.height_slip_correlation = 0;
  }
  if (arguments.side_slip_sigma) options.vehicle.side_slip_sigma = CheckedSideSlipSigma(*arguments.side_slip_sigma);
  if (arguments.camera_rotation == "auto") {
    options.vehicle.calibrate_camera = true;
    options.vehicle.camera_known = false;
  } else if (!arguments.camera_rotation.empty()) {
    options.vehicle.vehicle_from_camera = ReadCameraRotation(arguments.camera_rotation);
    options.vehicle.calibrate_camera = false;
    options.vehicle.camera_known = false;
    if (arguments.vehicle) options.vehicle.yaw_sigma = VehicleOptions().yaw_sigma;
  }
  if (arguments.method)
    options.scale.method = *arguments.method == "paper"   ? ScaleMethod::kPaper
                           : *arguments.method == "turns" ? ScaleMethod::kTurns
                                                          : ScaleMethod::kSmoothed;
  if (arguments.threads < 1) throw InputError(fmt::format("--threads {}: give at least 1", arguments.threads));
  options.Check();
  return options;
}

// Throws InputError where the results would come to lie among the images or clips, or replace what is read.
void CheckFolder(const RunArguments& arguments, const DriveImages& images) {
  std::error_code none;
  const auto refuse_folder = [&](const fs::path& folder) {
    if (fs::equivalent(arguments.out, folder.empty() ? "." : folder, none))
      throw InputError(fmt::format("--out {}: is the folder of the drive; name another one", arguments.out.string()));
  };
  for (const fs::path& input : arguments.images.inputs)
    refuse_folder(fs::is_directory(input, none) ? input : input.parent_path());
  refuse_folder(fs::is_directory(images.drive.path, none) ? images.drive.path : images.drive.path.parent_path());
  RefuseToOverwrite("--out", arguments.out / "mask.png", {arguments.images.mask.value_or("")});
  RefuseToOverwrite("--out", arguments.out / "car.yaml", {arguments.vehicle.value_or("")});
  if (arguments.images.refine_camera) RefuseToOverwrite("--out", arguments.out / "camera.yaml", {images.given.name});
}

RunSummary BeforeTheDrive(const RunArguments& arguments, const OdometryOptions& options, const DriveImages& images,
                          const CameraEstimate& estimate) {
  RunSummary summary;
  summary.version = TURNSCALE_VERSION;
  summary.input = arguments.images.Name();
  if (images.drive.bags) summary.topic = images.drive.bags->topic;
  summary.camera = images.given.name;
  summary.found_camera = estimate.found;
  if (arguments.images.mask) summary.mask = arguments.images.mask->string();
  summary.warnings = images.source.left_out();
  if (!estimate.warning.empty()) summary.warnings.push_back(estimate.warning);
  summary.pose_frame = arguments.frame;
  summary.folder = arguments.out.string();
  summary.start = arguments.images.start;
  summary.end = arguments.images.end;
  summary.vehicle = options.vehicle;
  return summary;
}

// The page that shows the results; whatever becomes of it, they are on disk already.
void KeepReport(const RunArguments& arguments, const ThumbnailCollector& thumbnails, RunEnd& end) {
  std::error_code none;
  for (const char* needed : {"trajectory.csv", "summary.json"})
    if (!fs::is_regular_file(arguments.out / needed, none)) return;
  Attempts attempts;
  attempts.Try([&] { WriteThumbnails(arguments.out, thumbnails.thumbnails()); });
  attempts.Try([&] { WriteRunPage(arguments.out, arguments.truth); });
  // A truth that does not fit the drive is no reason to have no page.
  if (!attempts.failures().empty() && !arguments.truth.truth.empty())
    attempts.Try([&] { WriteRunPage(arguments.out, {}); });
  end.failures.insert(end.failures.end(), attempts.failures().begin(), attempts.failures().end());
}

// The page that shows the run while it goes on.
class LiveView {
 public:
  LiveView(const RunArguments& arguments, int frames)
      : state_(arguments.images.Name(), TURNSCALE_VERSION, frames,
               arguments.no_report ? "" : fs::absolute(arguments.out / kReportFile).lexically_normal().string()),
        page_(ParseLiveAddress("--live-address", arguments.live_address), state_) {
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
  if (!end.nothing_tracked.empty()) return Report({2, end.summary.input + ": " + end.nothing_tracked});
  const std::string kept = "; the results so far are in " + end.summary.folder;
  if (end.failures.empty() && end.interrupted) return Report({kInterruptedExitCode, end.summary.stopped + kept});
  if (end.failures.empty()) return 0;
  Failure first = FailureOf(end.failures.front());
  std::set<std::string> messages = {first.message};
  for (const std::exception_ptr& failure : end.failures) {
    const std::string message = FailureOf(failure).message;
    if (messages.insert(message).second) PrintMessage("warning: " + message);
  }
  first.message += kept;
  return Report(first);
}

// Returns the exit code.
int RunImages(const RunArguments& arguments) {
  cv::setNumThreads(arguments.threads);
  const OdometryOptions options = OptionsFrom(arguments);
  CheckTruthFiles(arguments.truth);
  DriveImages images(arguments.images);
  CheckFolder(arguments, images);
  std::optional<LiveView> live;
  if (arguments.live) live.emplace(arguments, images.expected);
  const auto set_phase = [&](const std::string& phase) {
    if (live) live->SetPhase(phase);
  };
  const CameraEstimate estimate = EstimateCamera(arguments.images, images, options, [&](int pass) {
    set_phase(fmt::format("estimating the camera, pass {}", pass));
  });
  set_phase("");
  Odometry odometry(options, images.camera);
  if (!images.mask.empty()) odometry.SetMask(images.mask);
  Progress progress(images.expected, arguments.images.quiet);
  if (live) progress.OnWarning([&](const std::string& warning) { live->Warn(warning); });
  bool begun = false;
  const auto next = [&] {
    if (live) live->WaitWhilePaused();
    std::optional<SourceFrame> frame = images.source.Next();
    if (begun) return frame;
    begun = true;
    if (frame) images.CheckMask(frame->gray.size());
    // From here on there is something to keep.
    CatchInterrupts();
    if (frame) RemoveThumbnails(arguments.out);
    if (const std::string doubt = frame ? DoubtOf(images, frame->gray) : ""; !doubt.empty()) progress.Warn(doubt);
    return frame;
  };
  const PoseFrame shown = arguments.frame == "vehicle" ? PoseFrame::kVehicle : PoseFrame::kCamera;
  ThumbnailCollector thumbnails;
  const auto watch = [&](const SourceFrame& frame, const FrameResult& result, const Odometry& so_far) {
    if (!arguments.no_report) thumbnails.Add(frame.gray, result, so_far);
    if (live) live->Add(frame, result, so_far);
  };
  const DriveToRun drive = {next,
                            Interrupted,
                            [&] { return images.source.EndsEarly(); },
                            [&] { return images.source.clips(); },
                            arguments.images.max_frames,
                            {arguments.out, shown, options.vehicle},
                            BeforeTheDrive(arguments, options, images, estimate),
                            watch,
                            [&] { set_phase("final adjustment"); }};
  RunEnd end = RunDrive(drive, odometry, progress);
  if (!arguments.no_report) KeepReport(arguments, thumbnails, end);
  if (live) live->Finish(arguments.out / kReportFile, end.interrupted);
  if (end.failures.empty() && end.nothing_tracked.empty() && !arguments.images.quiet)
    PrintText(SummaryText(end.summary));
  return ReportEnd(end);
}

}  // namespace

void AddRunCommand(CLI::App& app) {
  CLI::App* run = app.add_subcommand("run", "Estimate the trajectory of a drive from its images.");
  auto arguments = std::make_shared<RunArguments>();
  run->add_option("input", arguments->images.inputs,
                  "KITTI folder (with the images in image_0/ or images/), folder of images, video, several "
                  "consecutive clips, folder of clips, or bags (.bag, .mcap, .db3); a folder can also contain "
                  "calib.txt or camera.yaml, and times.txt")
      ->required();
  AddCameraOptions(*run, arguments->images);
  CLI::Option* timestamps =
      run->add_option("--timestamps", arguments->images.timestamps,
                      "Times of the frames in seconds, one per line [times.txt in the input folder]");
  run->add_option("--fps", arguments->images.fps,
                  "Frames per second; overrides times.txt and a video's own time stamps")
      ->excludes(timestamps);
  run->add_option("--lever-arm", arguments->lever_arm,
                  "Horizontal distance from the rear axle forward to the camera, metres; without it and without "
                  "--camera-height the trajectory is up to scale");
  run->add_option("--lever-arm-sigma", arguments->lever_arm_sigma,
                  fmt::format("Standard deviation of --lever-arm, metres [{}]", kTapeSigma));
  run->add_option(
      "--camera-height", arguments->camera_height,
      "Height of the camera above the road, metres, or H,SIGMA: metres on drives without a turn, and a check "
      "of the lever arm [learned in turns; SIGMA: 1 % of H]");
  run->add_option("--vehicle", arguments->vehicle,
                  "YAML file of the car: car.yaml of an earlier run, or calibration.yaml of calibrate. Lever arm, side "
                  "slip, camera rotation and camera height are taken from it and refined; other options override it");
  run->add_option("--side-slip", arguments->side_slip,
                  fmt::format("Slip-angle coefficient c in L_eff = L - c v^2: slip angle of the rear axle per lateral "
                              "acceleration, rad per m/s^2 (= s^2/m); 0: no slip. Refined from the drive unless its "
                              "sigma is 0 [{}]",
                              kUsualSideSlip));
  run->add_option(
      "--side-slip-sigma", arguments->side_slip_sigma,
      fmt::format(
          "Standard deviation of c, s^2/m; 0: c is not refined [{}, or {:.0f} % of --side-slip if that is given]",
          kUsualSideSlipSigma, 100 * kGivenSideSlipSigma));
  run->add_option(
      "--camera-rotation", arguments->camera_rotation,
      "Camera-to-vehicle rotation: yaw,pitch,roll in degrees, positive to the right, up, to the right; a YAML file "
      "with yaw_deg, pitch_deg, roll_deg, such as calibrate writes; or auto: estimated during the drive [auto]");
  run->add_option(
         "--method", arguments->method,
         "How metric scale is obtained. smoothed: one estimate along the drive, from all turns; turns: each turn's "
         "scale from this turn alone, held by a final bundle adjustment; paper: the same for each pair of consecutive "
         "keyframes in a turn (equation (22) of the paper by Kim et al.) [smoothed]")
      ->check(CLI::IsMember({"smoothed", "turns", "paper"}));
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
      run->add_flag("--live", arguments->live, "Show the run while it goes on: prints the address of a page");
  run->add_option("--live-address", arguments->live_address,
                  "Where the page listens: HOST:PORT of this machine; port 0: a free one")
      ->needs(live)
      ->capture_default_str();
  AddPartOptions(*run, arguments->images);
  run->add_option("--max-frames", arguments->images.max_frames, "Stop after this many frames")
      ->check(CLI::Range(1, 1'000'000'000));
  run->add_flag("--quiet", arguments->images.quiet, "Print warnings and errors only");
  run->footer(
      "Examples:\n  turnscale run drive.mp4 --lever-arm 1.45 --out out/drive\n"
      "  turnscale run next.mp4 --vehicle out/drive/car.yaml --out out/next\n"
      "  turnscale run DCIM/ --camera out/drive/camera.yaml --lever-arm 1.45 --start 1:30 --end 12:00\n\n"
      "Output: trajectory.tum and trajectory.kitti.txt (refined, every frame), live.tum (online: each pose as\n"
      "estimated at its frame), trajectory.csv, speed.csv, turns.csv, scale.csv, camera_rotation.csv, map.ply,\n"
      "car.yaml (what was learned of the car, for --vehicle),\n"
      "camera.yaml (intrinsics, if estimated), mask.png (pixels left out, if any), settings.yaml, summary.json and\n"
      "report.html, a page that shows them. Ctrl-C stops after the current frame\n"
      "and keeps the results so far (exit code 130).");
  run->callback([arguments] {
    if (const int exit_code = RunImages(*arguments); exit_code != 0) throw CLI::RuntimeError(exit_code);
  });
}

}  // namespace turnscale

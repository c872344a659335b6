// SPDX-License-Identifier: MIT
#include "turnscale/commands/run_command.h"

#include <cmath>
#include <cstddef>
#include <exception>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>

#include "turnscale/base/error.h"
#include "turnscale/commands/argument_checks.h"
#include "turnscale/commands/drive_camera.h"
#include "turnscale/commands/version.h"
#include "turnscale/frames/recording_time.h"
#include "turnscale/io/run_files.h"
#include "turnscale/odometry/odometry.h"
#include "turnscale/report/run_report.h"
#include "turnscale/report/thumbnails.h"
#include "turnscale/run/drive_facts.h"
#include "turnscale/run/run_cost.h"
#include "turnscale/run/vehicle_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

// Whether the settings are those that an earlier run left in the same folder, and this one writes again.
bool SettingsAreOfEarlierRun(const RunArguments& arguments) {
  std::error_code none;
  return arguments.images.settings && IsFolderOfRun(arguments.out) &&
         fs::equivalent(*arguments.images.settings, arguments.out / RunFiles::kSettings, none);
}

// Throws InputError where other options change a setting of such a file. The text may change: that of an earlier
// version lacks settings, which have their defaults.
void CheckRepeatedSettings(const RunArguments& arguments, const Settings& settings) {
  const fs::path written = arguments.out / RunFiles::kSettings;
  if (SettingsText(ReadSettings(written)) == SettingsText(settings)) return;
  throw InputError(
      fmt::format("--out {}: is also an input file, and would change; give --settings a copy of it, or choose "
                  "another --out",
                  written.string()));
}

// What a run reads besides the images, and must not replace; a rotation in degrees names no file.
std::vector<fs::path> FilesRead(const RunArguments& arguments, const DriveImages& images) {
  std::vector<fs::path> files = arguments.images.inputs;
  for (const std::optional<fs::path>& file :
       {arguments.images.timestamps, arguments.images.mask, arguments.car.vehicle, images.drive.times_file})
    files.push_back(file.value_or(""));
  if (!SettingsAreOfEarlierRun(arguments)) files.push_back(arguments.images.settings.value_or(""));
  for (const fs::path& file : {fs::path(images.given.name), fs::path(arguments.car.camera_rotation),
                               arguments.truth.truth, arguments.truth.floor_plan})
    files.push_back(file);
  return files;
}

// Throws InputError where the results would come to lie among the images or clips, or replace what is read.
void CheckFolder(const RunArguments& arguments, const DriveImages& images, const Settings& settings) {
  std::error_code none;
  const auto refuse_folder = [&](const fs::path& folder) {
    if (fs::equivalent(arguments.out, folder.empty() ? "." : folder, none))
      throw InputError(
          fmt::format("--out {}: is the folder of the drive; choose another --out", arguments.out.string()));
  };
  for (const fs::path& input : arguments.images.inputs)
    refuse_folder(fs::is_directory(input, none) ? input : input.parent_path());
  refuse_folder(fs::is_directory(images.drive.path, none) ? images.drive.path : images.drive.path.parent_path());
  std::vector<NamedOutput> outputs;
  for (const char* name : RunFiles::kAll) outputs.push_back({"--out", arguments.out / name});
  if (SettingsAreOfEarlierRun(arguments)) CheckRepeatedSettings(arguments, settings);
  CheckOutputs(outputs, FilesRead(arguments, images));
}

// The camera-to-vehicle rotation of an earlier run belongs to that run's intrinsics: their principal point and its yaw
// are correlated. One line, empty where another choice was made or there are none.
std::string UnusedCameraOfVehicle(const RunArguments& arguments, const VehicleOptions& vehicle,
                                  const DriveImages& images) {
  std::error_code none;
  const bool chosen = !images.given.name.empty() || arguments.images.field_of_view;
  if (!arguments.car.vehicle || !vehicle.camera_known || chosen) return {};
  const fs::path& car = *arguments.car.vehicle;
  const fs::path camera = car.parent_path() / RunFiles::kCamera;
  if (!fs::is_regular_file(camera, none)) return {};
  return fmt::format("{}: is not used; give --camera {}, as the camera rotation in {} belongs to it", camera.string(),
                     camera.string(), car.filename().string());
}

// What can be said before the camera is estimated, which may take long.
std::vector<std::string> EarlyWarnings(const RunArguments& arguments, const VehicleOptions& vehicle,
                                       const DriveImages& images) {
  std::vector<std::string> warnings = WarningsOf(arguments.images, images);
  if (std::string unused = UnusedCameraOfVehicle(arguments, vehicle, images); !unused.empty())
    warnings.push_back(std::move(unused));
  return warnings;
}

RunInput GivenTo(const RunArguments& arguments, const DriveImages& images, const CameraEstimate& estimate) {
  RunInput given;
  given.version = Version();
  given.input = arguments.images.Name();
  if (images.drive.bags) given.topic = images.drive.bags->topic;
  given.camera = images.given.name;
  given.found_camera = estimate.found;
  given.rotate = arguments.images.rotate;
  if (arguments.images.mask) given.mask = arguments.images.mask->string();
  if (arguments.car.vehicle) given.vehicle_file = arguments.car.vehicle->string();
  given.pose_frame = arguments.frame;
  given.folder = arguments.out.string();
  given.start = arguments.images.start;
  given.end = arguments.images.end;
  if (const std::optional<double>& from = images.source.RecordedFrom()) given.recorded_from = RecorderTimeText(*from);
  given.first_time = images.source.first_time();
  return given;
}

LeftByOptions LeftBy(const RunArguments& arguments, const DriveImages& images) {
  LeftByOptions left;
  const auto add = [&](const char* option, const std::string& value) {
    if (!value.empty()) left.part += fmt::format("{}{} {}", left.part.empty() ? "" : " ", option, value);
  };
  add("--start", arguments.images.start);
  add("--end", arguments.images.end);
  if (arguments.images.max_frames) add("--max-frames", std::to_string(*arguments.images.max_frames));
  if (images.mask.empty()) return left;
  left.mask = "--mask " + arguments.images.mask->string();
  left.mask_share = static_cast<double>(cv::countNonZero(images.mask)) / static_cast<double>(images.mask.total());
  return left;
}

EndOfDrive EndOf(const ImageSource& source) {
  return {.begins_late = source.BeginsLate(),
          .lacks = source.Lacks(),
          .ends_early = source.EndsEarly(),
          .notice = source.NoticeAtEnd(),
          .leaves_out = source.LeavesOut(),
          .clips = source.clips()};
}

// The page that shows the results; whatever becomes of it, they are on disk already.
void KeepReport(const RunArguments& arguments, const ThumbnailCollector& thumbnails, Progress& progress, RunEnd& end) {
  if (!HasResultsOfRun(arguments.out)) return;
  Attempts attempts;
  attempts.Try([&] { WriteThumbnails(arguments.out, thumbnails.thumbnails()); });
  const bool has_page = attempts.Try([&] {
    for (const std::string& warning : WriteRunPage(arguments.out, arguments.truth)) progress.Warn(warning);
  });
  // A truth that does not fit the drive is no reason to have no page.
  if (!has_page && !arguments.truth.truth.empty()) attempts.Try([&] { WriteRunPage(arguments.out, {}); });
  end.failures.insert(end.failures.end(), attempts.failures().begin(), attempts.failures().end());
}

// Of an earlier path, as `export` writes it; they may be the user's own, so they stay. One line, empty without any.
std::string OlderExports(const fs::path& folder) {
  std::string names;
  std::error_code none;
  for (const char* name : {"path.gpx", "path.kml", "path.geojson", "path.gltf"})
    if (fs::exists(folder / name, none)) names += (names.empty() ? "" : ", ") + std::string(name);
  if (names.empty()) return {};
  return fmt::format("{}: made from an earlier path: {}; run turnscale export again", folder.string(), names);
}

ScaleMethod MethodNamed(const std::string& name) {
  CheckChoice("--method", name, ScaleMethodNames());
  return *FindScaleMethod(name);
}

// What the lever arm of a file would be with another side slip stays the same: only its sigma follows.
void ReplaceSlipSigma(double sigma, VehicleOptions& vehicle) {
  const double before = std::exchange(vehicle.side_slip_sigma, sigma);
  const double lever_arm_sigma = vehicle.LeverArmSigma();
  // What is exact has no error that could correlate.
  if (!(before > 0 && lever_arm_sigma > 0)) vehicle.lever_arm_slip_correlation = 0;
  if (vehicle.lever_arm_slip_correlation == 0) return;
  const double by_slip = vehicle.lever_arm_slip_correlation * lever_arm_sigma * sigma / before;
  const double exact =
      lever_arm_sigma * std::sqrt(1 - vehicle.lever_arm_slip_correlation * vehicle.lever_arm_slip_correlation);
  vehicle.lever_arm_sigma = std::hypot(exact, by_slip);
  vehicle.lever_arm_slip_correlation = by_slip / *vehicle.lever_arm_sigma;
}

}  // namespace

Settings SettingsFrom(const CarArguments& car, const std::optional<fs::path>& file) {
  Settings settings = file ? ReadSettings(*file) : Settings();
  OdometryOptions& options = settings.odometry;
  if (car.vehicle) ReadVehicleFile(*car.vehicle, options.vehicle);
  if (car.lever_arm) {
    options.vehicle.lever_arm = CheckedLeverArm(*car.lever_arm);
    if (car.vehicle) options.vehicle.lever_arm_sigma.reset();
    options.vehicle.height_correlation = options.vehicle.lever_arm_slip_correlation = 0;
  }
  if (car.camera_height) {
    const CameraHeight height = ParseCameraHeight(*car.camera_height);
    options.vehicle.camera_height = height.metres;
    options.vehicle.camera_height_sigma = height.sigma;
    options.vehicle.height_from_images = false;
    options.vehicle.height_correlation = options.vehicle.height_slip_correlation = 0;
  }
  if (car.side_slip) {
    options.vehicle.side_slip = CheckedSideSlip(*car.side_slip);
    options.vehicle.side_slip_sigma = SigmaOfGivenSideSlip(*car.side_slip);
    options.vehicle.height_slip_correlation = options.vehicle.lever_arm_slip_correlation = 0;
  }
  if (car.side_slip_sigma) ReplaceSlipSigma(CheckedSideSlipSigma(*car.side_slip_sigma), options.vehicle);
  RequireFor({"--lever-arm-sigma", car.lever_arm_sigma.has_value()}, options.vehicle.lever_arm.has_value(),
             "--lever-arm, or a --vehicle file with one");
  if (car.lever_arm_sigma)
    options.vehicle.lever_arm_sigma = CheckedLeverArmSigma(*car.lever_arm_sigma, options.vehicle.lever_arm);
  if (car.camera_rotation == "auto") {
    options.vehicle.calibrate_camera = true;
    options.vehicle.camera_known = false;
  } else if (!car.camera_rotation.empty()) {
    options.vehicle.vehicle_from_camera = ReadCameraRotation(car.camera_rotation);
    options.vehicle.calibrate_camera = false;
    options.vehicle.camera_known = false;
    if (car.vehicle) options.vehicle.yaw_sigma = VehicleOptions().yaw_sigma;
  }
  if (car.method) options.scale.method = MethodNamed(*car.method);
  if (options.scale.method != ScaleMethod::kSmoothed && !options.vehicle.lever_arm)
    throw InputError(
        fmt::format("{}: constrains turns by the lever arm, which is missing; give --lever-arm, or a "
                    "--vehicle file with one",
                    car.method ? "--method " + *car.method : file->string() + ": scale.method"));
  settings.Check();
  return settings;
}

RunEnd ExecuteRun(const RunArguments& arguments, const RunHooks& hooks) {
  const ProcessClocks started = ReadClocks();
  CheckImageArguments(arguments.images);
  CheckChoice("--frame", arguments.frame, {"camera", "vehicle"});
  RefuseBoth({"--no-report", arguments.no_report}, {"--truth", !arguments.truth.truth.empty()});
  const Settings settings = SettingsFrom(arguments.car, arguments.images.settings);
  CheckThreads(arguments.threads);
  cv::setNumThreads(arguments.threads);
  CheckTruthFiles(arguments.truth);
  DriveImages images = OpenImages(arguments.images, settings.images);
  CheckFolder(arguments, images, settings);
  const PoseFrame shown = arguments.frame == "vehicle" ? PoseFrame::kVehicle : PoseFrame::kCamera;
  const RunWriterOptions output = {arguments.out, shown, settings.odometry.vehicle.lever_arm};
  CheckRunOutput(output);
  hooks.opened(images.expected, images.source.first_time());
  hooks.begun();
  std::vector<std::string> warnings = EarlyWarnings(arguments, settings.odometry.vehicle, images);
  for (const std::string& warning : warnings) Warn(hooks, warning);
  const std::size_t warned = warnings.size();
  const CameraEstimate estimate = EstimateCamera(arguments.images, images, settings, hooks, hooks.phase);
  if (!estimate.warning.empty()) warnings.push_back(estimate.warning);
  hooks.phase("");
  Odometry odometry(settings.odometry, images.camera);
  if (!images.mask.empty()) odometry.SetMask(images.mask);
  Progress progress(images.expected, arguments.images.quiet);
  SendWarnings(progress, hooks);
  ThumbnailCollector thumbnails;
  const DriveToRun drive = {
      .next =
          [&] {
            hooks.before_frame();
            return images.source.Next();
          },
      .interrupted = hooks.interrupted,
      .at_end = [&] { return EndOf(images.source); },
      .max_frames = arguments.images.max_frames,
      .scaling = images.scaling,
      .settings = settings,
      .output = output,
      .given = GivenTo(arguments, images, estimate),
      .warnings = std::move(warnings),
      .warned = warned,
      .started = started,
      .watch =
          [&](const SourceFrame& frame, const FrameResult& result, const Odometry& so_far) {
            if (!arguments.no_report) thumbnails.Add(frame.gray, result, so_far);
            if (hooks.watch) hooks.watch(frame, result, so_far);
          },
      .concluding = [&] { hooks.phase("final adjustment"); },
      .replacing =
          [&] {
            RemoveThumbnails(arguments.out);
            return OlderExports(arguments.out);
          },
      .left = LeftBy(arguments, images),
  };
  RunEnd end = RunDrive(drive, odometry, progress);
  if (end.written && !arguments.no_report) KeepReport(arguments, thumbnails, progress, end);
  return end;
}

std::optional<RunFailure> FailureOfRun(const RunEnd& end) {
  if (!end.nothing_tracked.empty()) {
    RunFailure failure = {{2, end.summary.drive.given.input + ": " + end.nothing_tracked}, {}, /*kept=*/false};
    for (const std::exception_ptr& thrown : end.failures) failure.others.push_back(FailureOf(thrown).message);
    return failure;
  }
  if (end.failures.empty() && end.interrupted) {
    const char* more = end.begun                      ? ""
                       : end.summary.frames.total > 0 ? ", before the first pose"
                                                      : "; nothing is written";
    return RunFailure{{kInterruptedExitCode, end.summary.drive.ending.stopped + more}, {}, end.begun && end.written};
  }
  if (end.failures.empty()) return std::nullopt;
  RunFailure failure = {FailureOf(end.failures.front()), {}, end.written};
  std::set<std::string> messages = {failure.first.message};
  for (const std::exception_ptr& thrown : end.failures) {
    const std::string message = FailureOf(thrown).message;
    if (messages.insert(message).second) failure.others.push_back(message);
  }
  return failure;
}

}  // namespace turnscale

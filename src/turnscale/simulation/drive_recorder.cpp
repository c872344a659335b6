// SPDX-License-Identifier: MIT
#include "turnscale/simulation/drive_recorder.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <future>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/run_files.h"
#include "turnscale/rendering/renderer.h"
#include "turnscale/simulation/burnt_clock.h"
#include "turnscale/simulation/captured_frames.h"
#include "turnscale/simulation/drive.h"
#include "turnscale/simulation/image_output.h"
#include "turnscale/simulation/sensor.h"
#include "turnscale/simulation/windscreen.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMarker = "# Made by turnscale simulate, which replaces the drive in this folder when told to.";
constexpr const char* kMarkedFile = "drive.yaml";
// Times and poses first: they say that the rest is whole.
constexpr const char* kFiles[] = {"times.txt",   "poses.txt",    "truth.csv", "floor_plan.csv", "calib.txt",
                                  "camera.yaml", "vehicle.yaml", "rig.yaml",  kVideoFile};

bool Exists(const fs::path& path) {
  std::error_code error;
  return fs::exists(fs::symlink_status(path, error)) && !error;
}

bool IsOurs(const fs::path& folder) {
  std::ifstream stream(folder / kMarkedFile);
  std::string line;
  return std::getline(stream, line) && line == kMarker;
}

void RefuseForeign(const fs::path& folder) {
  std::error_code error;
  if (Exists(folder) && !fs::is_directory(folder, error)) {
    throw InputError(folder.string() + ": is a file, but the drive needs a folder; choose another --out");
  }
  if (IsFolderOfRun(folder)) throw InputError(folder.string() + ": has the results of a run; choose another --out");
  if (IsOurs(folder)) return;
  const auto refuse = [&](const std::string& name) {
    throw InputError((folder / name).string() + ": does not belong to a simulated drive; choose another --out");
  };
  for (const char* name : kFiles) {
    if (Exists(folder / name)) refuse(name);
  }
  if (Exists(folder / kMarkedFile)) refuse(kMarkedFile);
  const fs::path images = folder / kImageFolder;
  if (Exists(images) && !(fs::is_directory(images, error) && fs::is_empty(images, error))) refuse(kImageFolder);
}

bool IsImageOfDrive(const fs::path& path) {
  // A recording that was killed leaves a part of one.
  const fs::path image = path.extension() == PartOf("").string() ? path.stem() : path;
  const std::string number = image.stem().string();
  return image.extension() == ".png" &&
         std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; });
}

void RemoveDrive(const fs::path& folder) {
  for (const char* name : kFiles) {
    RemoveOldFile(folder / name);
  }
  if (!Exists(folder / kImageFolder)) return;
  for (const auto& entry : fs::directory_iterator(folder / kImageFolder)) {
    if (IsImageOfDrive(entry.path())) fs::remove(entry.path());
  }
}

void BeginFolder(const RecordOptions& options, const Rig& rig, unsigned seed, const FloorPlan& floor_plan) {
  const fs::path& folder = options.folder;
  PrepareDriveFolder(folder, !rig.recorder.video);
  // First, so that the folder is known as ours whatever happens next.
  ReplaceFile(folder / "drive.yaml", DriveText(options.origin, seed));
  ReplaceFile(folder / "rig.yaml", RigText(rig));
  ReplaceFile(folder / "camera.yaml", CameraFileText(rig.camera));
  if (rig.camera.lens == LensModel::kPinhole) {
    ReplaceFile(folder / "calib.txt", KittiCalibrationText(rig.camera.pinhole));
  }
  ReplaceFile(folder / "vehicle.yaml", VehicleText(rig));
  ReplaceFile(folder / "floor_plan.csv", FloorPlanText(floor_plan));
}

// Complaints about the way do not know the file that it comes from.
CameraDrive DriveThrough(const World& world, const Rig& rig, unsigned seed, const DriveOrigin& origin) {
  rig.Check();
  try {
    return {world, rig, seed};
  } catch (const InputError& error) {
    if (!origin.follow) throw;
    throw InputError(origin.follow->string() + ": " + error.what());
  }
}

// What becomes of the light until it is on the card.
class Camera {
 public:
  Camera(const Rig& rig, unsigned seed, const fs::path& folder)
      : clock_(rig.recorder.clock),
        windscreen_(rig.windscreen, {rig.camera.width, rig.camera.height}, seed),
        sensor_(rig.sensor, rig.camera, rig.rate_hz, seed),
        output_(folder, rig) {}

  const cv::Mat& covered() const { return windscreen_.covered(); }

  void Record(const cv::Mat& scene, const CapturedFrame& frame) {
    sensor_.SkipTo(frame.number);
    cv::Mat image = sensor_.Expose(windscreen_.Through(scene));
    if (clock_) BurnClock(frame.stamp, image);
    output_.Write(image, frame.stamp);
  }
  void Finish() { output_.Finish(); }

 private:
  bool clock_;
  Windscreen windscreen_;
  Sensor sensor_;
  ImageOutput output_;
};

void Summarize(const std::vector<DriveFrame>& frames, Recording& recording) {
  recording.frames = static_cast<int>(frames.size());
  if (!frames.empty()) recording.seconds = frames.back().time - frames.front().time;
  for (size_t i = 1; i < frames.size(); ++i) {
    recording.metres += (frames[i].world_from_camera.translation - frames[i - 1].world_from_camera.translation).norm();
    recording.turned += std::abs(frames[i].vehicle.heading - frames[i - 1].vehicle.heading);
  }
}

}  // namespace

std::string DriveText(const DriveOrigin& origin, unsigned seed) {
  std::string text = std::string(kMarker) + "\n";
  text += fmt::format("version: {}\nworld: {}\nseed: {}\n", QuotedYaml(origin.version), QuotedYaml(origin.world), seed);
  if (origin.seconds) text += fmt::format("seconds: {}\n", *origin.seconds);
  if (origin.follow) text += fmt::format("follow: {}\n", QuotedYaml(origin.follow->string()));
  return text + fmt::format("texture_contrast: {}\n", origin.texture_contrast);
}

void PrepareDriveFolder(const fs::path& folder, bool images) {
  RefuseForeign(folder);
  std::error_code error;
  fs::create_directories(images ? folder / kImageFolder : folder, error);
  if (error) throw InputError(folder.string() + ": cannot be made: " + error.message() + "; choose another --out");
  try {
    RemoveDrive(folder);
    // An empty folder of images would be taken for those of the drive.
    if (!images && fs::is_directory(folder / kImageFolder) && fs::is_empty(folder / kImageFolder))
      fs::remove(folder / kImageFolder);
  } catch (const fs::filesystem_error& failure) {
    throw InputError(folder.string() + ": cannot be cleared: " + failure.code().message() + "; choose another --out");
  }
}

Recording RecordDrive(World world, const Rig& rig, unsigned seed, const RecordOptions& options,
                      const RecordProgress& progress) {
  RenderOptions render_options;
  render_options.threads = options.threads;
  render_options.Check();
  const CameraDrive drive = DriveThrough(world, rig, seed, options.origin);
  std::vector<CapturedFrame> captured = CapturedFrames(rig.recorder, drive.frames(), rig.rate_hz, seed);
  if (options.max_frames && *options.max_frames < static_cast<int>(captured.size()))
    captured.resize(static_cast<size_t>(*options.max_frames));
  const int count = static_cast<int>(captured.size());
  BeginFolder(options, rig, seed, FloorPlanFrom(drive.At(0).world_from_camera, world));
  if (!progress(0, count)) return {};
  // Lights the scene, which takes a while.
  const Renderer renderer(render_options, std::move(world.scene));
  Camera camera(rig, seed, options.folder);

  Recording recording;
  std::vector<DriveFrame> frames;
  // One image is exposed, coded and written while the next one is drawn; never two, so that their order is kept.
  std::future<void> writing;
  bool go_on = progress(0, count);
  for (int index = 0; index < count && go_on; ++index) {
    const CapturedFrame& frame = captured[static_cast<size_t>(index)];
    View view = drive.ViewAt(frame.number);
    view.covered = camera.covered();
    cv::Mat scene = renderer.Render(rig.camera, view);
    if (writing.valid()) writing.get();
    writing =
        std::async(std::launch::async, [&camera, &frame, scene = std::move(scene)] { camera.Record(scene, frame); });
    frames.push_back(drive.At(frame.number));
    go_on = progress(index + 1, count);
  }
  if (writing.valid()) writing.get();
  Summarize(frames, recording);
  recording.complete = recording.frames == count;
  if (!recording.complete) return recording;
  camera.Finish();
  ReplaceFile(options.folder / "truth.csv", TruthText(frames));
  ReplaceFile(options.folder / "poses.txt", PosesText(frames));
  ReplaceFile(options.folder / "times.txt", TimesText(frames));
  return recording;
}

}  // namespace turnscale

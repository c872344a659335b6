// SPDX-License-Identifier: MIT
#include "turnscale/simulation/rig.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/config/yaml_map.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/range_check.h"
#include "turnscale/io/yaml_fields.h"

namespace turnscale {
namespace {

constexpr double kPaperFieldOfViewDeg = 80;

constexpr Choices<RigPreset> kPresets = {
    {"paper", RigPreset::kPaper}, {"kitti", RigPreset::kKitti}, {"dashcam", RigPreset::kDashcam}};

// Every field of the file once: reading and writing both follow this list (see io/yaml_fields.h).
template <class Visitor>
void VisitRig(Visitor& visitor, Rig& rig) {
  visitor.Choice("preset", rig.preset, kPresets);
  visitor.Field("rate_hz", rig.rate_hz);
  visitor.Group("camera", [&] {
    CameraModel& o = rig.camera;
    visitor.Field("width", o.width);
    visitor.Field("height", o.height);
    visitor.Field("fx", o.pinhole.fx);
    visitor.Field("fy", o.pinhole.fy);
    visitor.Field("cx", o.pinhole.cx);
    visitor.Field("cy", o.pinhole.cy);
    visitor.Choice("lens", o.lens,
                   {{"pinhole", LensModel::kPinhole},
                    {"radtan", LensModel::kRadialTangential},
                    {"equidistant", LensModel::kEquidistant}});
    visitor.Field("distortion", o.distortion);
  });
  visitor.Group("mount", [&] {
    CameraMount& o = rig.mount;
    visitor.Field("lever_arm", o.lever_arm);
    visitor.Field("lateral_offset", o.lateral_offset);
    visitor.Field("height", o.height);
    visitor.Field("yaw_deg", o.yaw_deg);
    visitor.Field("pitch_deg", o.pitch_deg);
    visitor.Field("roll_deg", o.roll_deg);
  });
  visitor.Group("vehicle", [&] {
    CarOptions& o = rig.vehicle;
    visitor.Field("wheelbase", o.wheelbase);
    visitor.Field("max_steering_deg", o.max_steering_deg);
    visitor.Field("max_steering_rate_deg", o.max_steering_rate_deg);
    visitor.Field("slip_deg_per_g", o.slip_deg_per_g);
    visitor.Field("max_acceleration", o.max_acceleration);
    visitor.Field("max_deceleration", o.max_deceleration);
    visitor.Field("max_lateral_acceleration", o.max_lateral_acceleration);
    visitor.Field("pitch_deg_per_g", o.pitch_deg_per_g);
    visitor.Field("roll_deg_per_g", o.roll_deg_per_g);
    visitor.Field("suspension_hz", o.suspension_hz);
    visitor.Field("road_noise_deg", o.road_noise_deg);
  });
  visitor.Group("sensor", [&] {
    SensorOptions& o = rig.sensor;
    visitor.Field("target_gray", o.target_gray);
    visitor.Field("exposure_lag", o.exposure_lag);
    visitor.Field("min_gain", o.min_gain);
    visitor.Field("max_gain", o.max_gain);
    visitor.Field("flicker", o.flicker);
    visitor.Field("flicker_hz", o.flicker_hz);
    visitor.Field("exposure_step", o.exposure_step);
    visitor.Field("exposure_step_seconds", o.exposure_step_seconds);
    visitor.Field("vignetting", o.vignetting);
    visitor.Field("blur", o.blur);
    visitor.Field("shot_noise", o.shot_noise);
    visitor.Field("read_noise", o.read_noise);
    visitor.Field("response", o.response);
    visitor.Field("exposure_ms", o.exposure_ms);
    visitor.Field("readout_ms", o.readout_ms);
  });
  visitor.Group("windscreen", [&] {
    WindscreenOptions& o = rig.windscreen;
    visitor.Field("dashboard", o.dashboard);
    visitor.Field("reflection", o.reflection);
    visitor.Field("defocus", o.defocus);
  });
  visitor.Group("recorder", [&] {
    RecorderOptions& o = rig.recorder;
    visitor.Field("video", o.video);
    visitor.Field("megabits_per_second", o.megabits_per_second);
    visitor.Field("clock", o.clock);
    visitor.Field("stalls_per_minute", o.stalls_per_minute);
    visitor.Field("stalled_frames", o.stalled_frames);
    visitor.Field("stamp_jitter_ms", o.stamp_jitter_ms);
  });
}

RigPreset PresetOf(const YamlMap& file, RigPreset fallback) {
  if (!file.Has("preset")) return fallback;
  // Words that are none are refused with all other fields.
  return FindRigPreset(file.Text("preset")).value_or(fallback);
}

Rig Dashcam() {
  Rig rig;
  rig.preset = RigPreset::kDashcam;
  CameraModel& camera = rig.camera;
  camera.width = 1920;
  camera.height = 1080;
  camera.lens = LensModel::kEquidistant;
  camera.distortion = {-0.015, 0.004, 0, 0, 0};
  constexpr double kHalfFieldOfView = std::numbers::pi / 3;
  const double focal_length = std::round(camera.width / 2.0 / DistortAngle(camera.distortion, kHalfFieldOfView));
  // The lens is screwed in a few pixels beside the middle.
  camera.pinhole = {focal_length, focal_length, 966.5, 533};
  rig.rate_hz = 30;
  rig.mount = {
      .lever_arm = 1.5, .lateral_offset = 0.1, .height = 1.3, .yaw_deg = 1.5, .pitch_deg = -2, .roll_deg = 0.8};
  // Gray as a screen wants it, a small sensor's noise, and a lens that is a little soft.
  rig.sensor.target_gray = 115;
  rig.sensor.response = 0.5;
  rig.sensor.shot_noise = 3;
  rig.sensor.read_noise = 1.2;
  rig.sensor.blur = 0.6;
  rig.sensor.readout_ms = 20;
  rig.windscreen = {.dashboard = 0.16, .reflection = 0.2, .defocus = 1};
  rig.recorder = {.video = true,
                  .megabits_per_second = 12,
                  .clock = true,
                  .stalls_per_minute = 6,
                  .stalled_frames = 3,
                  .stamp_jitter_ms = 1};
  return rig;
}

// A pixel whose ray nobody finds shows nothing.
void CheckDistortion(const CameraModel& camera) {
  const double right = camera.width - 1;
  const double bottom = camera.height - 1;
  const Eigen::Vector2d middle(right / 2, bottom / 2);
  for (const Eigen::Vector2d& pixel : {middle, Eigen::Vector2d(0, middle.y()), Eigen::Vector2d(right, middle.y()),
                                       Eigen::Vector2d(middle.x(), 0), Eigen::Vector2d(middle.x(), bottom)}) {
    if (camera.Undistort(pixel)) continue;
    throw InputError(
        fmt::format("camera.distortion: cannot be inverted at pixel {}, {}; give smaller coefficients or a "
                    "longer focal length",
                    pixel.x(), pixel.y()));
  }
}

void CheckCamera(const CameraModel& camera) {
  CheckRange("camera.width", camera.width, 16, 8192, "pixels");
  CheckRange("camera.height", camera.height, 16, 8192, "pixels");
  constexpr const char* kOfSize = "pixels for this width and height: give fx, fy, cx and cy along with them";
  CheckRange("camera.fx", camera.pinhole.fx, 0.1 * camera.width, 10.0 * camera.width, kOfSize);
  CheckRange("camera.fy", camera.pinhole.fy, 0.1 * camera.width, 10.0 * camera.width, kOfSize);
  CheckRange("camera.cx", camera.pinhole.cx, 0, camera.width - 1, kOfSize);
  CheckRange("camera.cy", camera.pinhole.cy, 0, camera.height - 1, kOfSize);
  if (camera.lens == LensModel::kPinhole && camera.distortion != CameraModel().distortion) {
    throw InputError("camera.distortion: a pinhole has none; give lens: radtan or lens: equidistant");
  }
  if (camera.lens == LensModel::kEquidistant && camera.distortion[4] != 0) {
    throw InputError("camera.distortion: an equidistant lens has four coefficients");
  }
  CheckDistortion(camera);
}

}  // namespace

void CameraMount::Check() const {
  if (!(lever_arm > 0 && lever_arm <= 20)) {
    throw InputError(
        fmt::format("mount.lever_arm: is {}; give the metres from the rear axle forward to the camera, above 0 and up "
                    "to 20",
                    lever_arm));
  }
  CheckRange("mount.lateral_offset", lateral_offset, -5, 5, "metres");
  CheckRange("mount.height", height, 0.1, 10, "metres");
  CheckRange("mount.yaw_deg", yaw_deg, -180, 180, "degrees");
  CheckRange("mount.pitch_deg", pitch_deg, -90, 90, "degrees");
  CheckRange("mount.roll_deg", roll_deg, -180, 180, "degrees");
}

RigidTransform CameraMount::VehicleFromCamera() const {
  const Eigen::Quaterniond rotation = RotationFromYawPitchRoll(
      {yaw_deg / kDegreesPerRadian, pitch_deg / kDegreesPerRadian, roll_deg / kDegreesPerRadian});
  return {rotation, {lateral_offset, kAxleHeight - height, lever_arm}};
}

void Rig::Check() const {
  CheckCamera(camera);
  CheckRange("rate_hz", rate_hz, 0.1, 1000, "frames per second");
  mount.Check();
  vehicle.Check();
  sensor.Check();
  windscreen.Check();
  recorder.Check();
  if (recorder.video && (camera.width % 2 != 0 || camera.height % 2 != 0)) {
    throw InputError(
        fmt::format("camera: a video needs even numbers of pixels, not {}x{}; give another width and height",
                    camera.width, camera.height));
  }
  const double interval_ms = 1000 / rate_hz;
  if (sensor.exposure_ms > interval_ms) {
    throw InputError(fmt::format("sensor.exposure_ms: is longer than the {} ms of a frame", interval_ms));
  }
  if (sensor.readout_ms > interval_ms) {
    throw InputError(fmt::format("sensor.readout_ms: is longer than the {} ms of a frame", interval_ms));
  }
}

Shutter Rig::ImageShutter() const { return {sensor.exposure_ms / 1000, sensor.readout_ms / 1000}; }

std::optional<RigPreset> FindRigPreset(std::string_view name) {
  for (const auto& [word, preset] : kPresets) {
    if (name == word) return preset;
  }
  return std::nullopt;
}

Rig MakeRig(RigPreset preset) {
  if (preset == RigPreset::kDashcam) return Dashcam();
  Rig rig;
  rig.preset = preset;
  if (preset == RigPreset::kKitti) {
    rig.camera.width = 1241;
    rig.camera.height = 376;
    rig.camera.pinhole = {718.856, 718.856, 607.1928, 185.2157};
    rig.mount.height = 1.65;
    rig.mount.lever_arm = 0.945;
    return rig;
  }
  rig.camera.width = 1032;
  rig.camera.height = 772;
  const double focal_length =
      std::round(rig.camera.width / 2.0 / std::tan(kPaperFieldOfViewDeg / 2 * std::numbers::pi / 180));
  rig.camera.pinhole = {focal_length, focal_length, 515.5, 385.5};
  return rig;
}

Rig ReadRig(const std::filesystem::path& path, RigPreset fallback) {
  const YamlMap file(path);
  Rig rig = MakeRig(PresetOf(file, fallback));
  FieldNames known;
  VisitRig(known, rig);
  file.AllowOnlyNested(known.names);
  FieldReader reader(file);
  VisitRig(reader, rig);
  file.CheckRead(rig);
  return rig;
}

std::string RigText(const Rig& rig) {
  FieldWriter writer;
  Rig shown = rig;
  VisitRig(writer, shown);
  return writer.text;
}

}  // namespace turnscale

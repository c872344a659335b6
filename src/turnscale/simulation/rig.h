// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/rendering/renderer.h"
#include "turnscale/simulation/captured_frames.h"
#include "turnscale/simulation/sensor.h"
#include "turnscale/simulation/vehicle.h"
#include "turnscale/simulation/windscreen.h"

namespace turnscale {

/// Height of the rear axle's centre above the road, metres.
constexpr double kAxleHeight = 0.3;

/// Where the camera sits on the car, and where it looks.
struct CameraMount {
  double lever_arm = 1.5;     ///< ahead of the rear axle, metres
  double lateral_offset = 0;  ///< to the right of the car's middle, metres
  double height = 1.4;        ///< above the road while the car stands level, metres
  double yaw_deg = 0;         ///< to the right
  double pitch_deg = 0;       ///< up
  double roll_deg = 0;        ///< leaning right

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
  /// With the paper's Q as its rotation, composed as `run --camera-rotation` does it.
  RigidTransform VehicleFromCamera() const;
};

enum class RigPreset {
  kPaper,  ///< 1032x772 pixels at 10 Hz, 80 degrees wide
  kKitti,  ///< KITTI sequence 00: 1241x376 pixels at 10 Hz, 82 degrees wide

  /// 1920x1080 pixels at 30 Hz, 120 degrees wide, behind a windscreen, recorded as a video of 12 Mbit/s.
  ///
  /// The lens is close to equidistant: 120 degrees across are then 138 along the diagonal, which sellers call 140. A
  /// lens without distortion is neither built so wide nor described by radial-tangential terms: the corners lie at 2.6
  /// focal lengths. The sensor reads its rows in 20 ms; those of dashcams take 11 to 32 ms. Daylight: exposures of a
  /// millisecond or less, whose motion blur is below half a pixel, are drawn without any. The camera has been stuck to
  /// the glass by hand, not quite straight.
  kDashcam,
};

/// The preset of that name: paper, kitti, dashcam.
std::optional<RigPreset> FindRigPreset(std::string_view name);

/// A car with a camera on it.
struct Rig {
  RigPreset preset = RigPreset::kPaper;  ///< what the other fields started from
  CameraModel camera;
  double rate_hz = 10;  ///< frames per second
  CameraMount mount;
  CarOptions vehicle;
  SensorOptions sensor;
  WindscreenOptions windscreen;
  RecorderOptions recorder;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
  Shutter ImageShutter() const;
};

Rig MakeRig(RigPreset preset);

/// Reads `rig.yaml`. Its key `preset` (see FindRigPreset; else `fallback`) gives what the file leaves out. Throws
/// InputError that names file, line and key for an unknown key (with the nearest known one), a value of another kind,
/// or one that makes no sense.
Rig ReadRig(const std::filesystem::path& path, RigPreset fallback = RigPreset::kPaper);

/// All of a rig as YAML, fit for ReadRig.
std::string RigText(const Rig& rig);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/rendering/renderer.h"
#include "turnscale/simulation/sensor.h"
#include "turnscale/simulation/vehicle.h"

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
};

/// A car with a camera on it.
struct Rig {
  RigPreset preset = RigPreset::kPaper;  ///< what the other fields started from
  CameraModel camera;
  double rate_hz = 10;  ///< frames per second
  CameraMount mount;
  CarOptions vehicle;
  SensorOptions sensor;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
  Shutter ImageShutter() const;
};

Rig MakeRig(RigPreset preset);

/// Reads `rig.yaml`. Its key `preset` (paper or kitti; else `fallback`) gives what the file leaves out. Throws
/// InputError that names file, line and key for an unknown key (with the nearest known one), a value of another kind,
/// or one that makes no sense.
Rig ReadRig(const std::filesystem::path& path, RigPreset fallback = RigPreset::kPaper);

/// All of a rig as YAML, fit for ReadRig.
std::string RigText(const Rig& rig);

}  // namespace turnscale

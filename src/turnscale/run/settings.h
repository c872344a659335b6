// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "turnscale/frames/image_scaling.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/self_calibration.h"

namespace turnscale {

/// The methods by the names that options and files have for them.
inline constexpr std::initializer_list<std::pair<const char*, ScaleMethod>> kScaleMethods = {
    {"smoothed", ScaleMethod::kSmoothed}, {"turns", ScaleMethod::kTurns}, {"paper", ScaleMethod::kPaper}};
std::vector<std::string> ScaleMethodNames();
std::string ScaleMethodName(ScaleMethod method);
std::optional<ScaleMethod> FindScaleMethod(std::string_view name);

/// All settings of a run: what settings.yaml holds.
struct Settings {
  OdometryOptions odometry;
  ImageOptions images;
  SelfCalibrationOptions self_calibration;  ///< used where no calibration is given, or where it is refined

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// All settings as YAML, fit for ReadSettings.
std::string SettingsText(const Settings& settings);

/// Reads settings; what the file leaves out keeps its default. Throws InputError that names file, line and key for an
/// unknown key (with its place or the nearest known one), a value of another kind, or one that makes no sense.
Settings ReadSettings(const std::filesystem::path& path);

/// The paper's Q from "yaw,pitch,roll" in degrees, or from a YAML file with yaw_deg, pitch_deg and roll_deg. Throws
/// InputError.
Eigen::Quaterniond ReadCameraRotation(const std::string& angles_or_file);

}  // namespace turnscale

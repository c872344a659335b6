// SPDX-License-Identifier: MIT
#include "turnscale/io/settings.h"

#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/parse.h"
#include "turnscale/config/yaml_map.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/field_reader.h"
#include "turnscale/io/field_writer.h"
#include "turnscale/io/settings_fields.h"

namespace turnscale {
namespace {

// The three angles of "yaw,pitch,roll"; nothing where the text is no such list.
std::optional<YawPitchRoll> ParseAngles(const std::string& text) {
  std::vector<double> degrees;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const auto words = SplitWords(std::string_view(text).substr(begin, end - begin));
    const auto value = words.size() == 1 ? ParseNumber<double>(words[0]) : std::nullopt;
    if (!value) return std::nullopt;
    degrees.push_back(*value);
    begin = end + 1;
  }
  if (degrees.size() != 3) return std::nullopt;
  return YawPitchRoll{degrees[0] / kDegreesPerRadian, degrees[1] / kDegreesPerRadian, degrees[2] / kDegreesPerRadian};
}

}  // namespace

std::string SettingsText(const OdometryOptions& options) {
  FieldWriter writer;
  OdometryOptions shown = options;
  VisitSettings(writer, shown);
  return writer.text;
}

OdometryOptions ReadSettings(const std::filesystem::path& path) {
  OdometryOptions options;
  FieldReader reader{YamlMap(path)};
  VisitSettings(reader, options);
  reader.AllowOnlyKnown();
  try {
    options.Check();
  } catch (const InputError& error) {
    throw InputError(path.string() + ": " + error.what());
  }
  return options;
}

Eigen::Quaterniond ReadCameraRotation(const std::string& angles_or_file) {
  std::optional<YawPitchRoll> angles = ParseAngles(angles_or_file);
  if (!angles) {
    std::error_code error;
    if (!std::filesystem::exists(angles_or_file, error)) {
      throw InputError(
          fmt::format("--camera-rotation '{}': is not a file; give yaw,pitch,roll in degrees, or a YAML file with "
                      "yaw_deg, pitch_deg, roll_deg",
                      angles_or_file));
    }
    const YamlMap map{std::filesystem::path(angles_or_file)};
    // A simulated drive's vehicle.yaml says more of the car than its rotation, and calibration.yaml where it is from.
    map.AllowOnly(std::vector<std::string>{"yaw_deg", "pitch_deg", "roll_deg", "lever_arm", "lateral_offset", "height",
                                           "side_slip", "yaw_sigma_deg", "pitch_sigma_deg", "roll_sigma_deg",
                                           "vehicle_from_camera_wxyz", "lever_arm_sigma", "side_slip_sigma",
                                           "confidence", "frames", "steps", "turns", "turning_deg", "input"});
    angles = YawPitchRoll{map.Number("yaw_deg") / kDegreesPerRadian, map.Number("pitch_deg") / kDegreesPerRadian,
                          map.Number("roll_deg") / kDegreesPerRadian};
  }
  for (const double angle : {angles->yaw, angles->pitch, angles->roll}) {
    if (!(std::abs(angle) * kDegreesPerRadian <= 180)) {
      throw InputError(
          fmt::format("--camera-rotation '{}': angles must be between -180 and 180 degrees", angles_or_file));
    }
  }
  return RotationFromYawPitchRoll(*angles);
}

}  // namespace turnscale

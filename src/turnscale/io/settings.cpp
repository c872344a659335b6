// SPDX-License-Identifier: MIT
#include "turnscale/io/settings.h"

#include <cmath>
#include <initializer_list>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/parse.h"
#include "turnscale/config/yaml_map.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/settings_fields.h"

namespace turnscale {
namespace {

template <class Value>
using Choices = std::initializer_list<std::pair<const char*, Value>>;

class Writer {
 public:
  template <class Fields>
  void Group(const char* name, const Fields& fields) {
    Line(name, "");
    indent_ += "  ";
    fields();
    indent_.resize(indent_.size() - 2);
  }

  template <class Value>
  void Field(const char* name, const Value& value) {
    Line(name, fmt::format(" {}", value));
  }

  void Field(const char* name, const std::optional<double>& value) {
    Line(name, value ? fmt::format(" {}", *value) : " none");
  }

  // Twelve digits give back the very radians that a round number of degrees was made of; + 0.0 unmakes a negative zero.
  void Degrees(const std::string& name, double radians) {
    Line(name, fmt::format(" {:.12g}", radians * kDegreesPerRadian + 0.0));
  }

  template <class Value>
  void Choice(const char* name, Value value, Choices<std::type_identity_t<Value>> choices) {
    for (const auto& [word, choice] : choices) {
      if (choice == value) Line(name, std::string(" ") + word);
    }
  }

  void Rotation(const std::string& prefix, const Eigen::Quaterniond& rotation) {
    const YawPitchRoll angles = YawPitchRollFromRotation(rotation);
    Degrees(prefix + "_yaw_deg", angles.yaw);
    Degrees(prefix + "_pitch_deg", angles.pitch);
    Degrees(prefix + "_roll_deg", angles.roll);
  }

  std::string text;

 private:
  void Line(const std::string& name, const std::string& value) { text += indent_ + name + ":" + value + "\n"; }

  std::string indent_;
};

class Reader {
 public:
  explicit Reader(const YamlMap& file) { levels_.push_back({file, {}}); }

  template <class Fields>
  void Group(const char* name, const Fields& fields) {
    if (!Known(name)) return;
    levels_.push_back({Map().Map(name), {}});
    fields();
    AllowOnlyKnown();
    levels_.pop_back();
  }

  void Field(const std::string& name, double& value) {
    if (Known(name)) value = Map().Number(name);
  }
  void Field(const std::string& name, int& value) {
    if (Known(name)) value = Map().Integer(name);
  }
  void Field(const std::string& name, bool& value) {
    if (Known(name)) value = Map().Bool(name);
  }
  void Field(const std::string& name, std::optional<double>& value) {
    if (!Known(name)) return;
    value = Map().Text(name) == "none" ? std::nullopt : std::optional(Map().Number(name));
  }

  void Degrees(const std::string& name, double& radians) {
    if (Known(name)) radians = Map().Number(name) / kDegreesPerRadian;
  }

  template <class Value>
  void Choice(const std::string& name, Value& value, Choices<std::type_identity_t<Value>> choices) {
    if (!Known(name)) return;
    const std::string text = Map().Text(name);
    std::string all;
    for (const auto& [choice_text, choice] : choices) {
      if (text == choice_text) {
        value = choice;
        return;
      }
      all += (all.empty() ? "" : " or ") + std::string(choice_text);
    }
    Map().Reject(name, fmt::format("is '{}'; give {}", text, all));
  }

  void Rotation(const std::string& prefix, Eigen::Quaterniond& rotation) {
    YawPitchRoll angles = YawPitchRollFromRotation(rotation);
    Degrees(prefix + "_yaw_deg", angles.yaw);
    Degrees(prefix + "_pitch_deg", angles.pitch);
    Degrees(prefix + "_roll_deg", angles.roll);
    rotation = RotationFromYawPitchRoll(angles);
  }

  void AllowOnlyKnown() const { Map().AllowOnly(levels_.back().known); }

 private:
  struct Level {
    YamlMap map;
    std::vector<std::string> known;  // keys asked for so far
  };

  const YamlMap& Map() const { return levels_.back().map; }
  bool Known(const std::string& name) {
    levels_.back().known.push_back(name);
    return Map().Has(name);
  }

  std::vector<Level> levels_;
};

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
  Writer writer;
  OdometryOptions shown = options;
  VisitSettings(writer, shown);
  return writer.text;
}

OdometryOptions ReadSettings(const std::filesystem::path& path) {
  OdometryOptions options;
  Reader reader{YamlMap(path)};
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
          fmt::format("--camera-rotation '{}': give three degrees as yaw,pitch,roll, or a YAML file with yaw_deg, "
                      "pitch_deg, roll_deg",
                      angles_or_file));
    }
    const YamlMap map{std::filesystem::path(angles_or_file)};
    map.AllowOnly(std::vector<std::string>{"yaw_deg", "pitch_deg", "roll_deg"});
    angles = YawPitchRoll{map.Number("yaw_deg") / kDegreesPerRadian, map.Number("pitch_deg") / kDegreesPerRadian,
                          map.Number("roll_deg") / kDegreesPerRadian};
  }
  for (const double angle : {angles->yaw, angles->pitch, angles->roll}) {
    if (!(std::abs(angle) * kDegreesPerRadian <= 180)) {
      throw InputError(fmt::format("--camera-rotation '{}': angles lie between -180 and 180 degrees", angles_or_file));
    }
  }
  return RotationFromYawPitchRoll(*angles);
}

}  // namespace turnscale

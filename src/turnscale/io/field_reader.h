// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

#include "turnscale/config/yaml_map.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/field_choices.h"

namespace turnscale {

/// Reads the fields that a visitor function shows it (see settings_fields.h); what the file leaves out keeps its value.
/// Throws InputError that names file, line and key for a value of another kind.
class FieldReader {
 public:
  explicit FieldReader(const YamlMap& file) { levels_.push_back({file, {}}); }

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

  /// A shorter list leaves the rest at zero.
  template <size_t kSize>
  void Field(const std::string& name, std::array<double, kSize>& values) {
    if (!Known(name)) return;
    const std::vector<double> numbers = Map().Numbers(name);
    if (numbers.size() > kSize)
      Map().Reject(name, fmt::format("holds {} numbers; give at most {}", numbers.size(), kSize));
    values.fill(0);
    std::copy(numbers.begin(), numbers.end(), values.begin());
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

  /// Throws InputError for the first key that no field asked for; to be called after the last field.
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

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/escaped_text.h"
#include "turnscale/config/yaml_map.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {

/// The words that a field of a settings file may hold, and what they mean.
template <class Value>
using Choices = std::initializer_list<std::pair<const char*, Value>>;

/// Reads the fields that a visitor function shows it (as in settings.cpp); what the file leaves out keeps its value.
/// Throws InputError that names file, line and key for a value of another kind.
class FieldReader {
 public:
  explicit FieldReader(const YamlMap& file) { levels_.push_back(file); }

  template <class Fields>
  void Group(const char* name, const Fields& fields) {
    if (!Map().Has(name)) return;
    levels_.push_back(Map().Map(name));
    fields();
    levels_.pop_back();
  }

  void Field(const std::string& name, double& value) {
    if (Map().Has(name)) value = Map().Number(name);
  }
  void Field(const std::string& name, int& value) {
    if (Map().Has(name)) value = Map().Integer(name);
  }
  void Field(const std::string& name, bool& value) {
    if (Map().Has(name)) value = Map().Bool(name);
  }
  void Field(const std::string& name, std::optional<double>& value) {
    if (Map().Has(name)) value = Map().NumberOrNone(name);
  }

  /// A shorter list leaves the rest at zero.
  template <size_t kSize>
  void Field(const std::string& name, std::array<double, kSize>& values) {
    if (!Map().Has(name)) return;
    const std::vector<double> numbers = Map().Numbers(name);
    if (numbers.size() > kSize)
      Map().Reject(name, fmt::format("holds {} numbers; give at most {}", numbers.size(), kSize));
    values.fill(0);
    std::copy(numbers.begin(), numbers.end(), values.begin());
  }

  void Degrees(const std::string& name, double& radians) {
    if (Map().Has(name)) radians = Map().Number(name) / kDegreesPerRadian;
  }

  template <class Value>
  void Choice(const std::string& name, Value& value, Choices<std::type_identity_t<Value>> choices) {
    if (!Map().Has(name)) return;
    const std::string text = Map().Text(name);
    std::string all;
    for (const auto& [choice_text, choice] : choices) {
      if (text == choice_text) {
        value = choice;
        return;
      }
      all += (all.empty() ? "" : " or ") + std::string(choice_text);
    }
    Map().Reject(name, fmt::format("is '{}'; give {}", Excerpt(text), all));
  }

  void Rotation(const std::string& prefix, Eigen::Quaterniond& rotation) {
    YawPitchRoll angles = YawPitchRollFromRotation(rotation);
    const auto read = [&](const char* name, double& radians) {
      if (Map().Has(prefix + name)) radians = Map().Angle(prefix + name) / kDegreesPerRadian;
    };
    read("_yaw_deg", angles.yaw);
    read("_pitch_deg", angles.pitch);
    read("_roll_deg", angles.roll);
    rotation = RotationFromYawPitchRoll(angles);
  }

 private:
  const YamlMap& Map() const { return levels_.back(); }

  std::vector<YamlMap> levels_;
};

/// Collects the names of the fields and groups that a visitor function shows it, with those of the groups around them:
/// "scale", "scale.drift", "scale.drift.per_100m".
class FieldNames {
 public:
  template <class Fields>
  void Group(const std::string& name, const Fields& fields) {
    Add(name);
    const std::string around = prefix_;
    prefix_ += name + ".";
    fields();
    prefix_ = around;
  }

  template <class Value>
  void Field(const std::string& name, const Value& /*value*/) {
    Add(name);
  }

  void Degrees(const std::string& name, double /*radians*/) { Add(name); }

  template <class Value>
  void Choice(const std::string& name, Value /*value*/, Choices<std::type_identity_t<Value>> /*choices*/) {
    Add(name);
  }

  void Rotation(const std::string& prefix, const Eigen::Quaterniond& /*rotation*/) {
    for (const char* angle : {"_yaw_deg", "_pitch_deg", "_roll_deg"}) Add(prefix + angle);
  }

  std::vector<std::string> names;

 private:
  void Add(const std::string& name) { names.push_back(prefix_ + name); }

  std::string prefix_;
};

/// Writes each field that a visitor function shows it as a line of YAML (as in settings.cpp).
class FieldWriter {
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

  template <size_t kSize>
  void Field(const char* name, const std::array<double, kSize>& values) {
    Line(name, fmt::format(" [{}]", fmt::join(values, ", ")));
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

}  // namespace turnscale

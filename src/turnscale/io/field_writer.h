// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>
#include <type_traits>

#include <fmt/format.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/io/field_choices.h"

namespace turnscale {

/// Writes each field that a visitor function shows it as a line of YAML (see settings_fields.h).
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

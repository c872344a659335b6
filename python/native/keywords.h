// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "turnscale/commands/calibrate_command.h"
#include "turnscale/commands/evaluate_command.h"
#include "turnscale/commands/rescale_command.h"
#include "turnscale/commands/run_command.h"

namespace turnscale {

/// Name of a camera that is no file, in summaries and messages.
inline constexpr auto kCameraObject = "turnscale.Camera";

/// Options by the names of the program's. Those that are absent or None keep their default. Raises TypeError where a
/// value is of another kind, and for names that nothing asks for.
class Keywords {
 public:
  explicit Keywords(const pybind11::dict& given) : given_(given.attr("copy")()) {}

  template <class Value>
  void Take(const char* name, Value& value) {
    if (const std::optional<Value> given = Given<Value>(name)) value = *given;
  }
  template <class Value>
  void Take(const char* name, std::optional<Value>& value) {
    if (const std::optional<Value> given = Given<Value>(name)) value = given;
  }
  /// After all was taken.
  void RefuseOthers() const;

 private:
  template <class Value>
  std::optional<Value> Given(const char* name) {
    if (!given_.contains(name)) return std::nullopt;
    const pybind11::object value = given_.attr("pop")(name);
    if (value.is_none()) return std::nullopt;
    try {
      return value.cast<Value>();
    } catch (const pybind11::cast_error&) {
      RefuseKind(name, Expected<Value>(), value);
    }
  }

  template <class Value>
  static constexpr const char* Expected() {
    if constexpr (std::is_same_v<Value, bool>) return "True or False";
    if constexpr (std::is_same_v<Value, std::string>) return "a string";
    if constexpr (std::is_same_v<Value, std::filesystem::path>) return "a path (str or os.PathLike)";
    if constexpr (std::is_same_v<Value, std::vector<std::filesystem::path>>) return "paths (str or os.PathLike)";
    if constexpr (std::is_same_v<Value, CameraModel>) return kCameraObject;
    return std::is_integral_v<Value> ? "an integer" : "a number";
  }
  [[noreturn]] static void RefuseKind(const char* name, const char* expected, const pybind11::object& value);

  pybind11::dict given_;
};

RunArguments RunArgumentsFrom(const pybind11::dict& given);
CalibrateArguments CalibrateArgumentsFrom(const pybind11::dict& given);
RescaleArguments RescaleArgumentsFrom(const pybind11::dict& given);
EvaluateArguments EvaluateArgumentsFrom(const pybind11::dict& given);

/// Of the car, for an odometry that is given its images one by one.
struct OdometryArguments {
  CarArguments car;
  std::filesystem::path camera_name = kCameraObject;  ///< its file, if there is one
  std::optional<std::filesystem::path> settings;
  std::optional<std::filesystem::path> mask;
  int threads = kImageThreads;
};
OdometryArguments OdometryArgumentsFrom(const pybind11::dict& given);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>

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
      throw pybind11::type_error(std::string(name) + ": " + pybind11::repr(value).cast<std::string>() +
                                 " is of another kind than this option has");
    }
  }

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

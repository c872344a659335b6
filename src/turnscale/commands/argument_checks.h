// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"
#include "turnscale/commands/option_rules.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/run_files.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {

/// Value of --side-slip, s^2/m. Throws InputError if it is out of range.
inline double CheckedSideSlip(double side_slip) {
  if (side_slip >= 0 && side_slip < 1) return side_slip;
  throw InputError(
      fmt::format("--side-slip {}: give c in s^2/m, from 0 (no slip) to below 1; typical cars have about {}", side_slip,
                  kUsualSideSlip));
}

/// Value of --lever-arm, metres. Throws InputError if it is out of range.
inline double CheckedLeverArm(double lever_arm) {
  if (lever_arm > 0 && lever_arm <= kLongestLeverArm) return lever_arm;
  throw InputError(fmt::format(
      "--lever-arm {}: give the distance from the rear axle forward to the camera in metres, above 0 and up to {}",
      lever_arm, kLongestLeverArm));
}

/// Value of --lever-arm-sigma, metres, of a lever arm where one is known.
inline double CheckedLeverArmSigma(double sigma, const std::optional<double>& lever_arm) {
  if (!(sigma >= 0 && sigma <= 1))
    throw InputError(fmt::format("--lever-arm-sigma {}: give metres, from 0 (known exactly) to 1", sigma));
  if (lever_arm && sigma >= *lever_arm)
    throw InputError(fmt::format("--lever-arm-sigma {}: has to be below the lever arm, {} m", sigma, *lever_arm));
  return sigma;
}

/// Value of --camera-height: metres, with a standard deviation in metres where one is given. ParseCameraHeight throws
/// InputError if one is out of range, or if the standard deviation is so large that a decimal comma is more likely.
struct CameraHeight {
  double metres = 0;
  std::optional<double> sigma;
};
inline CameraHeight ParseCameraHeight(const std::string& text) {
  constexpr double kLargestShare = 0.2;
  const std::size_t comma = text.find(',');
  const std::optional<double> metres = ParseNumber<double>(std::string_view(text).substr(0, comma));
  std::optional<double> sigma;
  if (comma != std::string::npos) sigma = ParseNumber<double>(std::string_view(text).substr(comma + 1));
  if (metres && *metres > 0 && *metres <= kHighestCamera &&
      (comma == std::string::npos || (sigma && *sigma > 0 && *sigma < *metres))) {
    if (!sigma || *sigma <= kLargestShare * *metres) return {*metres, sigma};
    throw InputError(fmt::format(
        "--camera-height {}: means {} m with a standard deviation of {} m, which is above {:.0f} %; measure "
        "the height, and write decimals with a point",
        text, *metres, *sigma, 100 * kLargestShare));
  }
  throw InputError(
      fmt::format("--camera-height {}: give the height of the camera above the road in metres, above 0 and up to {}, "
                  "or H,SIGMA with its standard deviation in metres, above 0 and up to a fifth of H",
                  text, kHighestCamera));
}

/// Value of --side-slip-sigma, s^2/m.
inline double CheckedSideSlipSigma(double sigma) {
  if (sigma >= 0 && sigma < 1) return sigma;
  throw InputError(fmt::format("--side-slip-sigma {}: give s^2/m, from 0 (known exactly) to below 1", sigma));
}

/// Throws InputError unless the value of --threads is a number of threads.
inline void CheckThreads(int threads) {
  if (threads < 1) throw InputError(fmt::format("--threads {}: give at least 1", threads));
}

/// An option by its name on the command line, and whether it is given.
struct GivenOption {
  const char* name;
  bool given;
};

/// Throws InputError if both are given.
inline void RefuseBoth(const GivenOption& one, const GivenOption& other) {
  if (one.given && other.given) throw InputError(fmt::format("{}: excludes {}", one.name, other.name));
}

/// Throws InputError if the option is given without any of those that it needs, which `needed` names.
inline void RequireFor(const GivenOption& option, bool has_needed, const char* needed) {
  if (option.given && !has_needed) throw InputError(fmt::format("{}: needs {}", option.name, needed));
}

/// Throws InputError if the options that are given break a rule. `options`: all that the rules name.
inline void CheckTogether(const OptionRules& rules, const std::vector<GivenOption>& options) {
  const auto named = [&](std::string_view name) {
    const auto found = std::ranges::find_if(options, [&](const GivenOption& option) { return option.name == name; });
    Ensure(found != options.end(), "a rule names an option that there is");
    return *found;
  };
  for (const auto& [one, other] : rules.exclusive) RefuseBoth(named(one), named(other));
  for (const auto& [one, other] : rules.needs) RequireFor(named(one), named(other).given, other);
}

/// Throws InputError unless the option's value is one of those that there are.
template <typename Names>
void CheckChoice(const char* option, std::string_view value, const Names& choices) {
  if (std::ranges::find(choices, value) != std::ranges::end(choices)) return;
  throw InputError(fmt::format("{} {}: give one of {}", option, value, fmt::join(choices, ", ")));
}

inline void CheckChoice(const char* option, std::string_view value, std::initializer_list<std::string_view> choices) {
  CheckChoice<std::initializer_list<std::string_view>>(option, value, choices);
}

/// A file that a command writes, and the option that names it.
struct NamedOutput {
  const char* option;
  std::filesystem::path file;  ///< empty: not written
};

/// Throws the InputError on an output that cannot be written there.
[[noreturn]] inline void RefuseOutput(const char* option, const std::filesystem::path& file, const std::string& why) {
  throw InputError(fmt::format("{} {}: {}; choose another {}", option, file.string(), why, option));
}

/// The file whatever way its path leads to it; empty where that cannot be examined.
inline std::filesystem::path PlaceOf(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::path place = std::filesystem::weakly_canonical(std::filesystem::absolute(file, error), error);
  return error ? std::filesystem::path() : place;
}

/// Throws InputError if an output file, or its name while it is being written, is also an input file or another output.
/// Empty paths are ignored, and among outputs devices, pipes and what cannot be examined: writing to it says why.
inline void CheckOutputs(const std::vector<NamedOutput>& outputs, const std::vector<std::filesystem::path>& inputs) {
  std::map<std::filesystem::path, const char*> options;
  for (const NamedOutput& output : outputs) {
    if (output.file.empty()) continue;
    std::error_code none;
    const bool is_special = exists(output.file, none) && !is_regular_file(output.file, none);
    for (const std::filesystem::path& written : {output.file, PartOf(output.file)}) {
      for (const std::filesystem::path& input : inputs)
        if (!input.empty() && std::filesystem::equivalent(written, input, none))
          RefuseOutput(output.option, written, "is also an input file, and would be replaced");
      const std::filesystem::path place = PlaceOf(written);
      if (is_special || place.empty()) continue;
      const auto [other, first] = options.try_emplace(place, output.option);
      if (!first) RefuseOutput(output.option, written, fmt::format("is also a file of {}", other->second));
    }
  }
}

/// Throws InputError if an output file is a result of a run, which is not to be replaced by another command's.
inline void RefuseResultsOfRun(const std::vector<NamedOutput>& outputs) {
  for (const NamedOutput& output : outputs) {
    const std::filesystem::path place = PlaceOf(output.file);
    if (output.file.empty() || place.empty()) continue;
    const bool has_name =
        std::ranges::any_of(RunFiles::kAll, [&](const char* name) { return place.filename() == name; });
    if (has_name && IsFolderOfRun(place.parent_path()))
      RefuseOutput(output.option, output.file, "is a file of the results of a run");
  }
}

}  // namespace turnscale

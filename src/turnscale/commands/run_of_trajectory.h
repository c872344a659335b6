// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace turnscale {

/// State of a scale that is not known, in a summary.
inline constexpr std::string_view kPendingScale = "pending";

/// The scale in the summary of the run that a trajectory is a result of; null if it is of none.
nlohmann::json ScaleOfRun(const std::filesystem::path& trajectory);

/// Its state; empty if there is none.
std::string ScaleStateOfRun(const std::filesystem::path& trajectory);

/// Whether a trajectory is a result of `run --frame vehicle`, in metres: its poses are the rear axle's.
bool IsOfRearAxle(const std::filesystem::path& trajectory);

}  // namespace turnscale

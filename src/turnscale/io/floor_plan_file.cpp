// SPDX-License-Identifier: MIT
#include "turnscale/io/floor_plan_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"

namespace turnscale {
namespace {

constexpr auto kHeader = "outline,x_m,z_m";

struct Corner {
  int outline = 0;
  Eigen::Vector2d place;
};

std::optional<Corner> ParseCorner(std::string line) {
  std::replace(line.begin(), line.end(), ',', ' ');
  const auto words = SplitWords(line);
  if (words.size() != 3) return std::nullopt;
  const auto outline = ParseNumber<int>(words[0]);
  const auto x = ParseNumber<double>(words[1]);
  const auto z = ParseNumber<double>(words[2]);
  if (!outline || !x || !z || !std::isfinite(*x) || !std::isfinite(*z)) return std::nullopt;
  return Corner{*outline, {*x, *z}};
}

}  // namespace

std::string FloorPlanText(const FloorPlan& plan) {
  std::string text = std::string(kHeader) + "\n";
  for (size_t i = 0; i < plan.size(); ++i) {
    for (const Eigen::Vector2d& corner : plan[i]) text += fmt::format("{},{:.6g},{:.6g}\n", i, corner.x(), corner.y());
  }
  return text;
}

FloorPlan ReadFloorPlan(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw InputError(path.string() + ": no such floor plan");
  std::ifstream stream(path);
  std::string line;
  if (std::filesystem::is_directory(path, error) || !std::getline(stream, line) || !line.starts_with(kHeader)) {
    throw InputError(fmt::format("{}: is not a floor plan, which begins with the line {}", path.string(), kHeader));
  }
  FloorPlan plan;
  std::optional<int> outline;
  for (int number = 2; std::getline(stream, line); ++number) {
    const std::optional<Corner> corner = ParseCorner(line);
    if (!corner) {
      throw InputError(fmt::format("{}:{}: '{}' is not a corner; expected {}", path.string(), number, line, kHeader));
    }
    if (outline != corner->outline) plan.emplace_back();
    outline = corner->outline;
    plan.back().push_back(corner->place);
  }
  return plan;
}

}  // namespace turnscale

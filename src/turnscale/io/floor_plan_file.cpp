// SPDX-License-Identifier: MIT
#include "turnscale/io/floor_plan_file.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/text_lines.h"

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
  TextLines lines(path, "floor plan");
  if (!lines.Next() || !lines.Line().starts_with(kHeader))
    throw InputError(fmt::format("{}: is not a floor plan, which begins with the line {}", path.string(), kHeader));
  FloorPlan plan;
  std::optional<int> outline;
  while (lines.Next()) {
    const std::optional<Corner> corner = ParseCorner(lines.Line());
    if (!corner) {
      throw InputError(
          fmt::format("{}: '{}' is not a corner; expected {}", lines.Where(), Excerpt(lines.Line()), kHeader));
    }
    if (outline != corner->outline) plan.emplace_back();
    outline = corner->outline;
    plan.back().push_back(corner->place);
  }
  return plan;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/frames/clip_names.h"

#include <algorithm>
#include <cctype>
#include <string>

#include <fmt/format.h>

#include "turnscale/base/number_text.h"
#include "turnscale/frames/drive_input.h"

namespace turnscale {
namespace {

constexpr size_t kStemSize = 8;

// Names that stand for one another in natural order: those of chapters begin with their recording.
std::string SortName(std::string_view name) {
  const std::string_view stem = name.substr(0, name.rfind('.'));
  const std::optional<Chapter> chapter = ChapterInName(stem);
  if (!chapter) return std::string(name);
  return fmt::format("GOPR{:04}_{:02}{}", chapter->recording, chapter->number, name.substr(stem.size()));
}

}  // namespace

std::optional<Chapter> ChapterInName(std::string_view stem) {
  if (stem.size() != kStemSize) return std::nullopt;
  std::string upper(stem);
  std::ranges::transform(upper, upper.begin(), [](unsigned char c) { return std::toupper(c); });
  const bool first = upper.starts_with("GOPR");
  if (!first && (upper[0] != 'G' || std::string_view("HXLP").find(upper[1]) == std::string_view::npos))
    return std::nullopt;
  const size_t digits = first ? 4 : 2;
  if (upper.find_first_not_of("0123456789", digits) != std::string::npos) return std::nullopt;
  const std::string_view number = std::string_view(upper).substr(digits);
  const int value = ParseNumber<int>(number).value_or(0);
  return first ? Chapter{value, 0} : Chapter{value % 10'000, value / 10'000};
}

bool ClipNameLess(std::string_view a, std::string_view b) {
  const std::string sort_a = SortName(a);
  const std::string sort_b = SortName(b);
  return sort_a == sort_b ? NaturalLess(a, b) : NaturalLess(sort_a, sort_b);
}

}  // namespace turnscale

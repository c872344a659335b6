// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <system_error>

namespace turnscale {

/// Free text as a cell that CsvTable reads back: quoted, as its commas would part it. An empty text is an empty cell.
inline std::string QuotedCell(const std::string& text) {
  if (text.empty()) return {};
  std::string quoted(1, '"');
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  return quoted.append(1, '"');
}

/// A positive number with so many digits, at most 16; what is not positive or not finite is not known: an empty cell.
inline std::string PositiveCell(double value, int digits = 6) {
  if (!(value > 0 && std::isfinite(value))) return {};
  std::array<char, 32> text{};
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, digits);
  return {text.data(), end};
}

}  // namespace turnscale

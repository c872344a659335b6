// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cctype>
#include <string_view>

namespace turnscale {

/// The order that people give numbered names: runs of digits compare as numbers, so 9.png comes before 10.png.
inline bool NaturalLess(std::string_view a, std::string_view b) {
  const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  const auto digits_at = [&](std::string_view text) {
    size_t size = 0;
    while (size < text.size() && is_digit(text[size])) ++size;
    return text.substr(0, size);
  };
  const std::string_view whole_a = a;
  const std::string_view whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const std::string_view run_a = digits_at(a);
      const std::string_view run_b = digits_at(b);
      const auto value = [](std::string_view run) {
        return run.substr(std::min(run.find_first_not_of('0'), run.size()));
      };
      const std::string_view value_a = value(run_a);
      const std::string_view value_b = value(run_b);
      if (value_a.size() != value_b.size()) return value_a.size() < value_b.size();
      if (value_a != value_b) return value_a < value_b;
      a.remove_prefix(run_a.size());
      b.remove_prefix(run_b.size());
    } else {
      if (a.front() != b.front()) return a.front() < b.front();
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  if (a.empty() != b.empty()) return a.empty();
  // Names equal but for leading zeros still need one fixed order.
  return whole_a < whole_b;
}

}  // namespace turnscale

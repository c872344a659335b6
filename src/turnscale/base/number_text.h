// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace turnscale {

/// The shortest text that reads back as the same number, whatever the locale.
inline std::string NumberText(double value) {
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general);
  return {text.data(), end};
}

}  // namespace turnscale

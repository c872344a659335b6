// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace turnscale {

/// A text as it stands between the tags of an SVG.
inline std::string EscapedXml(std::string_view text) {
  std::string escaped;
  for (const char c : text) escaped += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return escaped;
}

}  // namespace turnscale

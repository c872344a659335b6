// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace turnscale {

/// How many bytes the UTF-8 character takes that `text` begins with; 0 where there is none.
inline size_t Utf8Length(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  if (text.empty()) return 0;
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const size_t length = lead >= 0xC2 && lead < 0xE0   ? 2
                        : lead >= 0xE0 && lead < 0xF0 ? 3
                        : lead >= 0xF0 && lead < 0xF5 ? 4
                                                      : 0;
  if (length == 0 || text.size() < length) return 0;
  for (size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  // Neither longer than it has to be, nor half of a UTF-16 pair, nor beyond Unicode.
  const bool overlong = (lead == 0xE0 && byte(1) < 0xA0) || (lead == 0xF0 && byte(1) < 0x90);
  const bool surrogate = lead == 0xED && byte(1) >= 0xA0;
  const bool beyond = lead == 0xF4 && byte(1) >= 0x90;
  return overlong || surrogate || beyond ? 0 : length;
}

/// The text as a terminal may see it: control characters (also U+0080 to U+009F, which some terminals obey) and bytes
/// that are not UTF-8 become \xNN. Characters in `kept` stay.
inline std::string Printable(std::string_view text, std::string_view kept = "") {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string printable;
  while (!text.empty()) {
    const size_t length = Utf8Length(text);
    const auto lead = static_cast<unsigned char>(text[0]);
    const bool control =
        lead < 0x20 || lead == 0x7F || (length == 2 && lead == 0xC2 && static_cast<unsigned char>(text[1]) < 0xA0);
    if (kept.find(text[0]) != std::string_view::npos || (length > 0 && !control)) {
      printable += text.substr(0, length);
    } else {
      for (const char c : text.substr(0, length == 0 ? 1 : length)) {
        const auto value = static_cast<unsigned char>(c);
        printable += {'\\', 'x', kDigits[value >> 4], kDigits[value & 15]};
      }
    }
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return printable;
}

/// What a user wrote, as a message may quote it: printable, and cut after some 40 characters.
inline std::string Excerpt(std::string_view text) {
  constexpr size_t kMost = 40;
  std::string excerpt;
  while (!text.empty()) {
    if (excerpt.size() >= kMost) return excerpt + "...";
    const size_t length = std::max<size_t>(Utf8Length(text), 1);
    excerpt += Printable(text.substr(0, length));
    text.remove_prefix(length);
  }
  return excerpt;
}

/// Printable, and without the other characters that neither XML nor YAML can hold: U+FFFE and U+FFFF.
inline std::string PrintableInFiles(std::string_view text) {
  std::string printable = Printable(text);
  for (size_t at = 0; (at = printable.find("\xEF\xBF", at)) != std::string::npos; ++at) {
    if (printable[at + 2] == '\xBE') printable.replace(at, 3, "\\xef\\xbf\\xbe");
    if (printable[at + 2] == '\xBF') printable.replace(at, 3, "\\xef\\xbf\\xbf");
  }
  return printable;
}

/// A text as it stands between the tags of XML or HTML. What XML cannot hold becomes \xNN.
inline std::string EscapedXml(std::string_view text) {
  std::string escaped;
  for (const char c : PrintableInFiles(text))
    escaped += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return escaped;
}

/// A text as a scalar of YAML in double quotes. What YAML cannot hold is read back as \xNN.
inline std::string QuotedYaml(std::string_view text) {
  std::string quoted(1, '"');
  for (const char c : PrintableInFiles(text)) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace turnscale

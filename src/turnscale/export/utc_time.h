// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace turnscale {

/// Seconds since 1970-01-01 00:00 UTC, without leap seconds, of a time such as 2026-03-22T07:14:05+01:00 (ISO 8601 with
/// date, time, optional decimals, and Z or an offset). Nothing for other text; a time without an offset is none, since
/// it means another moment in every place.
std::optional<double> ParseUtcTime(std::string_view text);

/// Whether these seconds count from 1970, not from the beginning of a drive: none lasts for years.
constexpr bool AreSince1970(double seconds) { return seconds > 3e8; }

/// Such as 2026-03-22T06:14:05.000Z: in UTC, with milliseconds.
std::string UtcTimeText(double seconds);

}  // namespace turnscale

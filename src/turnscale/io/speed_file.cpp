// SPDX-License-Identifier: MIT
#include "turnscale/io/speed_file.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/text_lines.h"
#include "turnscale/io/time_unit.h"

namespace turnscale {
namespace {

double SpeedAt(const SpeedLog& log, double time) {
  const auto after = std::lower_bound(log.times.begin(), log.times.end(), time);
  const auto i = static_cast<size_t>(after - log.times.begin());
  if (i == 0) return log.speeds.front();
  if (i == log.times.size()) return log.speeds.back();
  const double share = (time - log.times[i - 1]) / (log.times[i] - log.times[i - 1]);
  return (1 - share) * log.speeds[i - 1] + share * log.speeds[i];
}

// Where the lines have time and speed.
struct SpeedColumns {
  size_t time = 0;
  size_t speed = 1;
};

std::optional<size_t> ColumnNamed(const std::vector<std::string_view>& heading,
                                  std::initializer_list<std::string_view> names) {
  const auto found = std::ranges::find_if(
      heading, [&](std::string_view column) { return std::ranges::find(names, column) != names.end(); });
  return found == heading.end() ? std::nullopt : std::optional(static_cast<size_t>(found - heading.begin()));
}

// By the names in the heading; of two columns, the first is the time whatever they are called.
SpeedColumns ColumnsOf(const std::vector<std::string_view>& heading, const std::string& where) {
  const std::optional<size_t> time = ColumnNamed(heading, {"time", "t", "time_s", "t_s"});
  const std::optional<size_t> speed = ColumnNamed(heading, {"speed", "speed_mps", "v", "v_mps"});
  if (time && speed) return {*time, *speed};
  if (heading.size() == 2) return {};
  throw InputError(
      fmt::format("{}: has {} columns; name those that count 'time' (s) and 'speed' (m/s)", where, heading.size()));
}

}  // namespace

std::optional<double> SpeedLog::Distance(double begin, double end) const {
  if (times.empty() || begin < times.front() || end > times.back()) return std::nullopt;
  double metres = 0;
  double time = begin;
  double speed = SpeedAt(*this, begin);
  for (auto next = std::upper_bound(times.begin(), times.end(), begin); time < end; ++next) {
    const double until = next == times.end() ? end : std::min(*next, end);
    const double then = SpeedAt(*this, until);
    metres += 0.5 * (speed + then) * (until - time);
    time = until;
    speed = then;
    if (next == times.end()) break;
  }
  return metres;
}

SpeedLog ReadSpeedFile(const std::filesystem::path& path) {
  SpeedLog log;
  std::optional<SpeedColumns> named;
  for (TextLines lines(path, "file of speeds"); lines.Next();) {
    std::string line = lines.Line();
    std::replace(line.begin(), line.end(), ',', ' ');
    const auto words = SplitWords(line);
    if (words.empty() || words[0].starts_with('#')) continue;
    const std::string where = lines.Where();
    const bool heading = log.times.empty() && !named && std::ranges::none_of(words, [](std::string_view word) {
                           return ParseNumber<double>(word).has_value();
                         });
    if (heading) {
      named = ColumnsOf(words, where);
      continue;
    }
    const SpeedColumns columns = named.value_or(SpeedColumns());
    if (words.size() <= std::max(columns.time, columns.speed))
      throw InputError(where + ": expected 'time, speed' in s and m/s");
    if (!named && words.size() > 2)
      throw InputError(fmt::format(
          "{}: has {} columns, expected 'time, speed'; give a first line that names those that count 'time' (s) and "
          "'speed' (m/s)",
          where, words.size()));
    const auto time = ParseNumber<double>(words[columns.time]);
    const auto speed = ParseNumber<double>(words[columns.speed]);
    if (!time || !speed || !std::isfinite(*time) || !std::isfinite(*speed)) {
      throw InputError(fmt::format("{}: '{}, {}' is not a time and a speed", where, Excerpt(words[columns.time]),
                                   Excerpt(words[columns.speed])));
    }
    if (*speed < 0) throw InputError(fmt::format("{}: speed {} is negative; give it without direction", where, *speed));
    if (!log.times.empty() && *time <= log.times.back()) {
      throw InputError(fmt::format("{}: time {} does not come after {}", where, *time, log.times.back()));
    }
    log.times.push_back(*time);
    log.speeds.push_back(*speed);
  }
  if (log.times.size() < 2) throw InputError(path.string() + ": holds fewer than two speeds");
  log.times = InSeconds(std::move(log.times));
  return log;
}

}  // namespace turnscale

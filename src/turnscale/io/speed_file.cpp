// SPDX-License-Identifier: MIT
#include "turnscale/io/speed_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
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
  std::optional<double> unit = {};       // of the speed, m/s; nothing if it is not named
  std::optional<double> time_unit = {};  // s; likewise
};

struct TimeUnit {
  std::string_view name;  // letters only
  double seconds;
};

constexpr std::array kTimeUnits = {TimeUnit{"s", 1},
                                   TimeUnit{"sec", 1},
                                   TimeUnit{"secs", 1},
                                   TimeUnit{"second", 1},
                                   TimeUnit{"seconds", 1},
                                   TimeUnit{"ms", 1e-3},
                                   TimeUnit{"msec", 1e-3},
                                   TimeUnit{"msecs", 1e-3},
                                   TimeUnit{"millis", 1e-3},
                                   TimeUnit{"millisec", 1e-3},
                                   TimeUnit{"millisecond", 1e-3},
                                   TimeUnit{"milliseconds", 1e-3},
                                   TimeUnit{"us", 1e-6},
                                   TimeUnit{"usec", 1e-6},
                                   TimeUnit{"usecs", 1e-6},
                                   TimeUnit{"micros", 1e-6},
                                   TimeUnit{"microsec", 1e-6},
                                   TimeUnit{"microsecond", 1e-6},
                                   TimeUnit{"microseconds", 1e-6},
                                   TimeUnit{"ns", 1e-9},
                                   TimeUnit{"nsec", 1e-9},
                                   TimeUnit{"nsecs", 1e-9},
                                   TimeUnit{"nanos", 1e-9},
                                   TimeUnit{"nanosec", 1e-9},
                                   TimeUnit{"nanosecond", 1e-9},
                                   TimeUnit{"nanoseconds", 1e-9}};

struct SpeedUnit {
  std::string_view name;  // letters only
  double metres_per_second;
};

constexpr double kKnot = 0.51444;  // m/s
constexpr std::array kSpeedUnits = {SpeedUnit{"kmh", 1 / 3.6}, SpeedUnit{"kph", 1 / 3.6}, SpeedUnit{"kmph", 1 / 3.6},
                                    SpeedUnit{"mph", 0.44704}, SpeedUnit{"mps", 1},       SpeedUnit{"ms", 1},
                                    SpeedUnit{"kn", kKnot},    SpeedUnit{"kt", kKnot},    SpeedUnit{"kts", kKnot},
                                    SpeedUnit{"knot", kKnot},  SpeedUnit{"knots", kKnot}};

bool IsLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }

// Small letters, and u for the sign of micro: U+00B5 or U+03BC.
std::string Plain(std::string_view name) {
  std::string plain;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const std::string_view sign = name.substr(i, 2);
    const bool is_micro = sign == "\xC2\xB5" || sign == "\xCE\xBC";
    plain += is_micro ? 'u' : static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
    if (is_micro) ++i;
  }
  return plain;
}

// "Speed [km/h]" and "speed_kmh" are the same name.
std::string Letters(std::string_view name) {
  std::string letters = Plain(name);
  std::erase_if(letters, [](char c) { return !IsLetter(c); });
  return letters;
}

// The letters at the end; a bracket may follow.
std::string LastWord(std::string_view name) {
  std::string word = Plain(name);
  while (!word.empty() && !IsLetter(word.back())) word.pop_back();
  return word.substr(
      static_cast<std::size_t>(std::find_if_not(word.rbegin(), word.rend(), IsLetter).base() - word.begin()));
}

const SpeedUnit* FindUnit(std::string_view letters) {
  const auto found = std::ranges::find(kSpeedUnits, letters, &SpeedUnit::name);
  return found == kSpeedUnits.end() ? nullptr : &*found;
}

const TimeUnit* FindTimeUnit(std::string_view letters) {
  const auto found = std::ranges::find(kTimeUnits, letters, &TimeUnit::name);
  return found == kTimeUnits.end() ? nullptr : &*found;
}

// A time, with a unit that is known or without one.
bool IsTime(const std::string& column) {
  const std::string letters = Letters(column);
  return std::ranges::any_of(std::array{"timestamp", "time", "t"}, [&](const std::string_view time) {
    if (!letters.starts_with(time)) return false;
    const std::string unit = letters.substr(time.size());
    return unit.empty() || FindTimeUnit(unit) != nullptr;
  });
}

// What the name of a column of times has in brackets or after the word for a time; empty if there is neither.
std::string UnitLetters(const std::string& column) {
  if (column.ends_with(']') || column.ends_with(')')) return LastWord(column);
  const std::string letters = Letters(column);
  for (const std::string_view time : {"timestamp", "time", "stamp"})
    if (const size_t at = letters.rfind(time); at != std::string::npos) return letters.substr(at + time.size());
  if (!letters.starts_with('t')) return "";
  // Many words begin with it.
  const std::string rest = letters.substr(1);
  return Letters(column.substr(0, 2)) == "t" || FindTimeUnit(rest) != nullptr ? rest : "";
}

// Seconds; nothing if the name of the column has no unit. Throws InputError if the unit is not known.
std::optional<double> TimeUnitOf(const std::string& column, const std::string& where) {
  const std::string last = LastWord(column);
  if (const TimeUnit* known = FindTimeUnit(last)) return known->seconds;
  // Not seconds: plurals, and short for timestamp.
  constexpr std::array kNoUnit = {"times", "timestamps", "stamps", "ts"};
  if (std::ranges::find(kNoUnit, last) != kNoUnit.end()) return std::nullopt;
  const std::string unit = UnitLetters(column);
  if (unit.empty()) return std::nullopt;
  if (const TimeUnit* known = FindTimeUnit(unit)) return known->seconds;
  throw InputError(fmt::format("{}: the unit of '{}' is not known; give time_s, time_ms, time_us or time_ns", where,
                               Excerpt(column)));
}

// A speed, with a unit that is known or without one.
bool IsSpeed(const std::string& column) {
  const std::string letters = Letters(column);
  return std::ranges::any_of(std::array{"speed", "velocity", "v"}, [&](const std::string_view speed) {
    if (!letters.starts_with(speed)) return false;
    const std::string unit = letters.substr(speed.size());
    return unit.empty() || FindUnit(unit) != nullptr;
  });
}

// m/s; nothing if the name of the column has no unit. Throws InputError if the unit is not known.
std::optional<double> UnitOf(const std::string& column, const std::string& where) {
  const std::string letters = Letters(column);
  for (const std::string_view speed : {"speed", "velocity"}) {
    const size_t at = letters.rfind(speed);
    if (at == std::string::npos) continue;
    const std::string unit = letters.substr(at + speed.size());
    if (unit.empty()) return std::nullopt;
    if (const SpeedUnit* known = FindUnit(unit)) return known->metres_per_second;
    throw InputError(
        fmt::format("{}: the unit of '{}' is not known; give speed_mps, speed_kmh, speed_mph or speed_knots", where,
                    Excerpt(column)));
  }
  // In other languages, a unit that no other word ends with.
  for (const std::string_view unit : {"kmph", "kmh", "kph", "mph", "knots"})
    if (letters.ends_with(unit)) return FindUnit(unit)->metres_per_second;
  return std::nullopt;
}

// The names of the columns; a unit in brackets belongs to the name before it.
std::vector<std::string> NamesIn(const std::string& line) {
  std::vector<std::string> names;
  const bool commas = line.find(',') != std::string::npos;
  for (size_t begin = 0; begin <= line.size();) {
    const size_t end = std::min(commas ? line.find(',', begin) : std::string::npos, line.size());
    std::string name;
    for (const std::string_view word : SplitWords(std::string_view(line).substr(begin, end - begin))) {
      const bool goes_on = commas || word.starts_with('(') || word.starts_with('[');
      if (!goes_on && !name.empty()) names.push_back(std::exchange(name, ""));
      name += word;
    }
    names.push_back(name);
    begin = end + 1;
  }
  return names;
}

// By the names in the heading; of two columns, the first is the time whatever they are called.
SpeedColumns ColumnsOf(const std::vector<std::string>& heading, const std::string& where) {
  const auto time = std::ranges::find_if(heading, IsTime);
  const auto speed = std::ranges::find_if(heading, IsSpeed);
  SpeedColumns columns;
  if (time != heading.end() && speed != heading.end()) {
    columns.time = static_cast<size_t>(time - heading.begin());
    columns.speed = static_cast<size_t>(speed - heading.begin());
  } else if (heading.size() != 2) {
    throw InputError(
        fmt::format("{}: has {} columns; name those that count 'time' (s) and 'speed' (m/s), or 'speed_kmh'", where,
                    heading.size()));
  }
  columns.unit = UnitOf(heading[columns.speed], where);
  columns.time_unit = TimeUnitOf(heading[columns.time], where);
  return columns;
}

// Some programs write the heading as a comment; nothing if it is none.
std::optional<SpeedColumns> ColumnsOfComment(const std::string& line, const std::string& where) {
  const std::vector<std::string> names = NamesIn(line.substr(line.find('#') + 1));
  const bool is_heading = names.size() == 2 || line.find(',') != std::string::npos;
  const bool has_time = std::ranges::any_of(names, IsTime) || (names.size() == 2 && !UnitLetters(names[0]).empty());
  if (!is_heading || !has_time || std::ranges::none_of(names, IsSpeed)) return std::nullopt;
  return ColumnsOf(names, where);
}

// Throws InputError where a speed is none of a car, in m/s unless a unit is named.
void CheckSpeed(double speed, bool has_unit, const std::string& where) {
  constexpr double kFastest = 70;  // m/s
  if (speed < 0) throw InputError(fmt::format("{}: speed {} is negative; give it without direction", where, speed));
  if (!has_unit && speed > kFastest)
    throw InputError(fmt::format(
        "{}: speed {} is too fast for m/s; name the unit in the first line, such as 'time, speed_kmh' or 'time, "
        "speed_mph'",
        where, speed));
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
    const std::string& whole = lines.Line();
    std::string line = whole;
    std::replace(line.begin(), line.end(), ',', ' ');
    const auto words = SplitWords(line);
    const std::string where = lines.Where();
    if (words.empty()) continue;
    if (words[0].starts_with('#')) {
      if (log.times.empty() && !named) named = ColumnsOfComment(whole, where);
      continue;
    }
    if (words.size() == 1 && line.find(';') != std::string::npos)
      throw InputError(where + ": has semicolons; separate time and speed by commas or blanks");
    const bool heading = log.times.empty() && !named && std::ranges::none_of(words, [](std::string_view word) {
                           return ParseNumber<double>(word).has_value();
                         });
    if (heading) {
      named = ColumnsOf(NamesIn(whole), where);
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
    CheckSpeed(*speed, columns.unit.has_value(), where);
    if (!log.times.empty() && *time <= log.times.back()) {
      throw InputError(fmt::format("{}: time {} does not come after {}", where, *time, log.times.back()));
    }
    log.times.push_back(*time);
    log.speeds.push_back(columns.unit.value_or(1) * *speed);
  }
  if (log.times.size() < 2) throw InputError(path.string() + ": holds fewer than two speeds");
  log.names_unit = named && named->unit;
  if (named && named->time_unit) {
    for (double& time : log.times) time *= *named->time_unit;
    return log;
  }
  log.times = InSeconds(std::move(log.times));
  // A few speeds may be all that is known of a drive.
  constexpr size_t kLog = 10;
  if (log.times.size() >= kLog)
    RefuseSparseTimes(path.string(), log.times,
                      "Name the unit in the first line, such as 'time_ms, speed', or 'time_s, speed'");
  return log;
}

}  // namespace turnscale

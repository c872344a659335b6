// SPDX-License-Identifier: MIT
#include "turnscale/io/speed_file.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

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
  for (TextLines lines(path, "file of speeds"); lines.Next();) {
    std::string line = lines.Line();
    std::replace(line.begin(), line.end(), ',', ' ');
    const auto words = SplitWords(line);
    if (words.empty() || words[0].starts_with('#')) continue;
    const std::string where = lines.Where();
    if (words.size() < 2) throw InputError(where + ": expected 'time, speed' in s and m/s");
    const auto time = ParseNumber<double>(words[0]);
    const auto speed = ParseNumber<double>(words[1]);
    const bool heading = log.times.empty() && !time && !speed;
    if (heading) continue;
    if (!time || !speed || !std::isfinite(*time) || !std::isfinite(*speed) || *speed < 0) {
      throw InputError(
          fmt::format("{}: '{}, {}' is not a time and a speed", where, Excerpt(words[0]), Excerpt(words[1])));
    }
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

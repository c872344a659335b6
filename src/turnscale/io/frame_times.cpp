// SPDX-License-Identifier: MIT
#include "turnscale/io/frame_times.h"

#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/parse.h"

namespace turnscale {

FrameTimes ReadFrameTimes(const std::filesystem::path& path) {
  std::error_code error;
  std::ifstream stream(path);
  if (!std::filesystem::exists(path, error)) throw InputError(path.string() + ": no such file of frame times");
  if (!stream || std::filesystem::is_directory(path, error)) throw InputError(path.string() + ": cannot be read");
  FrameTimes result;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const auto words = SplitWords(line);
    if (words.empty() || words[0].starts_with('#')) continue;
    const auto time = ParseNumber<double>(words[0]);
    if (words.size() != 1 || !time || !std::isfinite(*time)) {
      throw InputError(fmt::format("{}:{}: '{}' is not a time; give one number per line, in seconds", path.string(),
                                   number, fmt::join(words, " ")));
    }
    if (!result.times.empty() && *time <= result.times.back()) {
      throw InputError(fmt::format("{}:{}: time {} {} the time before, {}; times must increase", path.string(), number,
                                   *time, *time < result.times.back() ? "goes back from" : "repeats",
                                   result.times.back()));
    }
    result.times.push_back(*time);
    result.lines.push_back(number);
  }
  if (result.times.empty()) throw InputError(path.string() + ": has no times; give one number per line, in seconds");
  return result;
}

void CheckTimesMatch(const FrameTimes& times, const std::filesystem::path& path, size_t frames,
                     const std::string& frames_of) {
  if (times.times.size() < frames) {
    throw InputError(fmt::format("{}:{}: ends after {} times, but {} has {} frames; give one time per frame",
                                 path.string(), times.lines.back(), times.times.size(), frames_of, frames));
  }
  if (times.times.size() > frames) {
    throw InputError(fmt::format("{}:{}: time {} has no frame: {} has only {}; give one time per frame", path.string(),
                                 times.lines[frames], frames + 1, frames_of, frames));
  }
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace turnscale {

/// Times of the frames in seconds, one a line; lines that are empty or begin with # are passed over.
struct FrameTimes {
  std::vector<double> times;
  std::vector<int> lines;  ///< where each stands in the file, from 1
};

/// Throws InputError that names the line where a time is no number, is NaN, goes back or repeats.
FrameTimes ReadFrameTimes(const std::filesystem::path& path);

/// Throws InputError that names the line where the file has fewer or more times than there are frames.
void CheckTimesMatch(const FrameTimes& times, const std::filesystem::path& path, size_t frames,
                     const std::string& frames_of);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace turnscale {

/// Times of the frames in seconds, one per line; lines that are empty or begin with # are passed over.
struct FrameTimes {
  std::vector<double> times;
  std::vector<int> lines;  ///< where each stands in the file, from 1
};

/// Throws InputError that names the line where a time is no number, is NaN, goes back or repeats.
FrameTimes ReadFrameTimes(const std::filesystem::path& path);

/// Throws InputError that names the line where the file has fewer or more times than there are frames.
void CheckTimesMatch(const FrameTimes& times, const std::filesystem::path& path, size_t frames,
                     const std::string& frames_of);

/// Tells when a frame was taken.
struct FrameClock {
  std::vector<double> times;  ///< of every frame; empty where the rate tells
  double fps = 0;

  double At(size_t index) const { return times.empty() ? static_cast<double>(index) / fps : times[index]; }
};

}  // namespace turnscale

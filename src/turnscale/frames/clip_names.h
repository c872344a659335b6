// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string_view>

namespace turnscale {

/// A file of a recording that the camera has split.
struct Chapter {
  int recording = 0;  ///< number of the recording
  int number = 0;     ///< of the file in the recording
};

/// What GoPro's name of a video tells, without extension: GX020123 (also GH, GL, GP) is chapter 2 of recording 123, and
/// GOPR0123, the first file in older models, chapter 0. Nothing for other names.
std::optional<Chapter> ChapterInName(std::string_view stem);

/// The order of the videos in a folder by their file names: natural order (NaturalLess), but the chapters of a
/// recording stand together.
bool ClipNameLess(std::string_view a, std::string_view b);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "turnscale/run/result_folder.h"

namespace turnscale {

/// The metric trajectory in the folder of `rescale --report`.
inline constexpr auto kRescaledTum = "rescaled.tum";

/// Whether the folder has the results of an earlier rescale, complete or killed: one that was killed leaves a part of
/// the summary, which is there before the other files.
bool IsRescaleFolder(const std::filesystem::path& folder);

/// What `rescale --report` has written, read back as if it were of a run: poses in metres, sigma of the scale, turns,
/// rotation of the camera; frames are numbered as the poses. Throws InputError that names the file where it is of an
/// earlier version, or incomplete, or the poses have no times.
ResultFolder ReadRescaleFolder(const std::filesystem::path& folder);

}  // namespace turnscale

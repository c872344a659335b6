// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/mapping/local_bundle_adjustment.h"
#include "turnscale/mapping/map_archive.h"

namespace turnscale {

/// Adjusts a whole drive whose keyframes are all archived, in sections of about `options.window` keyframes that
/// contain no gap, with pixels that are corrected for the readout of the camera's rows (CorrectRows): time is linear in
/// the drive, memory bounded by the section. Each section starts from where the one before it ends: poses and landmarks
/// follow in rotation, translation and scale. Moves the poses of `map` and the landmarks of the archive. Where it
/// throws, no pose has moved, but landmarks of some sections may have. Returns how many sections are not adjusted, as
/// they contain NaN.
int AdjustSections(const LocalBundleOptions& options, MapArchive& archive, Map& map);

}  // namespace turnscale

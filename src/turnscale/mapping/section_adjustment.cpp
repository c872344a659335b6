// SPDX-License-Identifier: MIT
#include "turnscale/mapping/section_adjustment.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <optional>
#include <vector>

#include "turnscale/geometry/similarity.h"
#include "turnscale/mapping/end_of_window.h"
#include "turnscale/mapping/map_scaling.h"
#include "turnscale/mapping/rolling_shutter.h"

namespace turnscale {
namespace {

struct Section {
  int first_fixed = 0;  ///< start of a block before, unless a gap is between
  int first = 0;
  int end = 0;
};

// Blocks joined to sections of about equal size between gaps. A section is held by `anchors` keyframes before it or
// more.
std::vector<Section> Sections(const MapArchive& archive, const Map& map, int section_keyframes, int anchors) {
  std::vector<Section> sections;
  const std::vector<int> ends = archive.BlockEnds();
  std::vector<int> starts = {0};  // of the blocks of a piece without gaps
  for (const int end : ends) {
    const bool piece_ends = end == ends.back() || map.keyframes[end].after_gap;
    if (!piece_ends) {
      starts.push_back(end);
      continue;
    }
    const int piece = starts.front();
    const int count = (end - piece + section_keyframes - 1) / section_keyframes;
    int first = piece;
    for (int i = 1; i <= count; ++i) {
      const int wanted = piece + (end - piece) * i / count;
      const auto distance = [&](int start) { return std::abs(start - wanted); };
      const int section_end = i == count ? end : *std::ranges::min_element(starts, {}, distance);
      if (section_end <= first) continue;
      const auto held = std::ranges::upper_bound(starts, std::max(first - anchors, piece));
      sections.push_back({*std::prev(held), first, section_end});
      first = section_end;
    }
    starts = {end};
  }
  return sections;
}

}  // namespace

int AdjustSections(const LocalBundleOptions& options, MapArchive& archive, Map& map) {
  // An exception on the way leaves all poses as they were. Landmarks of finished sections stay where they were moved.
  Map adjusted{map.camera, map.keyframes, {}};
  Similarity new_from_old;
  int failed = 0;
  for (const Section& section : Sections(archive, map, options.window, options.anchors)) {
    // Keyframes that hold the section have been adjusted, its own have not.
    ArchivedPart part = archive.Load(section.first_fixed, section.end, adjusted);
    const int first = section.first - section.first_fixed;
    const RigidTransform old_end = part.map.keyframes.back().camera_from_world;
    const std::vector<Eigen::Vector3d> before = KeyframeCentres(part.map, first);
    MoveFrom(first, new_from_old, {}, part.map);
    // Only now do the keyframes before the section fit to it.
    CorrectRows(part.map);
    if (AdjustFrom(options, first, part.map).failed) ++failed;
    for (size_t k = first; k < part.map.keyframes.size(); ++k)
      adjusted.keyframes[section.first_fixed + k].camera_from_world = part.map.keyframes[k].camera_from_world;
    archive.Store(part);
    const std::optional<double> scale = ScaleOfEnd(before, KeyframeCentres(part.map, first));
    const Similarity move =
        MoveOfEnd(old_end, part.map.keyframes.back().camera_from_world, scale.value_or(new_from_old.scale));
    if (move.translation.allFinite() && move.rotation.coeffs().allFinite()) new_from_old = move;
  }
  for (size_t k = 0; k < map.keyframes.size(); ++k)
    map.keyframes[k].camera_from_world = adjusted.keyframes[k].camera_from_world;
  return failed;
}

}  // namespace turnscale

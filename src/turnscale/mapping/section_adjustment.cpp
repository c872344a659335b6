// SPDX-License-Identifier: MIT
#include "turnscale/mapping/section_adjustment.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "turnscale/geometry/similarity.h"
#include "turnscale/mapping/map_scaling.h"

namespace turnscale {
namespace {

// Steps over which the change of scale at the end of a section is measured.
constexpr int kScaleSteps = 10;

struct Section {
  int first_fixed = 0;  ///< the block before, unless a gap is between
  int first = 0;
  int end = 0;
};

// Blocks joined to sections of about equal size between gaps.
std::vector<Section> Sections(const MapArchive& archive, const Map& map, int section_keyframes) {
  std::vector<Section> sections;
  const std::vector<int> ends = archive.BlockEnds();
  int piece = 0;
  for (size_t i = 0; i < ends.size(); ++i) {
    const bool piece_ends = i + 1 == ends.size() || map.keyframes[ends[i]].after_gap;
    if (!piece_ends) continue;
    const int count = (ends[i] - piece + section_keyframes - 1) / section_keyframes;
    const int size = (ends[i] - piece + count - 1) / count;
    Section section{piece, piece, piece};
    int block = piece;
    for (const int end : ends) {
      if (end <= piece || end > ends[i]) continue;
      section.end = end;
      if (end - section.first >= size || end == ends[i]) {
        sections.push_back(section);
        section = {block, end, end};
      }
      block = end;
    }
    piece = ends[i];
  }
  return sections;
}

RigidTransform Moved(const RigidTransform& camera_from_world, const Similarity& new_from_old) {
  // x_camera = s (R x_old + t) is what the camera sees once the world has grown by s.
  RigidTransform moved;
  moved.rotation = camera_from_world.rotation * new_from_old.rotation.conjugate();
  const Eigen::Vector3d centre = new_from_old * camera_from_world.inverse().translation;
  moved.translation = -(moved.rotation * centre);
  return moved;
}

void Move(const Similarity& new_from_old, int first, Map& map) {
  for (size_t k = first; k < map.keyframes.size(); ++k)
    map.keyframes[k].camera_from_world = Moved(map.keyframes[k].camera_from_world, new_from_old);
  for (Landmark& landmark : map.landmarks)
    if (!landmark.observations.empty() && landmark.observations.back().keyframe >= first)
      landmark.position = new_from_old * landmark.position;
}

double LengthOfEnd(const std::vector<Eigen::Vector3d>& centres) {
  double length = 0;
  const int last = static_cast<int>(centres.size()) - 1;
  for (int k = std::max(1, last - kScaleSteps + 1); k <= last; ++k) length += (centres[k] - centres[k - 1]).norm();
  return length;
}

// What takes the old world to the new one at the end of a section.
Similarity MoveOfEnd(const RigidTransform& old_camera, const RigidTransform& new_camera, double scale) {
  Similarity move;
  move.scale = scale;
  move.rotation = (new_camera.rotation.conjugate() * old_camera.rotation).normalized();
  move.translation = new_camera.inverse().translation - scale * (move.rotation * old_camera.inverse().translation);
  return move;
}

}  // namespace

void AdjustSections(const LocalBundleOptions& options, double correction, MapArchive& archive, Map& map) {
  Similarity new_from_old;
  for (const Section& section : Sections(archive, map, options.window)) {
    ArchivedPart part = archive.Load(section.first_fixed, section.end, correction, map);
    const int first = section.first - section.first_fixed;
    const RigidTransform old_end = part.map.keyframes.back().camera_from_world;
    const double old_length = LengthOfEnd(KeyframeCentres(part.map));
    Move(new_from_old, first, part.map);
    AdjustFrom(options, first, part.map);
    for (size_t k = first; k < part.map.keyframes.size(); ++k)
      map.keyframes[section.first_fixed + k].camera_from_world = part.map.keyframes[k].camera_from_world;
    archive.Store(part);
    const double length = LengthOfEnd(KeyframeCentres(part.map));
    const double scale = old_length > 0 && length > 0 ? length / old_length : new_from_old.scale;
    new_from_old = MoveOfEnd(old_end, part.map.keyframes.back().camera_from_world, scale);
  }
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/mapping/end_of_window.h"

#include <algorithm>

namespace turnscale {
namespace {

// Mean steps over which the change of scale at the end is measured.
constexpr int kScaleSteps = 10;
// What has shrunk or grown beyond this has gone astray.
constexpr double kLeastScale = 0.2;

}  // namespace

std::optional<double> ScaleOfEnd(const std::vector<Eigen::Vector3d>& before,
                                 const std::vector<Eigen::Vector3d>& after) {
  double whole = 0;
  for (size_t k = 1; k < before.size(); ++k) whole += (before[k] - before[k - 1]).norm();
  const double enough = kScaleSteps * whole / static_cast<double>(before.size());
  double length_before = 0;
  double length_after = 0;
  for (size_t k = before.size() - 1; k > 0 && length_before < enough; --k) {
    length_before += (before[k] - before[k - 1]).norm();
    length_after += (after[k] - after[k - 1]).norm();
  }
  const double scale = length_after / length_before;
  if (!(scale > kLeastScale && scale < 1 / kLeastScale)) return std::nullopt;
  return scale;
}

Similarity MoveOfEnd(const RigidTransform& old_camera, const RigidTransform& new_camera, double scale) {
  Similarity move;
  move.scale = scale;
  move.rotation = (new_camera.rotation.conjugate() * old_camera.rotation).normalized();
  move.translation = new_camera.inverse().translation - scale * (move.rotation * old_camera.inverse().translation);
  return move;
}

RigidTransform Moved(const RigidTransform& camera_from_world, const Similarity& new_from_old) {
  // x_camera = s (R x_old + t) is what the camera sees once the world has grown by s.
  RigidTransform moved;
  moved.rotation = camera_from_world.rotation * new_from_old.rotation.conjugate();
  const Eigen::Vector3d centre = new_from_old * camera_from_world.inverse().translation;
  moved.translation = -(moved.rotation * centre);
  return moved;
}

void MoveFrom(int first, const Similarity& new_from_old, const std::vector<int>& others, Map& map) {
  const int keyframes = CountKeyframes(map);
  for (const int index : LandmarksSeen(map, first, keyframes - 1)) {
    Eigen::Vector3d& position = map.landmarks[index].position;
    if (!std::ranges::binary_search(others, index)) position = new_from_old * position;
  }
  for (int k = first; k < keyframes; ++k)
    map.keyframes[k].camera_from_world = Moved(map.keyframes[k].camera_from_world, new_from_old);
}

}  // namespace turnscale

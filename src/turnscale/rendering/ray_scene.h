// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/rendering/scene.h"

namespace turnscale {

/// Rays are cast by so many at a time, which is several times faster than one by one where they run alike.
inline constexpr int kPacket = 8;

struct Ray {
  Eigen::Vector3f origin;
  Eigen::Vector3f direction;  ///< unit
  float start = 0;            ///< nothing nearer counts, metres
  float end = std::numeric_limits<float>::infinity();
  float time = 0.5F;  ///< from 0, the shutter's first moment, to 1, its last
  float width = 0;    ///< angle over which it is to gather what it shows, radians
};

/// What a ray meets. `mesh` is 0 for the fixed one, 1 + i for movable i, negative where there is nothing.
struct Hit {
  int mesh = -1;
  int triangle = 0;
  float distance = std::numeric_limits<float>::infinity();
  float u = 0;  ///< weight of the triangle's second vertex
  float v = 0;  ///< weight of the third
};

/// A scene with its movable meshes in their places, as Embree holds it. Copies share it.
class PlacedScene {
 public:
  /// Hits of at most kPacket rays. `alike`: they run nearly in parallel.
  void Intersect(std::span<const Ray> rays, bool alike, std::span<Hit> hits) const;
  /// Whether anything is between a ray's start and end, for at most kPacket rays.
  void FindBlocked(std::span<const Ray> rays, bool alike, std::span<bool> blocked) const;

 private:
  friend class RayScene;
  std::shared_ptr<void> scene_;
};

/// Triangles of a scene, ready to be put in their places.
class RayScene {
 public:
  explicit RayScene(const Scene& scene);

  /// `world_from_movable`: poses of each movable mesh, evenly over the shutter's time (one, or as many for all).
  PlacedScene Place(const std::vector<std::vector<RigidTransform>>& world_from_movable) const;

  /// The fixed mesh alone, or a movable one in its own frame; `mesh` as in Hit, hits are of mesh 0.
  PlacedScene Alone(int mesh) const;

 private:
  std::shared_ptr<void> device_;
  std::vector<std::shared_ptr<void>> meshes_;  // a scene each: the fixed mesh, then the movable ones
};

}  // namespace turnscale

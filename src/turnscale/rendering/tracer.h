// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "turnscale/rendering/light.h"
#include "turnscale/rendering/mesh.h"
#include "turnscale/rendering/ray_scene.h"
#include "turnscale/rendering/scene.h"
#include "turnscale/rendering/texture.h"

namespace turnscale {

/// What a ray shows.
struct Seen {
  float brightness = 0;
  float distance = 0;  ///< metres; infinite for the sky
  /// Pixels with equal numbers show the same flat thing in the same light.
  std::uint32_t look = 0;
};

/// A scene with light and looks, ready to be seen.
struct LitScene {
  /// Draws the patterns, on so many threads.
  LitScene(Scene scene, int threads);

  Scene scene;
  std::vector<Texture> textures;                 ///< of Scene::patterns
  std::vector<std::vector<TriangleLook>> looks;  ///< of the fixed mesh, then of the movable ones
  Sky sky;

  const Mesh& mesh(int index) const { return index == 0 ? scene.fixed : scene.movable[index - 1]; }
};

/// Finds what rays show: textures in light and shadow, and what polished surfaces mirror.
class Tracer {
 public:
  /// `world_from_movable`: rotations of the movable meshes, for the direction of their surfaces.
  Tracer(const LitScene& lit, PlacedScene placed, const std::vector<Eigen::Matrix3f>& world_from_movable);

  /// At most kPacket rays, nearly parallel.
  void Trace(std::span<const Ray> rays, std::span<Seen> seen) const;

 private:
  struct Spot;

  void Trace(std::span<const Ray> rays, std::span<const float> before, bool mirrors, std::span<Seen> seen) const;
  Spot SpotAt(const Ray& ray, const Hit& hit, float before) const;
  void AddSun(std::span<Spot> spots) const;
  void AddMirrored(std::span<const Ray> rays, std::span<const Spot> spots, std::span<Seen> seen) const;

  const LitScene* lit_;
  PlacedScene placed_;
  std::vector<Eigen::Matrix3f> world_from_mesh_;
};

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include <Eigen/Core>

#include "turnscale/rendering/ray_scene.h"
#include "turnscale/rendering/scene.h"
#include "turnscale/rendering/texture.h"

namespace turnscale {

/// The light of a rectangular lamp, gathered from a few points of it: falls with the square of the distance, and with
/// the cosines at lamp and surface (Lambert).
class LampLight {
 public:
  explicit LampLight(const Lamp& lamp);

  /// Points of the lamp that stand for a quarter of it each.
  const std::array<Eigen::Vector3f, 4>& parts() const { return parts_; }

  /// Whether the lamp gives enough light to a surface there to be worth asking for shadows.
  bool Reaches(const Eigen::Vector3f& place, const Eigen::Vector3f& normal) const;

  /// What a white surface returns of the light of one part, nothing in between.
  float From(const Eigen::Vector3f& part, const Eigen::Vector3f& place, const Eigen::Vector3f& normal) const;

 private:
  std::array<Eigen::Vector3f, 4> parts_;
  Eigen::Vector3f centre_;
  float part_strength_ = 0;
};

/// An overcast sky, infinitely far away: brighter towards the horizon, with soft clouds.
class Sky {
 public:
  /// `overhead`: brightness straight up.
  explicit Sky(float overhead);

  /// Brightness in a direction (unit, world) for a pixel that covers `width` radians. Below the horizon the haze of
  /// the horizon goes on.
  float At(const Eigen::Vector3f& direction, float width) const;

 private:
  float overhead_;
  Texture clouds_;
};

/// Fills the light of every mesh of the scene that has none: ambient light, less where other things are near, and lamps
/// with soft shadows. `rays` holds the same scene. Movable meshes do not know where they will be: they get the ambient
/// light above open ground, and the mean light of the lamps. The result does not depend on the number of threads.
void BakeLight(const RayScene& rays, int threads, Scene& scene);

}  // namespace turnscale

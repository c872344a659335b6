// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include <Eigen/Core>

#include "turnscale/rendering/scene.h"

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

}  // namespace turnscale

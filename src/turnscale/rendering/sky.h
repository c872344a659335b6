// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

#include "turnscale/rendering/texture.h"

namespace turnscale {

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

}  // namespace turnscale

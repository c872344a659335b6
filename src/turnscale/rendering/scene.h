// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "turnscale/rendering/mesh.h"

namespace turnscale {

/// A pattern that repeats over surfaces. It is drawn when a renderer is made: what only asks for shapes and places need
/// not wait for it.
struct RepeatedPattern {
  std::function<cv::Mat()> draw;  ///< see Texture; called from any thread
  double size = 1;                ///< side of the square that repeats, metres
  float contrast = 1;             ///< factor on differences from its mean
};

struct Material {
  int pattern = 0;   ///< index into Scene::patterns
  float tint = 1;    ///< factor on the pattern's reflectance
  float mirror = 0;  ///< polish: reflectance seen from straight above, 0...1; grows towards grazing (Schlick 1994)
  float glow = 0;    ///< light that the surface gives by itself, in units of a white surface in full light
};

/// The sun, far away.
struct Sun {
  Eigen::Vector3f direction = {0.3F, -0.8F, 0.5F};  ///< towards it, in the world
  float strength = 1;                               ///< what a white surface facing it returns
};

/// A rectangular lamp under a ceiling, shining down.
struct Lamp {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  float length_x = 1.2F;  ///< metres
  float length_z = 0.2F;  ///< metres
  float strength = 1;     ///< what a white floor one metre below it returns
};

/// What there is to see. Everything in metres, the world's axes x right, y down, z forward.
struct Scene {
  std::vector<RepeatedPattern> patterns;
  std::vector<Material> materials;
  Mesh fixed;
  std::vector<Mesh> movable;  ///< in frames of their own; a view says where they are

  std::optional<Sun> sun;
  std::vector<Lamp> lamps;
  float sky = 0;      ///< brightness of the open sky overhead, 0 indoors; brighter towards the horizon
  float ambient = 0;  ///< light from everywhere, where nothing nearby is in the way
};

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/rendering/ray_scene.h"
#include "turnscale/rendering/scene.h"

namespace turnscale {

/// Fills the light of every mesh of the scene that has none: ambient light, less where other things are near, and lamps
/// with soft shadows. `rays` holds the same scene. Movable meshes do not know where they will be: they get the ambient
/// light above open ground, and the mean light of the lamps. The result does not depend on the number of threads.
void BakeLight(const RayScene& rays, int threads, Scene& scene);

}  // namespace turnscale

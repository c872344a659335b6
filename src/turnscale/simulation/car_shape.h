// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/base/random.h"
#include "turnscale/rendering/mesh.h"

namespace turnscale {

/// Materials of a car's parts, indices into Scene::materials.
struct CarMaterials {
  int paint = 0;
  int glass = 0;
  int rubber = 0;
  int trim = 0;
  int lights = 0;
  int plate = 0;
};

/// A car of random size and build (hatchback, saloon or van), standing at the origin: its middle on the ground, looking
/// along z.
Mesh MakeCar(const CarMaterials& materials, Random& random);

/// A walking person's size and outline, standing at the origin.
Mesh MakePerson(int clothes, int skin, Random& random);

}  // namespace turnscale

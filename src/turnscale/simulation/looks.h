// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <type_traits>
#include <vector>

#include <opencv2/core.hpp>

#include "turnscale/base/random.h"
#include "turnscale/rendering/mesh.h"
#include "turnscale/rendering/pattern.h"
#include "turnscale/rendering/scene.h"

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

/// What draws a pattern, when it is needed.
template <typename... More>
std::function<cv::Mat()> Drawing(cv::Mat (*pattern)(const PatternOptions&, More...), const PatternOptions& options,
                                 std::type_identity_t<More>... more) {
  return [=] { return pattern(options, more...); };
}

/// Puts a pattern that covers `size` x `size` metres into a scene; gives its index.
int AddPattern(std::function<cv::Mat()> draw, double size, Scene& scene);

/// Puts a material into a scene; gives its index.
int AddMaterial(const Material& material, Scene& scene);

/// What cars and people are made of.
struct TrafficLooks {
  std::vector<CarMaterials> cars;
  std::vector<int> clothes;
  int skin = 0;
};

TrafficLooks AddTrafficLooks(Random& random, Scene& scene);

/// A car of one of the looks.
Mesh MakeAnyCar(const TrafficLooks& looks, Random& random);

}  // namespace turnscale

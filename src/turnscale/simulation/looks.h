// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "turnscale/base/random.h"
#include "turnscale/rendering/scene.h"
#include "turnscale/simulation/car_shape.h"

namespace turnscale {

/// Puts a pattern that covers `size` x `size` metres into a scene; gives its index.
int AddTexture(const cv::Mat& pattern, double size, Scene& scene);

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

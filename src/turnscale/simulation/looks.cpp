// SPDX-License-Identifier: MIT
#include "turnscale/simulation/looks.h"

#include <cstdint>

#include "turnscale/rendering/pattern.h"

namespace turnscale {
namespace {

std::uint64_t Seed(Random& random) { return static_cast<std::uint64_t>(random.Uniform() * 0x1.0p53); }

}  // namespace

int AddTexture(const cv::Mat& pattern, double size, Scene& scene) {
  scene.textures.emplace_back(pattern, size);
  return static_cast<int>(scene.textures.size()) - 1;
}

int AddMaterial(const Material& material, Scene& scene) {
  scene.materials.push_back(material);
  return static_cast<int>(scene.materials.size()) - 1;
}

TrafficLooks AddTrafficLooks(Random& random, Scene& scene) {
  // Paint is nearly even; dust and reflections leave a little to hold on to.
  const int paint = AddTexture(CloudPattern({256, Seed(random), 0.5F, 0.05F}), 2.0, scene);
  const int cloth = AddTexture(CloudPattern({256, Seed(random), 0.5F, 0.12F}), 0.8, scene);
  const int plate = AddTexture(FacadePattern({256, Seed(random), 0.5F, 0.25F}, 2, 8), 0.55, scene);
  const int rubber = AddTexture(CloudPattern({256, Seed(random), 0.5F, 0.1F}), 0.5, scene);
  TrafficLooks looks;
  CarMaterials car;
  car.glass = AddMaterial({paint, 0.12F, 0.12F, 0}, scene);
  car.rubber = AddMaterial({rubber, 0.12F, 0, 0}, scene);
  car.trim = AddMaterial({rubber, 0.5F, 0, 0}, scene);
  car.lights = AddMaterial({cloth, 1.2F, 0.05F, 0}, scene);
  car.plate = AddMaterial({plate, 1.5F, 0, 0}, scene);
  for (const float tint : {0.12F, 0.25F, 0.45F, 0.7F, 1.1F, 1.5F}) {
    car.paint = AddMaterial({paint, tint, 0.05F, 0}, scene);
    looks.cars.push_back(car);
  }
  for (const float tint : {0.2F, 0.6F, 1.1F}) looks.clothes.push_back(AddMaterial({cloth, tint, 0, 0}, scene));
  looks.skin = AddMaterial({cloth, 0.9F, 0, 0}, scene);
  return looks;
}

Mesh MakeAnyCar(const TrafficLooks& looks, Random& random) {
  return MakeCar(looks.cars[random.Below(static_cast<int>(looks.cars.size()))], random);
}

}  // namespace turnscale

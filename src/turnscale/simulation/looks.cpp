// SPDX-License-Identifier: MIT
#include "turnscale/simulation/looks.h"

#include <cmath>
#include <cstdint>
#include <numbers>

#include "turnscale/rendering/pattern.h"

namespace turnscale {
namespace {

constexpr double kCarLightStep = 0.6;

RigidTransform At(double right, double up, double forward) {
  return {Eigen::Quaterniond::Identity(), {right, -up, forward}};
}

SurfaceStyle Style(int material, Random& random) {
  return {material, kCarLightStep, {random.Uniform(0, 8), random.Uniform(0, 8)}};
}

// On its side: what is upright in the prism's frame points to the right.
RigidTransform Lying(double right, double up, double forward) {
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitZ()));
  return {turned, {right, -up, forward}};
}

struct CarBuild {
  double width, length, hood, height;  // of the body below the windows
  double cabin_depth, cabin_top_depth, cabin_height, cabin_back;
};

CarBuild RandomBuild(Random& random) {
  const double width = random.Uniform(1.68, 1.86);
  switch (random.Below(3)) {
    case 0:
      return {width, random.Uniform(3.7, 4.2), 0, random.Uniform(0.62, 0.7), 2.7, 1.8, 0.58, 0.25};
    case 1:
      return {width, random.Uniform(4.4, 4.8), 0, random.Uniform(0.6, 0.66), 2.6, 1.4, 0.52, 0.15};
    default:
      return {width + 0.08, random.Uniform(4.5, 5.0), 0, random.Uniform(0.75, 0.85), 3.9, 3.2, 0.8, 0.4};
  }
}

void AddWheels(const CarMaterials& materials, const CarBuild& build, Random& random, Mesh& car) {
  constexpr double kRadius = 0.31;
  constexpr double kTread = 0.22;
  for (const double side : {-1.0, 1.0})
    for (const double end : {-0.31, 0.30}) {
      const double outer = side * (build.width / 2 + 0.01);
      const double left = side < 0 ? outer : outer - kTread;
      AddPrism(Style(materials.rubber, random), Lying(left, kRadius, end * build.length),
               {kRadius, kRadius, kTread, 16}, car);
      const double hub = side < 0 ? outer - 0.012 : outer - kTread + 0.012;
      AddPrism(Style(materials.trim, random), Lying(hub, kRadius, end * build.length), {0.19, 0.19, kTread, 10}, car);
    }
}

void AddEnds(const CarMaterials& materials, const CarBuild& build, Random& random, Mesh& car) {
  const double half = build.length / 2;
  for (const double end : {-1.0, 1.0}) {
    const double z = end * (half - 0.02);
    for (const double side : {-1.0, 1.0})
      AddBox(Style(materials.lights, random), At(side * (build.width / 2 - 0.25), 0.62, z), {{0.34, 0.16, 0.08}}, car);
    AddBox(Style(materials.plate, random), At(0, 0.42, end * (half + 0.005)), {{0.52, 0.11, 0.03}}, car);
    AddBox(Style(materials.trim, random), At(0, 0.27, end * (half - 0.03)), {{build.width - 0.1, 0.12, 0.14}}, car);
    AddBox(Style(materials.trim, random), At(0, 0.58, z), {{build.width - 0.95, 0.14, 0.07}}, car);
  }
}

std::uint64_t Seed(Random& random) { return static_cast<std::uint64_t>(random.Uniform() * 0x1.0p53); }

}  // namespace

Mesh MakeCar(const CarMaterials& materials, Random& random) {
  const CarBuild build = RandomBuild(random);
  constexpr double kClearance = 0.2;
  Mesh car;
  const double belt = kClearance + build.height;
  AddBox(Style(materials.paint, random), At(0, kClearance, 0),
         {{build.width, build.height, build.length}, build.width - 0.1, build.length - 0.18, 0}, car);
  const double middle = -build.cabin_back - (build.length - 4.2) * 0.1;
  const double top_width = build.width - 0.42;
  AddBox(Style(materials.glass, random), At(0, belt, middle),
         {{build.width - 0.12, build.cabin_height, build.cabin_depth}, top_width, build.cabin_top_depth, -0.12}, car);
  AddBox(Style(materials.paint, random), At(0, belt + build.cabin_height, middle - 0.12),
         {{top_width + 0.02, 0.05, build.cabin_top_depth + 0.02}, top_width - 0.1, build.cabin_top_depth - 0.1, 0},
         car);
  // Pillars between the windows.
  for (const double at : {-0.32, 0.02, 0.34})
    AddBox(Style(materials.paint, random), At(0, belt, middle + at * build.cabin_depth),
           {{build.width - 0.115, build.cabin_height, 0.07}, top_width + 0.005, 0.07, -at * 0.3 - 0.1}, car);
  for (const double side : {-1.0, 1.0})
    AddBox(Style(materials.trim, random),
           At(side * (build.width / 2 + 0.06), belt - 0.02, middle + 0.36 * build.cabin_depth), {{0.14, 0.13, 0.1}},
           car);
  AddWheels(materials, build, random, car);
  AddEnds(materials, build, random, car);
  return car;
}

Mesh MakePerson(int clothes, int skin, Random& random) {
  const double scale = random.Uniform(0.9, 1.08);
  Mesh person;
  for (const double side : {-0.1, 0.1})
    AddPrism(Style(clothes, random), At(side * scale, 0, side * scale), {0.09 * scale, 0.1 * scale, 0.85 * scale, 8},
             person);
  AddPrism(Style(clothes, random), At(0, 0.8 * scale, 0), {0.17 * scale, 0.23 * scale, 0.65 * scale, 10}, person);
  AddPrism(Style(skin, random), At(0, 1.47 * scale, 0), {0.1 * scale, 0.09 * scale, 0.25 * scale, 10}, person);
  return person;
}

int AddPattern(std::function<cv::Mat()> draw, double size, Scene& scene) {
  scene.patterns.push_back({std::move(draw), size});
  return static_cast<int>(scene.patterns.size()) - 1;
}

int AddMaterial(const Material& material, Scene& scene) {
  scene.materials.push_back(material);
  return static_cast<int>(scene.materials.size()) - 1;
}

TrafficLooks AddTrafficLooks(Random& random, Scene& scene) {
  // Paint is nearly even; dust and reflections leave a little to hold on to.
  const int paint = AddPattern(Drawing(CloudPattern, {256, Seed(random), 0.5F, 0.05F}, 1.0), 2.0, scene);
  const int cloth = AddPattern(Drawing(CloudPattern, {256, Seed(random), 0.5F, 0.12F}, 1.0), 0.8, scene);
  const int plate = AddPattern(Drawing(FacadePattern, {256, Seed(random), 0.5F, 0.25F}, 2, 8), 0.55, scene);
  const int rubber = AddPattern(Drawing(CloudPattern, {256, Seed(random), 0.5F, 0.1F}, 1.0), 0.5, scene);
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

// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "turnscale/rendering/pattern.h"
#include "turnscale/simulation/garage_plan.h"
#include "turnscale/simulation/looks.h"
#include "turnscale/simulation/world.h"

namespace turnscale {
namespace {

using garage::kAisle;
using garage::kBayDepth;
using garage::kBays;
using garage::kBayWidth;
using garage::kHallDepth;
using garage::kHallWidth;
using garage::kRampWidth;
using garage::kStorey;

constexpr double kCeiling = 2.7;
constexpr double kGarageLightStep = 0.5;
constexpr double kLineWidth = 0.1;
// Paint lies this much above what it is painted on.
constexpr double kCoat = 0.003;
const Eigen::Vector3d kRight(1, 0, 0);
const Eigen::Vector3d kUp(0, -1, 0);
const Eigen::Vector3d kForward(0, 0, 1);

struct GarageLooks {
  int floor, wall, ceiling, pillar, stripe, dark_band, line, pipe, lamp, sign, door;
  TrafficLooks traffic;
};

GarageLooks AddGarageLooks(Random& random, Scene& scene) {
  const auto seed = [&] { return static_cast<std::uint64_t>(random.Uniform() * 0x1.0p53); };
  const int concrete = AddPattern(Drawing(PavementPattern, {2048, seed(), 0.5F, 0.13F}), 7.3, scene);
  const int plaster = AddPattern(Drawing(PavementPattern, {1024, seed(), 0.6F, 0.1F}), 4.1, scene);
  const int boards = AddPattern(Drawing(BrickPattern, {1024, seed(), 0.55F, 0.1F}, 6), 5.7, scene);
  const int paint = AddPattern(Drawing(PavementPattern, {512, seed(), 0.6F, 0.1F}), 2.3, scene);
  const int letters = AddPattern(Drawing(FacadePattern, {512, seed(), 0.5F, 0.3F}, 3, 9), 1.6, scene);
  GarageLooks looks;
  looks.floor = AddMaterial({concrete, 0.75F, 0.04F, 0}, scene);
  looks.wall = AddMaterial({plaster, 1.1F, 0, 0}, scene);
  looks.ceiling = AddMaterial({boards, 0.9F, 0, 0}, scene);
  looks.pillar = AddMaterial({plaster, 0.95F, 0, 0}, scene);
  looks.stripe = AddMaterial({paint, 0.55F, 0, 0}, scene);
  looks.dark_band = AddMaterial({paint, 0.25F, 0, 0}, scene);
  looks.line = AddMaterial({paint, 1.5F, 0, 0}, scene);
  looks.pipe = AddMaterial({paint, 1.2F, 0.05F, 0}, scene);
  looks.lamp = AddMaterial({paint, 0.5F, 0, 2.5F}, scene);
  looks.sign = AddMaterial({letters, 1.4F, 0, 0.15F}, scene);
  looks.door = AddMaterial({paint, 0.8F, 0, 0}, scene);
  looks.traffic = AddTrafficLooks(random, scene);
  return looks;
}

RigidTransform Standing(double x, double up, double z, double heading = 0) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitY())), {x, -up, z}};
}

// Builds with one random sequence into one scene.
class GarageBuilder {
 public:
  GarageBuilder(World& world, Random& random, const GarageLooks& looks)
      : world_(world), random_(random), looks_(looks) {}

  void Hall(double x0, double up, const std::function<bool(const garage::Bay&)>& is_free) {
    FloorAndCeiling(x0, up);
    Lines(x0, up);
    Pillars(x0, up);
    Lamps(x0, up);
    Pipes(x0, up);
    ParkedCars(x0, up, is_free);
  }

  // A wall from one end to the other, seen from its right-hand side when walking from `from` to `to`.
  void Wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double up, double height) {
    const Eigen::Vector3d start(from.x(), -up, from.y());
    const Eigen::Vector3d along(to.x() - from.x(), 0, to.y() - from.y());
    AddRectangle(Style(looks_.wall), start, along, height * kUp, mesh());
    const Eigen::Vector3d off = kCoat * along.normalized().cross(kUp);
    AddRectangle(Style(looks_.stripe), start + off + 0.25 * kUp, along, 0.8 * kUp, mesh());
    const double length = along.norm();
    for (double at = random_.Uniform(3, 8); at + 2 < length; at += random_.Uniform(7, 14)) {
      const bool is_door = random_.Chance(0.4);
      const Eigen::Vector3d corner = start + at * along.normalized() + 2 * off + (is_door ? 0.0 : 1.5) * kUp;
      AddRectangle(Style(is_door ? looks_.door : looks_.sign), corner, (is_door ? 1.0 : 1.4) * along.normalized(),
                   (is_door ? 2.0 : 0.6) * kUp, mesh());
    }
  }

  void Ramp(double x0) {
    const int columns = static_cast<int>(kRampWidth / kGarageLightStep);
    const int rows = static_cast<int>(kHallDepth / kGarageLightStep);
    std::vector<std::vector<double>> up(rows + 1, std::vector<double>(columns + 1));
    const double step_x = kRampWidth / columns;
    for (int row = 0; row <= rows; ++row)
      for (int column = 0; column <= columns; ++column)
        up[row][column] = garage::RoadUp({x0 + 0.5 * kRampWidth, row * kGarageLightStep});
    AddGround(Style(looks_.floor), {x0, 0}, step_x, up, mesh());
    AddRectangle(Style(looks_.ceiling), {x0, -(kStorey + kCeiling), kHallDepth}, kRampWidth * kRight,
                 -kHallDepth * kForward, mesh());
    for (double z = 4; z < kHallDepth; z += 8) Lamp(x0 + 0.5 * kRampWidth, kStorey + kCeiling, z, 7.0F);
  }

 private:
  Mesh& mesh() { return world_.scene.fixed; }

  SurfaceStyle Style(int material) {
    return {material, kGarageLightStep, {random_.Uniform(0, 20), random_.Uniform(0, 20)}};
  }

  void FloorAndCeiling(double x0, double up) {
    AddRectangle(Style(looks_.floor), {x0, -up, 0}, kHallWidth * kRight, kHallDepth * kForward, mesh());
    AddRectangle(Style(looks_.ceiling), {x0, -(up + kCeiling), kHallDepth}, kHallWidth * kRight, -kHallDepth * kForward,
                 mesh());
  }

  void Line(double x, double up, double z, double along_x, double along_z) {
    AddRectangle(Style(looks_.line), {x, -(up + kCoat), z}, along_x * kRight, along_z * kForward, mesh());
  }

  void Lines(double x0, double up) {
    for (const double left : garage::kBayRows)
      for (int bay = 0; bay <= kBays; ++bay)
        Line(x0 + left + 0.3, up, garage::BayEdge(bay) - kLineWidth / 2, kBayDepth - 0.5, kLineWidth);
    // Arrows on the lanes.
    for (const double aisle : garage::kAisles)
      for (double z = 10; z < kHallDepth - 6; z += 12) {
        Line(x0 + aisle - 0.1, up, z, 0.2, 1.6);
        Line(x0 + aisle - 0.3, up, z + 1.6, 0.6, 0.3);
        Line(x0 + aisle - 0.15, up, z + 1.9, 0.3, 0.3);
      }
  }

  void Pillars(double x0, double up) {
    for (const double x : garage::kPillarRows)
      for (int bay = 0; bay <= kBays; bay += 3) {
        const RigidTransform foot = Standing(x0 + x, up, garage::BayEdge(bay));
        AddBox(Style(looks_.pillar), foot, {{0.5, kCeiling, 0.5}}, mesh());
        AddBox(Style(looks_.line), Standing(x0 + x, up + 0.1, garage::BayEdge(bay)), {{0.51, 0.3, 0.51}}, mesh());
        AddBox(Style(looks_.dark_band), Standing(x0 + x, up + 0.4, garage::BayEdge(bay)), {{0.51, 0.3, 0.51}}, mesh());
        AddBox(Style(looks_.sign), Standing(x0 + x, up + 1.5, garage::BayEdge(bay)), {{0.52, 0.4, 0.52}}, mesh());
        world_.floor_plan.push_back({{x0 + x - 0.25, garage::BayEdge(bay) - 0.25},
                                     {x0 + x + 0.25, garage::BayEdge(bay) - 0.25},
                                     {x0 + x + 0.25, garage::BayEdge(bay) + 0.25},
                                     {x0 + x - 0.25, garage::BayEdge(bay) + 0.25}});
      }
    for (int bay = 0; bay <= kBays; bay += 3)
      AddBox(Style(looks_.ceiling), Standing(x0 + kHallWidth / 2, up + kCeiling - 0.4, garage::BayEdge(bay)),
             {{kHallWidth, 0.4, 0.35}}, mesh());
  }

  void Lamp(double x, double up, double z, float strength) {
    AddBox(Style(looks_.lamp), Standing(x, up - 0.12, z), {{0.18, 0.06, 1.3}}, mesh());
    AddBox(Style(looks_.pipe), Standing(x, up - 0.06, z), {{0.24, 0.06, 1.4}}, mesh());
    world_.scene.lamps.push_back(
        {{static_cast<float>(x), static_cast<float>(-(up - 0.14)), static_cast<float>(z)}, 0.18F, 1.3F, strength});
  }

  void Lamps(double x0, double up) {
    for (const double aisle : garage::kAisles)
      for (double z = 3.25; z < kHallDepth; z += 6.6) Lamp(x0 + aisle - 1.2, up + kCeiling, z, 3.5F);
    for (const double row : {2.5, 16.5, 30.5})
      for (double z = 6.5; z < kHallDepth; z += 9.9) Lamp(x0 + row, up + kCeiling, z, 2.5F);
  }

  void Pipes(double x0, double up) {
    const Eigen::Quaterniond along_z(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
    for (const double x : {4.1, 12.4, 20.6, 28.9}) {
      const double radius = random_.Uniform(0.05, 0.12);
      AddPrism(Style(looks_.pipe), {along_z, {x0 + x, -(up + kCeiling - 0.55), kHallDepth}},
               {radius, radius, kHallDepth, 10}, mesh());
    }
  }

  void ParkedCars(double x0, double up, const std::function<bool(const garage::Bay&)>& is_free) {
    for (int row = 0; row < static_cast<int>(garage::kBayRows.size()); ++row)
      for (int bay = 0; bay < kBays; ++bay) {
        const bool taken = random_.Chance(0.68);
        const bool faces_right = random_.Chance(0.5);
        const double x = x0 + garage::kBayRows[row] + kBayDepth / 2 + random_.Uniform(-0.15, 0.15);
        const double z = garage::BayEdge(bay) + kBayWidth / 2 + random_.Uniform(-0.15, 0.15);
        const double heading = (faces_right ? 0.5 : -0.5) * std::numbers::pi + random_.Uniform(-0.05, 0.05);
        const Mesh car = MakeAnyCar(looks_.traffic, random_);
        if (!taken || is_free({x0, row, bay})) continue;
        AddMesh(Standing(x, up, z, heading), car, mesh());
        world_.floor_plan.push_back({{x - 2.2, z - 0.9}, {x + 2.2, z - 0.9}, {x + 2.2, z + 0.9}, {x - 2.2, z + 0.9}});
      }
  }

  World& world_;
  Random& random_;
  const GarageLooks& looks_;
};

void AddOutline(double left, double right, double near, double far, World& world) {
  world.floor_plan.push_back({{left, near}, {right, near}, {right, far}, {left, far}});
}

// People walk up and down beside the lanes, at an even pace; not where the car backs out of its space.
void AddPeople(const TrafficLooks& looks, const garage::Bay& start, Random& random, World& world) {
  for (int i = 0; i < 6; ++i) {
    const double x0 = i % 2 == 0 ? 0 : garage::kUpperX;
    const int start_lane = start.row / 2;
    const int lane = x0 == start.x0 ? 1 - start_lane : random.Below(2);
    const double x = x0 + garage::kAisles[lane] + (random.Chance(0.5) ? 2.6 : -2.6);
    const double length = random.Uniform(6, 14);
    const double z0 = random.Uniform(garage::BayEdge(0), garage::BayEdge(kBays) - length);
    const double pace = random.Uniform(0.8, 1.5);
    const double phase = random.Uniform(0, 2 * length);
    const double up = garage::RoadUp({x, z0});
    world.scene.movable.push_back(
        MakePerson(looks.clothes[random.Below(static_cast<int>(looks.clothes.size()))], looks.skin, random));
    world.world_from_movable.emplace_back([=](double time) {
      const double walked = std::fmod(phase + pace * time, 2 * length);
      const bool returns = walked > length;
      return Standing(x, up, z0 + (returns ? 2 * length - walked : walked), returns ? std::numbers::pi : 0.0);
    });
  }
}

// Cars that pull out of their spaces by half a length and back in again, slowly.
void AddManoeuvringCars(const TrafficLooks& looks, const std::vector<garage::Bay>& bays, Random& random, World& world) {
  for (const garage::Bay& bay : bays) {
    world.scene.movable.push_back(MakeAnyCar(looks, random));
    const bool faces_right = bay.row % 2 == 0;
    const double x = bay.x0 + garage::kBayRows[bay.row] + kBayDepth / 2;
    const double z = garage::BayEdge(bay.bay) + kBayWidth / 2;
    const double up = garage::RoadUp({x, z});
    const double period = random.Uniform(12, 20);
    const double heading = (faces_right ? 0.5 : -0.5) * std::numbers::pi;
    world.world_from_movable.emplace_back([=](double time) {
      const double out = 1 - std::cos(2 * std::numbers::pi * time / period);
      return Standing(x + (faces_right ? out : -out), up, z, heading);
    });
  }
}

}  // namespace

World MakeGarage(unsigned seed, double seconds) {
  Random random(seed);
  World world;
  const GarageLooks looks = AddGarageLooks(random, world.scene);
  const garage::Plan plan = garage::MakePlan(random, seconds);
  world.legs = plan.legs;
  world.road = garage::RoadUp;
  world.scene.ambient = 0.22F;

  const std::vector<garage::Bay> in_use = {{0, 1, random.Below(kBays)}, {garage::kUpperX, 2, random.Below(kBays)}};
  const auto is_free = [&](const garage::Bay& bay) {
    // Room to back out and turn.
    const bool beside_start =
        bay.x0 == plan.start.x0 && bay.row == plan.start.row && std::abs(bay.bay - plan.start.bay) <= 2;
    return beside_start || std::ranges::find(in_use, bay) != in_use.end();
  };
  GarageBuilder builder(world, random, looks);
  builder.Hall(0, 0, is_free);
  builder.Hall(garage::kUpperX, kStorey, is_free);
  builder.Ramp(kHallWidth);

  const double far = kHallDepth;
  const double right = garage::kUpperX + kHallWidth;
  const double high = kStorey + kCeiling;
  // Lower hall, its eastern wall open to the foot of the ramp.
  builder.Wall({0, 0}, {0, far}, 0, kCeiling);
  builder.Wall({0, far}, {kHallWidth, far}, 0, kCeiling);
  builder.Wall({kHallWidth, far}, {kHallWidth, kAisle}, 0, kCeiling);
  builder.Wall({garage::kUpperX, 0}, {0, 0}, 0, kCeiling);
  // The ramp's shaft, its walls a little inside the halls'.
  constexpr double kJoint = 0.02;
  const double west = kHallWidth + kJoint;
  const double east = garage::kUpperX - kJoint;
  builder.Wall({west, kAisle}, {west, far}, 0, high);
  builder.Wall({west, 0}, {west, kAisle}, kCeiling, high - kCeiling);
  builder.Wall({east, far - kAisle}, {east, 0}, 0, high);
  builder.Wall({east, 0}, {west, 0}, kCeiling, high - kCeiling);
  // Upper hall, its western wall open to the head of the ramp.
  builder.Wall({garage::kUpperX, 0}, {garage::kUpperX, far - kAisle}, kStorey, kCeiling);
  builder.Wall({kHallWidth, far}, {right, far}, kStorey, kCeiling);
  builder.Wall({right, far}, {right, 0}, kStorey, kCeiling);
  builder.Wall({right, 0}, {garage::kUpperX, 0}, kStorey, kCeiling);

  AddOutline(0, kHallWidth, 0, far, world);
  AddOutline(kHallWidth, garage::kUpperX, 0, far, world);
  AddOutline(garage::kUpperX, right, 0, far, world);
  AddPeople(looks.traffic, plan.start, random, world);
  AddManoeuvringCars(looks.traffic, in_use, random, world);
  return world;
}

}  // namespace turnscale

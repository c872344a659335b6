// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "turnscale/rendering/pattern.h"
#include "turnscale/simulation/looks.h"
#include "turnscale/simulation/street_plan.h"
#include "turnscale/simulation/world.h"

namespace turnscale {
namespace {

using street::kPavementWidth;
using street::kRoadHalfWidth;

constexpr double kKerb = 0.13;
constexpr double kCrown = 0.022;  // fall of the road per metre from its middle
constexpr double kStreetLightStep = 1.5;
constexpr double kMargin = 60;
constexpr double kHouseStorey = 2.9;
// Of the middle of a parked car from the way that is driven.
constexpr double kParkedRight = 3.1;
constexpr double kParkedLeft = -5.9;
constexpr double kOncoming = -3.1;

struct StreetLooks {
  int asphalt, slabs, grass, line, bark, hedge, post, sign, tree_line;
  std::vector<int> facades, roofs, crowns;
  TrafficLooks traffic;
};

StreetLooks AddStreetLooks(Random& random, Scene& scene) {
  const auto seed = [&] { return static_cast<std::uint64_t>(random.Uniform() * 0x1.0p53); };
  StreetLooks looks;
  looks.asphalt =
      AddMaterial({AddPattern(Drawing(PavementPattern, {2048, seed(), 0.35F, 0.08F}), 9.1, scene), 1, 0, 0}, scene);
  looks.slabs =
      AddMaterial({AddPattern(Drawing(BrickPattern, {1024, seed(), 0.5F, 0.1F}, 8), 3.7, scene), 1, 0, 0}, scene);
  const int leaves = AddPattern(Drawing(FoliagePattern, {1024, seed(), 0.3F, 0.14F}), 3.1, scene);
  const int lawn = AddPattern(Drawing(FoliagePattern, {1024, seed(), 0.32F, 0.1F}), 4.7, scene);
  const int bark = AddPattern(Drawing(CloudPattern, {512, seed(), 0.3F, 0.12F}, 1.0), 1.3, scene);
  const int paint = AddPattern(Drawing(PavementPattern, {512, seed(), 0.7F, 0.1F}), 2.3, scene);
  const int tiles = AddPattern(Drawing(BrickPattern, {1024, seed(), 0.35F, 0.1F}, 24), 6.3, scene);
  looks.grass = AddMaterial({lawn, 1, 0, 0}, scene);
  looks.line = AddMaterial({paint, 1.1F, 0, 0}, scene);
  looks.bark = AddMaterial({bark, 0.8F, 0, 0}, scene);
  looks.hedge = AddMaterial({leaves, 0.9F, 0, 0}, scene);
  looks.post = AddMaterial({bark, 1.3F, 0, 0}, scene);
  looks.sign =
      AddMaterial({AddPattern(Drawing(FacadePattern, {256, seed(), 0.5F, 0.3F}, 2, 3), 0.6, scene), 1.5F, 0, 0}, scene);
  looks.tree_line =
      AddMaterial({AddPattern(Drawing(FoliagePattern, {1024, seed(), 0.35F, 0.12F}), 14, scene), 0.8F, 0, 0}, scene);
  for (int i = 0; i < 5; ++i) {
    const int facade = AddPattern(Drawing(FacadePattern, {1024, seed(), 0.55F, 0.14F}, 3, 4), 3 * kHouseStorey, scene);
    looks.facades.push_back(AddMaterial({facade, static_cast<float>(random.Uniform(0.75, 1.3)), 0, 0}, scene));
  }
  for (const float tint : {0.8F, 1.1F, 1.5F}) {
    looks.roofs.push_back(AddMaterial({tiles, tint, 0, 0}, scene));
    looks.crowns.push_back(AddMaterial({leaves, tint, 0, 0}, scene));
  }
  looks.traffic = AddTrafficLooks(random, scene);
  return looks;
}

double Heading(const Eigen::Vector2d& along) { return std::atan2(along.x(), along.y()); }

// Builds with one random sequence along one plan.
class StreetBuilder {
 public:
  StreetBuilder(const street::Plan& plan, Random& random, World& world)
      : plan_(plan),
        random_(random),
        world_(world),
        looks_(AddStreetLooks(random, world.scene)),
        map_(std::make_shared<RoadMap>(plan.roads, plan.driven, kMargin)) {
    world.road = [map = map_](const Eigen::Vector2d& place) { return RoadUp(*map, place); };
  }

  void Build() {
    Ground();
    Markings();
    Houses();
    ParkedCars();
    Greenery();
    Furniture();
    Traffic();
    Walkers();
    Horizon();
  }

 private:
  static double RoadUp(const RoadMap& map, const Eigen::Vector2d& place) {
    return map.Up(place) - kCrown * std::min(map.ToRoad(place), kRoadHalfWidth);
  }

  static double GroundUp(const RoadMap& map, const Eigen::Vector2d& place) {
    const double kerb = kKerb + kCrown * kRoadHalfWidth;
    const double beyond = std::clamp((map.ToRoad(place) - kRoadHalfWidth) / 0.3, 0.0, 1.0);
    return RoadUp(map, place) + beyond * kerb;
  }

  double GroundUp(const Eigen::Vector2d& place) const { return GroundUp(*map_, place); }

  Mesh& mesh() { return world_.scene.fixed; }

  SurfaceStyle Style(int material, double light_step = kStreetLightStep) {
    return {material, light_step, {random_.Uniform(0, 20), random_.Uniform(0, 20)}};
  }

  int Any(const std::vector<int>& materials) { return materials[random_.Below(static_cast<int>(materials.size()))]; }

  RigidTransform Standing(const Eigen::Vector2d& place, double heading, double sunk = 0) const {
    return {Eigen::Quaterniond(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitY())),
            {place.x(), sunk - GroundUp(place), place.y()}};
  }

  void Outline(const Eigen::Vector2d& middle, const Eigen::Vector2d& along, double length, double width) {
    const Eigen::Vector2d ahead = 0.5 * length * along;
    const Eigen::Vector2d right = 0.5 * width * Eigen::Vector2d(along.y(), -along.x());
    world_.floor_plan.push_back(
        {middle - ahead - right, middle - ahead + right, middle + ahead + right, middle + ahead - right});
  }

  // Three materials, each on a grid of its own that leaves the others' cells open. Where two overlap, the inner one
  // lies on top.
  void Ground() {
    constexpr double kFine = 0.5;
    constexpr double kCoarse = 2;
    constexpr double kBelow = 0.15;
    constexpr double kKerbEdge = kRoadHalfWidth;
    constexpr double kLawnEdge = kRoadHalfWidth + kPavementWidth;
    Surface(looks_.asphalt, kFine, 0, kKerbEdge + kFine,
            [&](const Eigen::Vector2d& place, double) { return RoadUp(*map_, place); });
    Surface(looks_.slabs, kFine, kKerbEdge - kFine, kLawnEdge, [&](const Eigen::Vector2d& place, double to_road) {
      return to_road < kKerbEdge ? RoadUp(*map_, place) - kBelow : GroundUp(place);
    });
    Surface(looks_.grass, kCoarse, kLawnEdge - 2 * kCoarse, RoadMap::kFar + 1,
            [&](const Eigen::Vector2d& place, double to_road) {
              return GroundUp(place) - (to_road < kLawnEdge ? 2 * kBelow : 0.02);
            });
  }

  template <typename Height>
  void Surface(int material, double step, double from, double to, const Height& height) {
    const Eigen::Vector2d size = map_->high() - map_->low();
    const int columns = static_cast<int>(size.x() / step);
    const int rows = static_cast<int>(size.y() / step);
    std::vector<std::vector<double>> up(rows + 1, std::vector<double>(columns + 1));
    for (int row = 0; row <= rows; ++row)
      for (int column = 0; column <= columns; ++column) {
        const Eigen::Vector2d place = map_->low() + step * Eigen::Vector2d(column, row);
        const double to_road = map_->ToRoad(place);
        const bool open = to_road < from || to_road > to;
        up[row][column] = open ? std::numeric_limits<double>::quiet_NaN() : height(place, to_road);
      }
    AddGround(Style(material), map_->low(), step, up, mesh());
  }

  void Markings() {
    for (const std::vector<RoadPoint>& road : plan_.roads)
      for (int i = 2; i + 4 < static_cast<int>(road.size()); i += 7) {
        const Eigen::Vector2d along = street::Along(road, i);
        const auto on_road = [&](const Eigen::Vector2d& place) {
          return Eigen::Vector3d(place.x(), -(RoadUp(*map_, place) + 0.012), place.y());
        };
        const Eigen::Vector3d start = on_road(road[i].place);
        const Eigen::Vector3d end = on_road(road[i].place + 3 * along);
        const Eigen::Vector3d right(along.y(), 0, -along.x());
        AddRectangle(Style(looks_.line), start - 0.07 * right, 0.14 * right, end - start, mesh());
      }
  }

  // Whether an oblong fits: nothing of it nearer to a road than `clear`, and nothing built there yet.
  bool Fits(const Eigen::Vector2d& middle, const Eigen::Vector2d& along, double length, double width,
            double clear) const {
    const Eigen::Vector2d right(along.y(), -along.x());
    for (double a = -0.5; a <= 0.5; a += 0.25)
      for (double r = -0.5; r <= 0.5; r += 0.25)
        if (map_->ToRoad(middle + a * length * along + r * width * right) < clear) return false;
    return std::ranges::none_of(built_, [&](const std::pair<Eigen::Vector2d, double>& other) {
      return (other.first - middle).norm() < other.second + 0.5 * std::max(length, width);
    });
  }

  void House(const Eigen::Vector2d& middle, const Eigen::Vector2d& along, double length, double depth) {
    const int storeys = 1 + random_.Below(3);
    const double height = storeys * kHouseStorey + 0.4;
    const RigidTransform foot = Standing(middle, Heading(along), 0.4);
    const SurfaceStyle wall = Style(Any(looks_.facades));
    AddBox(wall, foot, {{depth, height + 0.4, length}}, mesh());
    RigidTransform eaves = foot;
    eaves.translation.y() -= height + 0.4;
    const SurfaceStyle roof = Style(Any(looks_.roofs));
    AddBox(roof, eaves, {{depth + 0.6, random_.Uniform(1.5, 3.5), length + 0.6}, 0.4, std::max(0.5, length - depth), 0},
           mesh());
    RigidTransform chimney = eaves;
    chimney.translation += chimney.rotation * Eigen::Vector3d(0.2 * depth, 0, 0.25 * length);
    AddBox(wall, chimney, {{0.6, 3.2, 0.6}}, mesh());
    Outline(middle, along, length, depth);
    built_.emplace_back(middle, 0.5 * std::min(length, depth) + 1);
  }

  void Houses() {
    for (const std::vector<RoadPoint>& road : plan_.roads)
      for (const double side : {1.0, -1.0})
        for (int i = 3 + random_.Below(6); i < static_cast<int>(road.size()); i += 9 + random_.Below(9)) {
          const Eigen::Vector2d along = street::Along(road, i);
          const double length = random_.Uniform(8, 15);
          const double depth = random_.Uniform(7, 10);
          const double garden = random_.Chance(0.4) ? 0.3 : random_.Uniform(1, 6);
          const double setback = kRoadHalfWidth + kPavementWidth + garden;
          const Eigen::Vector2d right(along.y(), -along.x());
          const Eigen::Vector2d middle = road[i].place + side * (setback + depth / 2) * right;
          if (Fits(middle, along, length, depth, setback - 0.4)) House(middle, along, length, depth);
        }
  }

  void ParkedCars() {
    const std::vector<RoadPoint>& way = plan_.driven;
    for (const double beside : {kParkedRight, kParkedLeft}) {
      const std::vector<RoadPoint> row = street::Beside(way, beside);
      for (int i = 8 + random_.Below(8); i + 6 < static_cast<int>(row.size());
           i += 6 + random_.Below(random_.Chance(0.3) ? 30 : 4)) {
        const Eigen::Vector2d along = street::Along(row, i);
        // Not in a bend, not on any part of the way, not in the oncoming lane of another street.
        const bool straight = along.dot(street::Along(way, std::max(0, i - 8))) > 0.995 &&
                              along.dot(street::Along(way, std::min(i + 8, static_cast<int>(way.size()) - 1))) > 0.995;
        const double to_road = map_->ToRoad(row[i].place);
        const Mesh car = MakeAnyCar(looks_.traffic, random_);
        if (!straight || map_->ToDriven(row[i].place) < 2.9 || to_road < kRoadHalfWidth - 1.3) continue;
        AddMesh(Standing(row[i].place, Heading(along) + (beside < 0 ? std::numbers::pi : 0)), car, mesh());
      }
    }
  }

  void Tree(const Eigen::Vector2d& place) {
    const double height = random_.Uniform(2, 3.5);
    const double crown = random_.Uniform(1.2, 2.6);
    const double trunk = random_.Uniform(0.1, 0.25);
    const RigidTransform foot = Standing(place, random_.Uniform(0, 3), 0.1);
    AddPrism(Style(looks_.bark), foot, {trunk, 0.8 * trunk, height + 1, 8}, mesh());
    const SurfaceStyle leaves = Style(Any(looks_.crowns));
    for (int i = 0; i < 5; ++i) {
      const double ahead = random_.Uniform(-0.5, 0.5) * crown;
      const double up = height + random_.Uniform(-0.3, 0.9) * crown;
      const Eigen::Vector3d off(random_.Uniform(-0.5, 0.5) * crown, -up, ahead);
      const RigidTransform at = {foot.rotation, foot.translation + off};
      const double radius = random_.Uniform(0.5, 0.8) * crown;
      AddPrism(leaves, at, {0.5 * radius, radius, 0.5 * radius, 7}, mesh());
      AddPrism(leaves, {at.rotation, at.translation - Eigen::Vector3d(0, 0.5 * radius, 0)},
               {radius, 0.3 * radius, 0.8 * radius, 7}, mesh());
    }
    built_.emplace_back(place, 0.5);
  }

  void Greenery() {
    for (const std::vector<RoadPoint>& road : plan_.roads)
      for (const double side : {1.0, -1.0})
        for (int i = 2; i < static_cast<int>(road.size()); i += 4 + random_.Below(7)) {
          const Eigen::Vector2d along = street::Along(road, i);
          const Eigen::Vector2d right(along.y(), -along.x());
          const bool hedge = random_.Chance(0.35);
          const double off = kRoadHalfWidth + kPavementWidth + (hedge ? 0.6 : random_.Uniform(0.8, 9));
          const Eigen::Vector2d place = road[i].place + side * off * right;
          if (hedge && Fits(place, along, 3.6, 0.7, kRoadHalfWidth + kPavementWidth)) {
            const double height = random_.Uniform(0.8, 1.8);
            AddBox(Style(looks_.hedge), Standing(place, Heading(along), 0.1), {{0.7, height, 3.6}}, mesh());
          }
          if (!hedge && Fits(place, along, 1, 1, kRoadHalfWidth + kPavementWidth)) Tree(place);
        }
  }

  void Furniture() {
    for (const std::vector<RoadPoint>& road : plan_.roads)
      for (int i = 10; i < static_cast<int>(road.size()); i += 22 + random_.Below(8)) {
        const Eigen::Vector2d along = street::Along(road, i);
        const double side = random_.Chance(0.5) ? 1 : -1;
        const Eigen::Vector2d place =
            road[i].place + side * (kRoadHalfWidth + 0.5) * Eigen::Vector2d(along.y(), -along.x());
        const bool lamp = random_.Chance(0.6);
        if (map_->ToRoad(place) < kRoadHalfWidth + 0.3) continue;
        const RigidTransform foot = Standing(place, Heading(along));
        const double height = lamp ? 5.5 : 2.4;
        AddPrism(Style(looks_.post), foot, {0.06, 0.04, height, 8}, mesh());
        RigidTransform top = foot;
        top.translation.y() -= height - (lamp ? 0.1 : 0.6);
        if (lamp) top.translation -= side * 0.5 * (top.rotation * Eigen::Vector3d::UnitX());
        AddBox(Style(looks_.sign), top, lamp ? Box{{1.2, 0.12, 0.3}} : Box{{0.6, 0.6, 0.04}}, mesh());
      }
  }

  // Oncoming cars, each at its own speed along the whole way.
  void Traffic() {
    const auto lane = std::make_shared<const std::vector<RoadPoint>>(street::Beside(plan_.driven, kOncoming));
    const int last = static_cast<int>(lane->size()) - 1;
    const int cars = std::max(3, last / 150);
    for (int i = 0; i < cars; ++i) {
      world_.scene.movable.push_back(MakeAnyCar(looks_.traffic, random_));
      const double speed = random_.Uniform(6, 9);
      const double start = last * (0.15 + 1.6 * (i + random_.Uniform()) / cars);
      world_.world_from_movable.emplace_back([lane, last, speed, start, map = map_](double time) {
        const double at = start - speed * time;
        const double on = std::clamp(at, 0.0, last - 1e-6);
        const int point = static_cast<int>(on);
        const Eigen::Vector2d back = -street::Along(*lane, point);
        const Eigen::Vector2d place =
            (*lane)[point].place + (on - point) * ((*lane)[point + 1].place - (*lane)[point].place);
        // Before it comes and after it is gone it is out of sight, below the ground.
        const double hidden = at != on ? 30 : 0;
        return RigidTransform{Eigen::Quaterniond(Eigen::AngleAxisd(Heading(back), Eigen::Vector3d::UnitY())),
                              {place.x(), hidden - RoadUp(*map, place), place.y()}};
      });
    }
  }

  // People who walk up and down the pavement, where it is long enough.
  void Walkers() {
    constexpr double kReach = 12;
    for (int i = 30; i + 40 < static_cast<int>(plan_.driven.size()); i += 30 + random_.Below(30)) {
      const Eigen::Vector2d along = street::Along(plan_.driven, i);
      const Eigen::Vector2d right(along.y(), -along.x());
      const bool on_right = random_.Chance(0.5);
      const double beside = -street::kMiddle + (on_right ? 1 : -1) * (kRoadHalfWidth + 1.2);
      const Eigen::Vector2d place = plan_.driven[i].place + beside * right;
      const double pace = random_.Uniform(0.9, 1.6);
      const double phase = random_.Uniform(0, 2 * std::numbers::pi);
      bool off_the_road = true;
      for (double at = -kReach; at <= kReach; at += 1)
        off_the_road = off_the_road && map_->ToRoad(place + at * along) > kRoadHalfWidth + 0.4;
      if (!off_the_road) continue;
      world_.scene.movable.push_back(MakePerson(Any(looks_.traffic.clothes), looks_.traffic.skin, random_));
      world_.world_from_movable.emplace_back([=, map = map_](double time) {
        // Slower where the walker turns round.
        const double angle = pace / kReach * time + phase;
        const Eigen::Vector2d now = place + kReach * std::sin(angle) * along;
        const double heading = Heading(std::cos(angle) >= 0 ? along : Eigen::Vector2d(-along));
        return RigidTransform{Eigen::Quaterniond(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitY())),
                              {now.x(), -GroundUp(*map, now), now.y()}};
      });
    }
  }

  // Woods around everything.
  void Horizon() {
    const Eigen::Vector2d low = map_->low();
    const Eigen::Vector2d high = map_->high();
    const std::vector<Eigen::Vector2d> corners = {low, {low.x(), high.y()}, high, {high.x(), low.y()}, low};
    for (int i = 0; i < 4; ++i) {
      const Eigen::Vector2d along = corners[i + 1] - corners[i];
      const double base = std::min(GroundUp(corners[i]), GroundUp(corners[i + 1])) - 8;
      AddRectangle(Style(looks_.tree_line, 20), {corners[i].x(), -base, corners[i].y()}, {along.x(), 0, along.y()},
                   {0, -20, 0}, mesh());
    }
  }

  const street::Plan& plan_;
  Random& random_;
  World& world_;
  StreetLooks looks_;
  std::shared_ptr<const RoadMap> map_;
  std::vector<std::pair<Eigen::Vector2d, double>> built_;  // middles and radii
};

World Make(const street::Plan& plan, Random& random) {
  World world;
  world.legs = plan.legs;
  StreetBuilder(plan, random, world).Build();
  const double azimuth = random.Uniform(0, 2 * std::numbers::pi);
  const double height = random.Uniform(0.5, 0.9);
  world.scene.sun = Sun{Eigen::Vector3f(static_cast<float>(std::sin(azimuth)), static_cast<float>(-height),
                                        static_cast<float>(std::cos(azimuth)))
                            .normalized(),
                        0.9F};
  world.scene.sky = 0.9F;
  world.scene.ambient = 0.45F;
  return world;
}

}  // namespace

World MakeStreet(unsigned seed, double seconds) {
  Random random(seed);
  return Make(street::MakePlan(random, seconds), random);
}

World MakeStreetAlong(unsigned seed, const std::vector<Eigen::Vector3d>& path, const std::vector<double>& speeds) {
  Random random(seed);
  return Make(street::PlanAlong(path, speeds), random);
}

}  // namespace turnscale

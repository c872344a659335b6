// SPDX-License-Identifier: MIT
#include "turnscale/rendering/light.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/base/parallel.h"
#include "turnscale/base/random.h"
#include "turnscale/rendering/mesh.h"
#include "turnscale/rendering/pattern.h"

namespace turnscale {
namespace {

// Lamps farther away give nothing, metres.
constexpr float kReach = 15;
// What is less than this is left out.
constexpr float kLeastLight = 0.001F;

// The clouds are a plane one unit above the eye, and their pattern repeats after so many units.
constexpr double kCloudSize = 6;

cv::Mat Clouds() {
  PatternOptions options;
  options.side = 512;
  options.seed = 77;
  options.mean = 1;
  options.contrast = 0.12F;
  return CloudPattern(options, 1.4);
}

constexpr int kAmbientRays = 48;
// Indoors a thing this far away takes no ambient light any more, metres: everything is lit, and shines back.
constexpr float kOpenDistance = 4;
// How much of the ambient light comes from what is in the way.
constexpr float kBounce = 0.3F;
// Where light is gathered: above the surface, and away from the edge that it may share with a wall, metres.
constexpr float kGatheringLift = 0.01F;
constexpr float kInwards = 0.03F;
constexpr int kVerticesAtATime = 64;

struct Point {
  Eigen::Vector3f place;
  Eigen::Vector3f normal;
};

// Where the light of each vertex is gathered.
std::vector<Point> GatheringPoints(const Mesh& mesh) {
  std::vector<Point> points(mesh.vertices.size(), {Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()});
  std::vector<float> uses(mesh.vertices.size(), 0);
  for (const Triangle& triangle : mesh.triangles) {
    const auto [a, b, c] = triangle.vertices;
    const Eigen::Vector3f middle = (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3;
    for (const int vertex : triangle.vertices) {
      points[vertex].place += middle;
      points[vertex].normal += NormalOf(mesh, triangle);
      uses[vertex] += 1;
    }
  }
  for (size_t i = 0; i < points.size(); ++i) {
    // A vertex without a surface has no side of its own.
    if (points[i].normal.norm() == 0) points[i].normal = -Eigen::Vector3f::UnitY();
    points[i].normal.normalize();
    if (uses[i] == 0) continue;
    const Eigen::Vector3f inwards = points[i].place / uses[i] - mesh.vertices[i];
    points[i].place = mesh.vertices[i] + kGatheringLift * points[i].normal +
                      inwards * std::min(0.5F, kInwards / std::max(inwards.norm(), 1e-6F));
  }
  return points;
}

// Directions over the hemisphere around a normal, more of them where they count more (Lambert), evenly spread by a
// rank-1 lattice and turned by a number of the place.
std::array<Eigen::Vector3f, kAmbientRays> Hemisphere(const Eigen::Vector3f& normal, std::uint64_t place) {
  const Eigen::Vector3f u = normal.unitOrthogonal();
  const Eigen::Vector3f v = normal.cross(u);
  const float turn = HashUniform(place, 1);
  std::array<Eigen::Vector3f, kAmbientRays> directions;
  for (int i = 0; i < kAmbientRays; ++i) {
    const float square = (static_cast<float>(i) + 0.5F) / kAmbientRays;
    const float angle =
        2 * std::numbers::pi_v<float> * (turn + static_cast<float>(i) * (std::numbers::phi_v<float> - 1));
    const float across = std::sqrt(square);
    directions[i] = across * std::cos(angle) * u + across * std::sin(angle) * v + std::sqrt(1 - square) * normal;
  }
  return directions;
}

// How light comes to the points of a mesh.
struct Surroundings {
  PlacedScene placed;
  const Scene& scene;
  const Mesh& mesh;   // what `placed` shows
  bool above_ground;  // the ground below is open, and not part of the mesh
};

struct Ambient {
  float light = 0;
  bool buried = false;  // inside of something
};

Ambient AmbientLight(const Surroundings& around, const Point& point, std::uint64_t place) {
  const std::array<Eigen::Vector3f, kAmbientRays> directions = Hemisphere(point.normal, place);
  const bool indoors = around.scene.sky <= 0;
  float open = 0;
  int backs = 0;
  for (int first = 0; first < kAmbientRays; first += kPacket) {
    std::array<Ray, kPacket> rays;
    std::array<Hit, kPacket> hits;
    for (int i = 0; i < kPacket; ++i) {
      rays[i].origin = point.place;
      rays[i].direction = directions[first + i];
      if (indoors) rays[i].end = kOpenDistance;
    }
    around.placed.Intersect(rays, false, hits);
    for (int i = 0; i < kPacket; ++i) {
      const bool ground = around.above_ground && rays[i].direction.y() > 0;
      if (hits[i].mesh < 0) {
        open += ground ? kBounce : 1.0F;
        continue;
      }
      const Triangle& triangle = around.mesh.triangles[hits[i].triangle];
      if (NormalOf(around.mesh, triangle).dot(rays[i].direction) > 0) ++backs;
      const float near = indoors ? hits[i].distance / kOpenDistance : 0.0F;
      open += near + kBounce * (1 - near);
    }
  }
  return {around.scene.ambient * open / kAmbientRays, 2 * backs > kAmbientRays};
}

float LampsLight(const Surroundings& around, const std::vector<LampLight>& lamps, const Point& point) {
  float sum = 0;
  std::array<Ray, kPacket> rays;
  std::array<float, kPacket> light;
  std::array<bool, kPacket> blocked;
  size_t count = 0;
  const auto cast = [&] {
    around.placed.FindBlocked({rays.data(), count}, false, {blocked.data(), count});
    for (size_t i = 0; i < count; ++i) sum += blocked[i] ? 0 : light[i];
    count = 0;
  };
  for (const LampLight& lamp : lamps) {
    if (!lamp.Reaches(point.place, point.normal)) continue;
    for (const Eigen::Vector3f& part : lamp.parts()) {
      light[count] = lamp.From(part, point.place, point.normal);
      if (light[count] <= 0) continue;
      const Eigen::Vector3f towards = part - point.place;
      const float distance = towards.norm();
      rays[count].origin = point.place;
      rays[count].direction = towards / distance;
      // The lamp's own housing is not in the way.
      rays[count].end = distance - 0.1F;
      if (++count == kPacket) cast();
    }
  }
  cast();
  return sum;
}

// Vertices inside of other things are dark; what they share triangles with outside should not be.
void BrightenBuried(const std::vector<char>& buried, Mesh& mesh) {
  std::vector<float> sum(mesh.vertices.size(), 0);
  std::vector<float> count(mesh.vertices.size(), 0);
  for (const Triangle& triangle : mesh.triangles) {
    for (const int to : triangle.vertices) {
      for (const int from : triangle.vertices) {
        if (buried[from] != 0) continue;
        sum[to] += mesh.light[from];
        count[to] += 1;
      }
    }
  }
  for (size_t i = 0; i < buried.size(); ++i)
    if (buried[i] != 0 && count[i] > 0) mesh.light[i] = sum[i] / count[i];
}

void BakeFixed(const RayScene& rays, int threads, Scene& scene) {
  const std::vector<Point> points = GatheringPoints(scene.fixed);
  const std::vector<LampLight> lamps(scene.lamps.begin(), scene.lamps.end());
  const Surroundings around = {rays.Alone(0), scene, scene.fixed, false};
  std::vector<float> light(points.size(), 0);
  std::vector<char> buried(points.size(), 0);
  const int blocks = (static_cast<int>(points.size()) + kVerticesAtATime - 1) / kVerticesAtATime;
  ForEachIndex(blocks, threads, [&](int block) {
    const size_t first = static_cast<size_t>(block) * kVerticesAtATime;
    for (size_t i = first; i < std::min(points.size(), first + kVerticesAtATime); ++i) {
      const Ambient ambient = AmbientLight(around, points[i], i);
      buried[i] = ambient.buried ? 1 : 0;
      light[i] = ambient.light + LampsLight(around, lamps, points[i]);
    }
  });
  scene.fixed.light = std::move(light);
  BrightenBuried(buried, scene.fixed);
}

// What the lamps give to the floors, on average.
float MeanLampLight(const Scene& scene) {
  if (scene.lamps.empty()) return 0;
  const std::vector<Point> points = GatheringPoints(scene.fixed);
  float sum = 0;
  float count = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (points[i].normal.y() > -0.9F) continue;
    sum += std::max(0.0F, scene.fixed.light[i] - scene.ambient);
    count += 1;
  }
  return count > 0 ? sum / count : 0;
}

void BakeMovable(const RayScene& rays, int index, float lamp_light, Scene& scene) {
  Mesh& mesh = scene.movable[index];
  const Surroundings around = {rays.Alone(index + 1), scene, mesh, true};
  const std::vector<Point> points = GatheringPoints(mesh);
  std::vector<float> light(points.size(), 0);
  for (size_t i = 0; i < points.size(); ++i) {
    const float facing_up = 0.5F * (1 - points[i].normal.y());
    light[i] = AmbientLight(around, points[i], i).light + lamp_light * facing_up;
  }
  mesh.light = std::move(light);
}

}  // namespace

LampLight::LampLight(const Lamp& lamp) : centre_(lamp.position), part_strength_(1) {
  // A long lamp is cut across, any other into quarters.
  const bool along_x = lamp.length_x > 2 * lamp.length_z;
  const bool along_z = lamp.length_z > 2 * lamp.length_x;
  for (int i = 0; i < 4; ++i) {
    const float along = 0.25F * (static_cast<float>(i) - 1.5F);
    const float x = along_x ? along : along_z ? 0.0F : (i % 2 == 0 ? -0.25F : 0.25F);
    const float z = along_z ? along : along_x ? 0.0F : (i / 2 == 0 ? -0.25F : 0.25F);
    parts_[i] = lamp.position + Eigen::Vector3f(x * lamp.length_x, 0, z * lamp.length_z);
  }
  const Eigen::Vector3f below = lamp.position + Eigen::Vector3f(0, 1, 0);
  float sum = 0;
  for (const Eigen::Vector3f& part : parts_) sum += From(part, below, Eigen::Vector3f(0, -1, 0));
  part_strength_ = lamp.strength / sum;
}

bool LampLight::Reaches(const Eigen::Vector3f& place, const Eigen::Vector3f& normal) const {
  float sum = 0;
  for (const Eigen::Vector3f& part : parts_) sum += From(part, place, normal);
  return sum > kLeastLight;
}

float LampLight::From(const Eigen::Vector3f& part, const Eigen::Vector3f& place, const Eigen::Vector3f& normal) const {
  const Eigen::Vector3f towards = part - place;
  const float square = towards.squaredNorm();
  // Down is +y, and so is the lamp's side that shines.
  const float cosines = -towards.y() * normal.dot(towards);
  if (towards.y() >= 0 || cosines <= 0 || square >= kReach * kReach) return 0;
  // Fades out towards the reach instead of ending there.
  const float fade = 1 - square / (kReach * kReach);
  return part_strength_ * fade * fade * cosines / std::max(square * square, 1e-4F);
}

Sky::Sky(float overhead)
    : overhead_(overhead), clouds_(overhead > 0 ? Clouds() : cv::Mat(1, 1, CV_32F, 1.0F), kCloudSize) {}

float Sky::At(const Eigen::Vector3f& direction, float width) const {
  if (overhead_ <= 0) return 0;
  const float up = std::max(0.0F, -direction.y());
  const float low = 1 - up;
  const float brightness = overhead_ * (1 + 0.6F * low * low * low);
  // The plane is bent down at the horizon, where clouds would otherwise become infinitely thin.
  const float height = up + 0.15F;
  const Eigen::Vector2f at(direction.x() / height, direction.z() / height);
  const float minor = 0.5F * width / height;
  const Eigen::Vector2f major = at.normalized() * (minor / height);
  const float haze = std::min(1.0F, up / 0.3F);
  return brightness * (1 + haze * (clouds_.Sample(at, major, minor) - 1));
}

void BakeLight(const RayScene& rays, int threads, Scene& scene) {
  if (scene.fixed.light.empty()) BakeFixed(rays, threads, scene);
  const float lamp_light = MeanLampLight(scene);
  for (size_t i = 0; i < scene.movable.size(); ++i)
    if (scene.movable[i].light.empty()) BakeMovable(rays, static_cast<int>(i), lamp_light, scene);
}

}  // namespace turnscale

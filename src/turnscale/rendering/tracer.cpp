// SPDX-License-Identifier: MIT
#include "turnscale/rendering/tracer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "turnscale/base/parallel.h"
#include "turnscale/base/random.h"

namespace turnscale {
namespace {

// Rays that leave a surface start so far from it, metres: the surface does not shade itself.
constexpr float kLift = 1e-3F;
// Mirror images weaker than this are left out.
constexpr float kLeastMirror = 0.01F;
// ... and edges in those weaker than this are not worth more samples.
constexpr float kLeastMirrorEdge = 0.2F;
// Seen flatter than this (cosine), a surface's texture is blurred as at this angle.
constexpr float kLeastCosine = 0.01F;
// A mirror reflects at grazing so many times what it does seen from straight above, and not more than everything:
// a floor is less than perfectly smooth.
constexpr float kGrazingGain = 10;
// ... and what it shows is softer by this factor, across the line of sight: that also saves samples.
constexpr float kMirrorBlur = 2;

template <typename T>
using PacketOf = std::array<T, kPacket>;

float Power5(float x) {
  const float square = x * x;
  return square * square * x;
}

std::vector<Texture> Drawn(const std::vector<RepeatedPattern>& patterns, int threads) {
  std::vector<std::optional<Texture>> drawn(patterns.size());
  ForEachIndex(static_cast<int>(patterns.size()), threads, [&](int i) {
    const RepeatedPattern& pattern = patterns[i];
    drawn[i].emplace(pattern.draw(), pattern.size);
    if (pattern.contrast != 1) drawn[i] = drawn[i]->WithContrast(pattern.contrast);
  });
  std::vector<Texture> textures;
  for (std::optional<Texture>& texture : drawn) textures.push_back(std::move(*texture));
  return textures;
}

}  // namespace

LitScene::LitScene(Scene given, int threads)
    : scene(std::move(given)), textures(Drawn(scene.patterns, threads)), sky(scene.sky) {
  looks.push_back(MakeLooks(scene.fixed));
  for (const Mesh& movable : scene.movable) looks.push_back(MakeLooks(movable));
}

// Where a ray ends.
struct Tracer::Spot {
  bool hit = false;
  Eigen::Vector3f place;   // world, lifted off the surface
  Eigen::Vector3f normal;  // world, towards the viewer
  float path = 0;          // metres from the eye, by way of the mirror
  float cosine = 1;        // between the normal and the ray
  float reflectance = 0;
  float light = 0;
  float glow = 0;
  float mirror = 0;   // weight of the mirror image
  float time = 0.5F;  // the ray's
  std::uint32_t look = 0;
};

Tracer::Tracer(const LitScene& lit, PlacedScene placed, const std::vector<Eigen::Matrix3f>& world_from_movable)
    : lit_(&lit), placed_(std::move(placed)), world_from_mesh_{Eigen::Matrix3f::Identity()} {
  world_from_mesh_.insert(world_from_mesh_.end(), world_from_movable.begin(), world_from_movable.end());
}

Tracer::Spot Tracer::SpotAt(const Ray& ray, const Hit& hit, float before) const {
  Spot spot;
  if (hit.mesh < 0) return spot;
  const TriangleLook& look = lit_->looks[hit.mesh][hit.triangle];
  const TextureFrame& frame = lit_->mesh(hit.mesh).frames[look.frame];
  const Material& material = lit_->scene.materials[look.material];
  const bool turned = hit.mesh > 0;
  const Eigen::Matrix3f& world_from_mesh = world_from_mesh_[hit.mesh];

  Eigen::Vector3f direction = ray.direction;
  if (turned) direction = world_from_mesh.transpose() * direction;
  const float across = look.normal.dot(direction);
  spot.hit = true;
  spot.time = ray.time;
  spot.cosine = std::abs(across);
  spot.normal = across > 0 ? Eigen::Vector3f(-look.normal) : look.normal;
  // What the pixel covers: its angle's width across, more along the ray.
  spot.path = before + hit.distance;
  const bool mirrored = before > 0;
  const float half = 0.5F * ray.width * spot.path;
  const float minor = mirrored ? kMirrorBlur * half : half;
  const Eigen::Vector3f along = direction - across * look.normal;
  const float stretch = half / (std::max(spot.cosine, kLeastCosine) * std::max(along.norm(), 1e-6F));
  Eigen::Vector2f major(stretch * along.dot(frame.u), stretch * along.dot(frame.v));
  if (mirrored && spot.cosine * kMirrorBlur > 1) major *= kMirrorBlur * spot.cosine;
  const Eigen::Vector2f at = look.texture_at_first + hit.u * look.texture_by_u + hit.v * look.texture_by_v;
  spot.reflectance = material.tint * lit_->textures[material.pattern].Sample(at, major, minor);
  spot.light = look.light_at_first + hit.u * look.light_by_u + hit.v * look.light_by_v;
  spot.glow = material.glow;
  if (material.mirror > 0)
    spot.mirror =
        material.mirror + (std::min(1.0F, kGrazingGain * material.mirror) - material.mirror) * Power5(1 - spot.cosine);

  if (turned) spot.normal = world_from_mesh * spot.normal;
  spot.place = ray.origin + hit.distance * ray.direction + kLift * spot.normal;
  spot.look = static_cast<std::uint32_t>(Hash((static_cast<std::uint64_t>(hit.mesh) << 40U) ^
                                              (static_cast<std::uint64_t>(look.frame) << 12U) ^
                                              static_cast<std::uint64_t>(look.material)));
  return spot;
}

void Tracer::AddSun(std::span<Spot> spots) const {
  const Eigen::Vector3f towards = lit_->scene.sun->direction.normalized();
  PacketOf<Ray> rays;
  PacketOf<Spot*> asked;
  size_t count = 0;
  for (Spot& spot : spots) {
    if (!spot.hit || spot.normal.dot(towards) <= 0) continue;
    rays[count].origin = spot.place;
    rays[count].direction = towards;
    rays[count].time = spot.time;
    asked[count++] = &spot;
  }
  PacketOf<bool> blocked;
  placed_.FindBlocked({rays.data(), count}, true, {blocked.data(), count});
  for (size_t i = 0; i < count; ++i) {
    if (blocked[i]) continue;
    asked[i]->light += lit_->scene.sun->strength * asked[i]->normal.dot(towards);
    asked[i]->look ^= 0x5bd1e995U;
  }
}

void Tracer::AddMirrored(std::span<const Ray> rays, std::span<const Spot> spots, std::span<Seen> seen) const {
  PacketOf<Ray> mirrored;
  PacketOf<float> before;
  PacketOf<size_t> asked;
  size_t count = 0;
  for (size_t i = 0; i < spots.size(); ++i) {
    if (!spots[i].hit || spots[i].mirror < kLeastMirror) continue;
    const Eigen::Vector3f& direction = rays[i].direction;
    mirrored[count] = rays[i];
    // From the surface itself: a millimetre above it, things would be mirrored a millimetre too high.
    mirrored[count].origin = spots[i].place - kLift * spots[i].normal;
    mirrored[count].start = kLift / std::max(spots[i].cosine, kLeastCosine);
    mirrored[count].direction = direction + 2 * spots[i].cosine * spots[i].normal;
    before[count] = spots[i].path;
    asked[count++] = i;
  }
  PacketOf<Seen> image;
  Trace({mirrored.data(), count}, {before.data(), count}, false, {image.data(), count});
  for (size_t i = 0; i < count; ++i) {
    Seen& target = seen[asked[i]];
    const float weight = spots[asked[i]].mirror;
    target.brightness += weight * (image[i].brightness - target.brightness);
    if (weight > kLeastMirrorEdge) target.look ^= 31 * image[i].look;
  }
}

void Tracer::Trace(std::span<const Ray> rays, std::span<const float> before, bool mirrors, std::span<Seen> seen) const {
  if (rays.empty()) return;
  PacketOf<Hit> hits;
  placed_.Intersect(rays, true, hits);
  PacketOf<Spot> spots;
  for (size_t i = 0; i < rays.size(); ++i) spots[i] = SpotAt(rays[i], hits[i], before[i]);
  const std::span<Spot> used(spots.data(), rays.size());
  if (lit_->scene.sun) AddSun(used);
  for (size_t i = 0; i < rays.size(); ++i) {
    const Spot& spot = spots[i];
    seen[i].distance = hits[i].distance;
    seen[i].look = spot.look;
    seen[i].brightness =
        spot.hit ? spot.reflectance * spot.light + spot.glow : lit_->sky.At(rays[i].direction, rays[i].width);
  }
  if (mirrors) AddMirrored(rays, used, seen);
}

void Tracer::Trace(std::span<const Ray> rays, std::span<Seen> seen) const {
  constexpr PacketOf<float> kAtTheEye = {};
  Trace(rays, {kAtTheEye.data(), rays.size()}, true, seen);
}

}  // namespace turnscale

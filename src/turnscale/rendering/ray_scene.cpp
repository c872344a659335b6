// SPDX-License-Identifier: MIT
#include "turnscale/rendering/ray_scene.h"

#include <stdexcept>
#include <string>

#include <embree3/rtcore.h>

namespace turnscale {
namespace {

RTCDevice Handle(const std::shared_ptr<void>& device) { return static_cast<RTCDevice>(device.get()); }
RTCScene SceneHandle(const std::shared_ptr<void>& scene) { return static_cast<RTCScene>(scene.get()); }

std::shared_ptr<void> MakeDevice() {
  // One thread builds the same tree every time.
  RTCDevice device = rtcNewDevice("threads=1");
  if (device == nullptr)
    throw std::runtime_error("Embree cannot be initialised: error " + std::to_string(rtcGetDeviceError(nullptr)));
  return {device, [](void* handle) { rtcReleaseDevice(static_cast<RTCDevice>(handle)); }};
}

std::shared_ptr<void> MakeScene(RTCDevice device) {
  RTCScene scene = rtcNewScene(device);
  return {scene, [](void* handle) { rtcReleaseScene(static_cast<RTCScene>(handle)); }};
}

void Attach(RTCScene scene, RTCGeometry geometry, int id) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

std::shared_ptr<void> MakeMeshScene(RTCDevice device, const Mesh& mesh) {
  std::shared_ptr<void> scene = MakeScene(device);
  rtcSetSceneBuildQuality(SceneHandle(scene), RTC_BUILD_QUALITY_HIGH);
  // No ray slips through between two triangles.
  rtcSetSceneFlags(SceneHandle(scene), RTC_SCENE_FLAG_ROBUST);
  if (!mesh.triangles.empty()) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), mesh.vertices.size()));
    for (const Eigen::Vector3f& vertex : mesh.vertices)
      for (int axis = 0; axis < 3; ++axis) *vertices++ = vertex[axis];
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                   3 * sizeof(unsigned), mesh.triangles.size()));
    for (const Triangle& triangle : mesh.triangles)
      for (const int vertex : triangle.vertices) *indices++ = static_cast<unsigned>(vertex);
    Attach(SceneHandle(scene), geometry, 0);
  }
  rtcCommitScene(SceneHandle(scene));
  return scene;
}

void SetPose(RTCGeometry instance, int step, const RigidTransform& world_from_mesh) {
  const Eigen::Matrix3f rotation = world_from_mesh.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f translation = world_from_mesh.translation.cast<float>();
  float columns[12];
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) columns[3 * column + row] = rotation(row, column);
    columns[9 + row] = translation[row];
  }
  rtcSetGeometryTransform(instance, step, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns);
}

RTCIntersectContext MakeContext(bool alike) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = alike ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return context;
}

void Fill(std::span<const Ray> rays, RTCRay8& packet, int* valid) {
  for (int i = 0; i < kPacket; ++i) {
    const bool used = i < static_cast<int>(rays.size());
    valid[i] = used ? -1 : 0;
    const Ray& ray = rays[used ? i : 0];
    packet.org_x[i] = ray.origin.x();
    packet.org_y[i] = ray.origin.y();
    packet.org_z[i] = ray.origin.z();
    packet.dir_x[i] = ray.direction.x();
    packet.dir_y[i] = ray.direction.y();
    packet.dir_z[i] = ray.direction.z();
    packet.tnear[i] = ray.start;
    packet.tfar[i] = ray.end;
    packet.time[i] = ray.time;
    packet.mask[i] = ~0U;
    packet.id[i] = 0;
    packet.flags[i] = 0;
  }
}

}  // namespace

void PlacedScene::Intersect(std::span<const Ray> rays, bool alike, std::span<Hit> hits) const {
  if (rays.empty()) return;
  RTCRayHit8 packet;
  alignas(32) int valid[kPacket];
  Fill(rays, packet.ray, valid);
  for (int i = 0; i < kPacket; ++i) {
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  RTCIntersectContext context = MakeContext(alike);
  rtcIntersect8(valid, SceneHandle(scene_), &context, &packet);
  for (size_t i = 0; i < rays.size(); ++i) {
    hits[i] = Hit();
    if (packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    const unsigned instance = packet.hit.instID[0][i];
    hits[i].mesh = instance == RTC_INVALID_GEOMETRY_ID ? 0 : static_cast<int>(instance);
    hits[i].triangle = static_cast<int>(packet.hit.primID[i]);
    hits[i].distance = packet.ray.tfar[i];
    hits[i].u = packet.hit.u[i];
    hits[i].v = packet.hit.v[i];
  }
}

void PlacedScene::FindBlocked(std::span<const Ray> rays, bool alike, std::span<bool> blocked) const {
  if (rays.empty()) return;
  RTCRay8 packet;
  alignas(32) int valid[kPacket];
  Fill(rays, packet, valid);
  RTCIntersectContext context = MakeContext(alike);
  rtcOccluded8(valid, SceneHandle(scene_), &context, &packet);
  // Embree sets the end of a blocked ray to minus infinity.
  for (size_t i = 0; i < rays.size(); ++i) blocked[i] = packet.tfar[i] < 0;
}

RayScene::RayScene(const Scene& scene) : device_(MakeDevice()) {
  meshes_.push_back(MakeMeshScene(Handle(device_), scene.fixed));
  for (const Mesh& mesh : scene.movable) meshes_.push_back(MakeMeshScene(Handle(device_), mesh));
}

PlacedScene RayScene::Place(const std::vector<std::vector<RigidTransform>>& world_from_movable) const {
  if (world_from_movable.empty()) return Alone(0);
  PlacedScene placed;
  placed.scene_ = MakeScene(Handle(device_));
  for (size_t i = 0; i < meshes_.size(); ++i) {
    RTCGeometry instance = rtcNewGeometry(Handle(device_), RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, SceneHandle(meshes_[i]));
    const std::vector<RigidTransform> poses = i == 0 ? std::vector<RigidTransform>(1) : world_from_movable[i - 1];
    rtcSetGeometryTimeStepCount(instance, static_cast<unsigned>(poses.size()));
    for (size_t step = 0; step < poses.size(); ++step) SetPose(instance, static_cast<int>(step), poses[step]);
    Attach(SceneHandle(placed.scene_), instance, static_cast<int>(i));
  }
  rtcCommitScene(SceneHandle(placed.scene_));
  return placed;
}

PlacedScene RayScene::Alone(int mesh) const {
  PlacedScene placed;
  placed.scene_ = meshes_.at(mesh);
  return placed;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/rendering/surface.h"

#include <algorithm>

#include <Eigen/Geometry>

#include "turnscale/base/error.h"

namespace turnscale {

Eigen::Vector3f NormalOf(const Mesh& mesh, const Triangle& triangle) {
  const auto [a, b, c] = triangle.vertices;
  return (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).normalized();
}

std::vector<TriangleLook> MakeLooks(const Mesh& mesh) {
  std::vector<TriangleLook> looks;
  looks.reserve(mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    const TextureFrame& frame = mesh.frames[triangle.frame];
    std::array<Eigen::Vector2f, 3> texture;
    std::array<float, 3> light = {0, 0, 0};
    for (int i = 0; i < 3; ++i) {
      const int vertex = triangle.vertices[i];
      const Eigen::Vector3f from_origin = mesh.vertices[vertex] - frame.origin;
      texture[i] = {from_origin.dot(frame.u), from_origin.dot(frame.v)};
      if (!mesh.light.empty()) light[i] = mesh.light[vertex];
    }
    TriangleLook& look = looks.emplace_back();
    look.texture_at_first = texture[0];
    look.texture_by_u = texture[1] - texture[0];
    look.texture_by_v = texture[2] - texture[0];
    look.light_at_first = light[0];
    look.light_by_u = light[1] - light[0];
    look.light_by_v = light[2] - light[0];
    look.normal = NormalOf(mesh, triangle);
    look.material = triangle.material;
    look.frame = triangle.frame;
  }
  return looks;
}

void CheckMesh(const Mesh& mesh, int materials) {
  const auto refuse = [](int index, size_t count, const char* what) {
    if (index < 0 || static_cast<size_t>(index) >= count)
      throw InternalError(std::string("a triangle has no such ") + what);
  };
  for (const Triangle& triangle : mesh.triangles) {
    for (const int vertex : triangle.vertices) refuse(vertex, mesh.vertices.size(), "vertex");
    refuse(triangle.material, static_cast<size_t>(materials), "material");
    refuse(triangle.frame, mesh.frames.size(), "texture frame");
  }
  if (!mesh.light.empty() && mesh.light.size() != mesh.vertices.size())
    throw InternalError("a mesh has light for some of its vertices only");
}

}  // namespace turnscale

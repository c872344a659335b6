// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Core>

#include "turnscale/rendering/mesh.h"

namespace turnscale {

/// What shading needs to know of a triangle, in one cache line. Values at a point with the weights u and v of the
/// second and third vertex are `at_first + u * by_u + v * by_v`.
struct alignas(64) TriangleLook {
  Eigen::Vector2f texture_at_first, texture_by_u, texture_by_v;  ///< metres
  float light_at_first = 0;
  float light_by_u = 0;
  float light_by_v = 0;
  Eigen::Vector3f normal;  ///< unit, outwards, in the mesh's frame
  int material = 0;
  int frame = 0;
};

/// The looks of a mesh's triangles; light is 0 where the mesh has none baked.
std::vector<TriangleLook> MakeLooks(const Mesh& mesh);

/// Unit normal of a triangle, outwards.
Eigen::Vector3f NormalOf(const Mesh& mesh, const Triangle& triangle);

/// Throws InternalError where a triangle refers to something that is not there.
void CheckMesh(const Mesh& mesh, int materials);

}  // namespace turnscale

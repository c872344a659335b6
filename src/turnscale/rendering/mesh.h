// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Where a texture lies on flat surfaces: `origin` shows its corner, `u` and `v` are unit vectors along its rows and
/// columns. Texture coordinates are metres.
struct TextureFrame {
  Eigen::Vector3f origin = Eigen::Vector3f::Zero();
  Eigen::Vector3f u = Eigen::Vector3f::UnitX();
  Eigen::Vector3f v = Eigen::Vector3f::UnitY();
};

struct Triangle {
  std::array<int, 3> vertices = {0, 0, 0};  ///< counter-clockwise seen from outside
  int material = 0;                         ///< index into Scene::materials
  int frame = 0;                            ///< index into Mesh::frames
};

/// Triangles with a look, metres. Axes x right, y down, z forward: up is -y.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Triangle> triangles;
  std::vector<TextureFrame> frames;
  /// Light that falls on each vertex apart from the sun, in units of what a white surface returns as 1; empty until
  /// it is baked.
  std::vector<float> light;
};

/// How a surface is laid out.
struct SurfaceStyle {
  int material = 0;
  /// Baked light is known at points this far apart, metres.
  double light_step = 1.0;
  /// What the texture shows at the surface's corner, metres: two walls of one material look different.
  Eigen::Vector2d texture_offset = Eigen::Vector2d::Zero();
};

/// A rectangle from `corner` along `u` and `v`, which are perpendicular; it is seen from the side to which u x v
/// points.
void AddRectangle(const SurfaceStyle& style, const Eigen::Vector3d& corner, const Eigen::Vector3d& u,
                  const Eigen::Vector3d& v, Mesh& mesh);

/// A box standing on `world_from_base`'s plane y = 0, its centre above the origin: width along x, height along -y,
/// depth along z, metres. Seen from outside. The top face may be smaller and moved forward, as a car's cabin is.
struct Box {
  Eigen::Vector3d size = Eigen::Vector3d::Ones();  ///< width, height, depth
  double top_width = -1;                           ///< negative: as the bottom
  double top_depth = -1;                           ///< negative: as the bottom
  double top_shift = 0;                            ///< of the top's centre, forward
};
void AddBox(const SurfaceStyle& style, const RigidTransform& world_from_base, const Box& box, Mesh& mesh);

/// An upright prism with `sides` equal sides around `world_from_base`'s origin: pillars, trunks, lamp posts, crowns.
struct Prism {
  double radius = 0.3;
  double top_radius = 0.3;
  double height = 1;
  int sides = 12;
};
void AddPrism(const SurfaceStyle& style, const RigidTransform& world_from_base, const Prism& prism, Mesh& mesh);

/// A square tile of uneven ground: corner heights `up[row][column]` (metres above y = 0), rows along z and columns
/// along x, `step` metres apart, the first at (x, z) = `corner`. Cells where a height is NaN stay open. The texture
/// lies as seen from above, the same for all tiles: it shows `texture_offset` at the world's origin. Light is known at
/// the heights' points.
void AddGround(const SurfaceStyle& style, const Eigen::Vector2d& corner, double step,
               const std::vector<std::vector<double>>& up, Mesh& mesh);

/// Appends the triangles of another mesh, moved.
void AddMesh(const RigidTransform& world_from_other, const Mesh& other, Mesh& mesh);

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

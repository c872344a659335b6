// SPDX-License-Identifier: MIT
#include "turnscale/rendering/mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

int Pieces(double length, double step) {
  if (!(step > 0)) throw InternalError("light_step has to be positive");
  // A length that is a whole number of steps stays so when rounding has touched it.
  return std::max(1, static_cast<int>(std::ceil(length / step - 1e-6)));
}

int AddVertex(Mesh& mesh, const Eigen::Vector3d& at) {
  mesh.vertices.emplace_back(at.cast<float>());
  return static_cast<int>(mesh.vertices.size()) - 1;
}

int AddFrame(Mesh& mesh, const Eigen::Vector3d& origin, const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  mesh.frames.push_back({origin.cast<float>(), u.normalized().cast<float>(), v.normalized().cast<float>()});
  return static_cast<int>(mesh.frames.size()) - 1;
}

void AddTriangle(const SurfaceStyle& style, int frame, int a, int b, int c, Mesh& mesh) {
  const Eigen::Vector3f& corner = mesh.vertices[a];
  // The tips of cones and pyramids leave triangles without an area.
  if ((mesh.vertices[b] - corner).cross(mesh.vertices[c] - corner).norm() < 1e-9F) return;
  mesh.triangles.push_back({{a, b, c}, style.material, frame});
}

// A plane quadrilateral, its corners in the order a -> b -> c -> d, counter-clockwise seen from outside; its texture
// runs along a -> b, and shows `style.texture_offset` at `origin`.
struct Quad {
  Eigen::Vector3d a, b, c, d;
  Eigen::Vector3d origin;
};

void AddQuad(const SurfaceStyle& style, const Quad& quad, Mesh& mesh) {
  Eigen::Vector3d u = quad.b - quad.a;
  if (u.norm() < 1e-9) u = quad.c - quad.d;
  if (u.norm() < 1e-9) return;
  u.normalize();
  Eigen::Vector3d v = (quad.d + quad.c) - (quad.a + quad.b);
  v = (v - u * u.dot(v)).normalized();
  const int columns = Pieces(std::max((quad.b - quad.a).norm(), (quad.c - quad.d).norm()), style.light_step);
  const int rows = Pieces(std::max((quad.d - quad.a).norm(), (quad.c - quad.b).norm()), style.light_step);
  const int frame = AddFrame(mesh, quad.origin - style.texture_offset.x() * u - style.texture_offset.y() * v, u, v);
  const int first = static_cast<int>(mesh.vertices.size());
  for (int row = 0; row <= rows; ++row) {
    const double down = static_cast<double>(row) / rows;
    const Eigen::Vector3d left = quad.a + down * (quad.d - quad.a);
    const Eigen::Vector3d right = quad.b + down * (quad.c - quad.b);
    for (int column = 0; column <= columns; ++column)
      AddVertex(mesh, left + (static_cast<double>(column) / columns) * (right - left));
  }
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int at = first + row * (columns + 1) + column;
      const int below = at + columns + 1;
      AddTriangle(style, frame, at, at + 1, below + 1, mesh);
      AddTriangle(style, frame, at, below + 1, below, mesh);
    }
  }
}

// A polygon around its centre, counter-clockwise seen from outside, textured along u and v.
void AddFan(const SurfaceStyle& style, const std::vector<Eigen::Vector3d>& corners, const Eigen::Vector3d& centre,
            const Eigen::Vector3d& u, const Eigen::Vector3d& v, Mesh& mesh) {
  const int frame = AddFrame(mesh, centre - style.texture_offset.x() * u - style.texture_offset.y() * v, u, v);
  const int middle = AddVertex(mesh, centre);
  const int count = static_cast<int>(corners.size());
  for (const Eigen::Vector3d& corner : corners) AddVertex(mesh, corner);
  for (int i = 0; i < count; ++i) AddTriangle(style, frame, middle, middle + 1 + i, middle + 1 + (i + 1) % count, mesh);
}

}  // namespace

void AddRectangle(const SurfaceStyle& style, const Eigen::Vector3d& corner, const Eigen::Vector3d& u,
                  const Eigen::Vector3d& v, Mesh& mesh) {
  AddQuad(style, {corner, corner + u, corner + u + v, corner + v, corner}, mesh);
}

void AddBox(const SurfaceStyle& style, const RigidTransform& world_from_base, const Box& box, Mesh& mesh) {
  const double top_width = box.top_width < 0 ? box.size.x() : box.top_width;
  const double top_depth = box.top_depth < 0 ? box.size.z() : box.top_depth;
  // Corners by the signs of their x and z.
  const auto bottom = [&](double x, double z) -> Eigen::Vector3d {
    return world_from_base * Eigen::Vector3d(0.5 * x * box.size.x(), 0, 0.5 * z * box.size.z());
  };
  const auto top = [&](double x, double z) -> Eigen::Vector3d {
    return world_from_base * Eigen::Vector3d(0.5 * x * top_width, -box.size.y(), 0.5 * z * top_depth + box.top_shift);
  };
  // Seen from outside, each side runs leftwards and down from its upper right corner: the texture's rows are level.
  const auto add_side = [&](double right_x, double right_z, double left_x, double left_z) {
    const Eigen::Vector3d a = top(right_x, right_z);
    AddQuad(style, {a, top(left_x, left_z), bottom(left_x, left_z), bottom(right_x, right_z), a}, mesh);
  };
  add_side(1, -1, -1, -1);
  add_side(-1, 1, 1, 1);
  add_side(1, 1, 1, -1);
  add_side(-1, -1, -1, 1);
  AddQuad(style, {top(-1, -1), top(1, -1), top(1, 1), top(-1, 1), top(-1, -1)}, mesh);
  AddQuad(style, {bottom(-1, -1), bottom(-1, 1), bottom(1, 1), bottom(1, -1), bottom(-1, -1)}, mesh);
}

void AddPrism(const SurfaceStyle& style, const RigidTransform& world_from_base, const Prism& prism, Mesh& mesh) {
  if (prism.sides < 3) throw InternalError("a prism has three sides or more");
  std::vector<Eigen::Vector3d> bottom(prism.sides);
  std::vector<Eigen::Vector3d> top(prism.sides);
  for (int i = 0; i < prism.sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / prism.sides;
    const Eigen::Vector3d outwards(std::cos(angle), 0, std::sin(angle));
    bottom[i] = world_from_base * Eigen::Vector3d(prism.radius * outwards);
    top[i] = world_from_base * Eigen::Vector3d(prism.top_radius * outwards - prism.height * Eigen::Vector3d::UnitY());
  }
  const double width = 2 * std::max(prism.radius, prism.top_radius) * std::sin(std::numbers::pi / prism.sides);
  for (int i = 0; i < prism.sides; ++i) {
    const int next = (i + 1) % prism.sides;
    // The texture goes on around the corner: seen from outside, sides of higher numbers lie to the right, earlier along
    // the texture's rows.
    SurfaceStyle side = style;
    side.texture_offset.x() += (prism.sides - 0.5 - i) * width;
    AddQuad(side, {top[next], top[i], bottom[i], bottom[next], 0.5 * (top[i] + top[next])}, mesh);
  }
  const Eigen::Vector3d x = world_from_base.rotation * Eigen::Vector3d::UnitX();
  const Eigen::Vector3d z = world_from_base.rotation * Eigen::Vector3d::UnitZ();
  AddFan(style, top, world_from_base * Eigen::Vector3d(0, -prism.height, 0), x, z, mesh);
  std::reverse(bottom.begin(), bottom.end());
  AddFan(style, bottom, world_from_base.translation, z, x, mesh);
}

void AddGround(const SurfaceStyle& style, const Eigen::Vector2d& corner, double step,
               const std::vector<std::vector<double>>& up, Mesh& mesh) {
  const Eigen::Vector3d origin(-style.texture_offset.x(), 0, -style.texture_offset.y());
  const int frame = AddFrame(mesh, origin, Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ());
  std::vector<std::vector<int>> vertices;
  for (size_t row = 0; row < up.size(); ++row) {
    if (up[row].size() != up[0].size()) throw InternalError("rows of a ground differ in length");
    std::vector<int>& indices = vertices.emplace_back();
    for (size_t column = 0; column < up[row].size(); ++column) {
      const double height = up[row][column];
      const Eigen::Vector3d at(corner.x() + static_cast<double>(column) * step, -height,
                               corner.y() + static_cast<double>(row) * step);
      indices.push_back(std::isnan(height) ? -1 : AddVertex(mesh, at));
    }
  }
  for (size_t row = 0; row + 1 < up.size(); ++row) {
    for (size_t column = 0; column + 1 < up[row].size(); ++column) {
      const int a = vertices[row][column];
      const int b = vertices[row][column + 1];
      const int c = vertices[row + 1][column + 1];
      const int d = vertices[row + 1][column];
      if (std::min({a, b, c, d}) < 0) continue;
      AddTriangle(style, frame, a, b, c, mesh);
      AddTriangle(style, frame, a, c, d, mesh);
    }
  }
}

void AddMesh(const RigidTransform& world_from_other, const Mesh& other, Mesh& mesh) {
  const int first_vertex = static_cast<int>(mesh.vertices.size());
  const int first_frame = static_cast<int>(mesh.frames.size());
  const Eigen::Quaternionf rotation = world_from_other.rotation.cast<float>();
  for (const Eigen::Vector3f& vertex : other.vertices)
    mesh.vertices.emplace_back((world_from_other * vertex.cast<double>()).cast<float>());
  for (const TextureFrame& frame : other.frames)
    mesh.frames.push_back(
        {(world_from_other * frame.origin.cast<double>()).cast<float>(), rotation * frame.u, rotation * frame.v});
  for (Triangle triangle : other.triangles) {
    for (int& vertex : triangle.vertices) vertex += first_vertex;
    triangle.frame += first_frame;
    mesh.triangles.push_back(triangle);
  }
  // Light is of all vertices or of none.
  const bool lit = mesh.light.size() == static_cast<size_t>(first_vertex);
  mesh.light.insert(mesh.light.end(), other.light.begin(), other.light.end());
  if (!lit || mesh.light.size() != mesh.vertices.size()) mesh.light.clear();
}

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

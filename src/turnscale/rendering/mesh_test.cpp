// SPDX-License-Identifier: MIT
#include "turnscale/rendering/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

RigidTransform PlaceOfSolid() {
  RigidTransform pose;
  pose.rotation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.2, 1, -0.4).normalized());
  pose.translation = {3, -1, 8};
  return pose;
}

Eigen::Vector3f MiddleOf(const Mesh& mesh, const Triangle& triangle) {
  const auto [a, b, c] = triangle.vertices;
  return (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]) / 3;
}

double AreaOf(const Mesh& mesh, const Triangle& triangle) {
  const auto [a, b, c] = triangle.vertices;
  return 0.5 * (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]).norm();
}

// Of what the triangles enclose when their outsides are outside (divergence theorem).
double VolumeOf(const Mesh& mesh) {
  double volume = 0;
  for (const Triangle& triangle : mesh.triangles) {
    const auto [a, b, c] = triangle.vertices;
    volume +=
        mesh.vertices[a].cast<double>().dot(mesh.vertices[b].cast<double>().cross(mesh.vertices[c].cast<double>())) / 6;
  }
  return volume;
}

float LongestLevelEdge(const Mesh& mesh) {
  float longest = 0;
  for (const Triangle& triangle : mesh.triangles) {
    // The diagonal joins the first vertex of each triangle with a vertex across the cell.
    std::array<float, 3> edges;
    for (int i = 0; i < 3; ++i)
      edges[i] = (mesh.vertices[triangle.vertices[i]] - mesh.vertices[triangle.vertices[(i + 1) % 3]]).norm();
    std::sort(edges.begin(), edges.end());
    longest = std::max(longest, edges[1]);
  }
  return longest;
}

TEST(Mesh, RectangleFacesWhereItsSidesTurn) {
  Mesh mesh;
  const Eigen::Vector3d corner(1, 2, 3);
  AddRectangle({2, 0.5, {0.25, 0.75}}, corner, {2.2, 0, 0}, {0, 0, 1.1}, mesh);
  double area = 0;
  for (const Triangle& triangle : mesh.triangles) {
    EXPECT_LT((NormalOf(mesh, triangle) - Eigen::Vector3f(0, -1, 0)).norm(), 1e-6);
    EXPECT_EQ(triangle.material, 2);
    area += AreaOf(mesh, triangle);
  }
  EXPECT_NEAR(area, 2.2 * 1.1, 1e-5);
  EXPECT_LE(LongestLevelEdge(mesh), 0.5F + 1e-5F);
  const TextureFrame& frame = mesh.frames.at(0);
  EXPECT_NEAR((corner.cast<float>() - frame.origin).dot(frame.u), 0.25, 1e-6);
  EXPECT_NEAR((corner.cast<float>() - frame.origin).dot(frame.v), 0.75, 1e-6);
}

TEST(Mesh, BoxesAreClosedAndFaceOutwards) {
  const RigidTransform pose = PlaceOfSolid();
  Box cabin;
  cabin.size = {1.7, 1.4, 4.2};
  EXPECT_NEAR(
      [&] {
        Mesh mesh;
        AddBox({}, pose, cabin, mesh);
        return VolumeOf(mesh);
      }(),
      1.7 * 1.4 * 4.2, 1e-3);
  cabin.top_width = 1.2;
  cabin.top_depth = 2;
  cabin.top_shift = -0.3;
  Mesh mesh;
  AddBox({}, pose, cabin, mesh);
  const Eigen::Vector3f centre = (pose * Eigen::Vector3d(0, -0.7, 0)).cast<float>();
  for (const Triangle& triangle : mesh.triangles)
    EXPECT_GT(NormalOf(mesh, triangle).dot(MiddleOf(mesh, triangle) - centre), 0.1F);
  EXPECT_EQ(mesh.frames.size(), 6U);
  EXPECT_LE(LongestLevelEdge(mesh), 1.0F + 1e-5F);
  // The height is upwards, which is -y.
  Mesh upright;
  AddBox({}, {}, cabin, upright);
  for (const Eigen::Vector3f& vertex : upright.vertices) {
    EXPECT_LE(vertex.y(), 1e-6F);
    EXPECT_GE(vertex.y(), -1.4F - 1e-6F);
  }
}

TEST(Mesh, TextureFramesLieInTheirTriangles) {
  Mesh mesh;
  AddBox({}, PlaceOfSolid(), {{1, 2, 3}, 0.4, 0.5, 0.2}, mesh);
  AddPrism({}, PlaceOfSolid(), {0.4, 0.2, 3, 7}, mesh);
  for (const Triangle& triangle : mesh.triangles) {
    const TextureFrame& frame = mesh.frames[triangle.frame];
    EXPECT_NEAR(frame.u.norm(), 1, 1e-5);
    EXPECT_NEAR(frame.v.norm(), 1, 1e-5);
    EXPECT_NEAR(frame.u.dot(frame.v), 0, 1e-5);
    EXPECT_NEAR(frame.u.dot(NormalOf(mesh, triangle)), 0, 1e-4);
    EXPECT_NEAR(frame.v.dot(NormalOf(mesh, triangle)), 0, 1e-4);
  }
}

TEST(Mesh, PrismsAndConesAreClosedAndFaceOutwards) {
  for (const double top_radius : {0.5, 0.2, 0.0}) {
    const int sides = 9;
    Mesh mesh;
    AddPrism({}, PlaceOfSolid(), {0.5, top_radius, 2, sides}, mesh);
    const double polygon = 0.5 * sides * std::sin(2 * M_PI / sides);
    const double radii = 0.25 + 0.5 * top_radius + top_radius * top_radius;
    EXPECT_NEAR(VolumeOf(mesh), polygon * 2 * radii / 3, 1e-4) << top_radius;
    for (const Triangle& triangle : mesh.triangles) EXPECT_GT(AreaOf(mesh, triangle), 0);
  }
  Mesh mesh;
  EXPECT_THROW(AddPrism({}, {}, {0.5, 0.5, 1, 2}, mesh), InternalError);
}

TEST(Mesh, GroundFacesUpAndHasHoles) {
  const double hole = std::numeric_limits<double>::quiet_NaN();
  Mesh mesh;
  AddGround({}, {10, 20}, 2, {{0, 0.1, 0}, {0.2, 0, 0}, {0, 0.1, hole}}, mesh);
  EXPECT_EQ(mesh.triangles.size(), 6U);
  double area = 0;
  for (const Triangle& triangle : mesh.triangles) {
    EXPECT_LT(NormalOf(mesh, triangle).y(), -0.9F);
    area -= AreaOf(mesh, triangle) * NormalOf(mesh, triangle).y();
  }
  EXPECT_NEAR(area, 12, 1e-4);
  // Columns run along x, rows along z, up is -y.
  EXPECT_LT((mesh.vertices.at(1) - Eigen::Vector3f(12, -0.1F, 20)).norm(), 1e-6);
  EXPECT_LT((mesh.vertices.at(3) - Eigen::Vector3f(10, -0.2F, 22)).norm(), 1e-6);
  // Neighbouring tiles go on with the texture.
  EXPECT_TRUE(mesh.frames.at(0).origin.isZero());
}

TEST(Mesh, AMovedMeshIsTheSameElsewhere) {
  Mesh box;
  AddBox({3, 1, {0.1, 0.2}}, {}, {{1, 2, 3}}, box);
  Mesh direct;
  AddBox({3, 1, {0.1, 0.2}}, PlaceOfSolid(), {{1, 2, 3}}, direct);
  Mesh moved;
  AddRectangle({}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, moved);
  const size_t vertices = moved.vertices.size();
  const size_t triangles = moved.triangles.size();
  AddMesh(PlaceOfSolid(), box, moved);
  for (size_t i = 0; i < box.vertices.size(); ++i)
    EXPECT_LT((moved.vertices[vertices + i] - direct.vertices[i]).norm(), 1e-5);
  for (size_t i = 0; i < box.triangles.size(); ++i) {
    const Triangle& there = moved.triangles[triangles + i];
    EXPECT_EQ(there.material, 3);
    EXPECT_EQ(there.vertices[0], direct.triangles[i].vertices[0] + static_cast<int>(vertices));
    EXPECT_LT((moved.frames[there.frame].origin - direct.frames[direct.triangles[i].frame].origin).norm(), 1e-5);
    EXPECT_LT((moved.frames[there.frame].u - direct.frames[direct.triangles[i].frame].u).norm(), 1e-5);
  }
}

TEST(Mesh, LightIsOfAllVerticesOrNone) {
  Mesh lit;
  AddRectangle({}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, lit);
  const Mesh dark = lit;
  lit.light.assign(lit.vertices.size(), 0.5F);
  Mesh both;
  AddMesh({}, lit, both);
  EXPECT_EQ(both.light, lit.light);
  AddMesh({}, dark, both);
  EXPECT_TRUE(both.light.empty());
  AddMesh({}, lit, both);
  EXPECT_TRUE(both.light.empty());
}

TEST(Mesh, RefusesAStepOfNothing) {
  Mesh mesh;
  EXPECT_THROW(AddRectangle({0, 0, {0, 0}}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, mesh), InternalError);
}

}  // namespace
}  // namespace turnscale

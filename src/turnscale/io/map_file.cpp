// SPDX-License-Identifier: MIT
#include "turnscale/io/map_file.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>

#include <fmt/format.h>

namespace turnscale {
namespace {

using Colour = std::array<uint8_t, 3>;
constexpr Colour kLandmarkColour = {200, 200, 200};
constexpr Colour kCameraColour = {230, 40, 40};
constexpr size_t kPiece = 1 << 20;  // bytes

void AddVertex(std::string& vertices, const Eigen::Vector3d& position, const Colour& colour) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto bits = std::bit_cast<uint32_t>(static_cast<float>(position[axis]));
    for (int shift = 0; shift < 32; shift += 8) vertices.push_back(static_cast<char>(bits >> shift & 0xFF));
  }
  for (const uint8_t part : colour) vertices.push_back(static_cast<char>(part));
}

}  // namespace

void WriteMap(const std::filesystem::path& path, const MapPoints& points, const RigidTransform& target_from_world,
              Durability durability) {
  OutputFile file(path);
  try {
    file.Write(fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment turnscale: landmarks gray, cameras red\nelement vertex {}\n"
        "property float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
        points.landmarks.size() + points.cameras.size()));
    // In pieces: the map of a long drive is large.
    std::string vertices;
    const auto write = [&](const Eigen::Vector3d& position, const Colour& colour) {
      AddVertex(vertices, target_from_world * position, colour);
      if (vertices.size() < kPiece) return;
      file.Write(vertices);
      vertices.clear();
    };
    for (const Eigen::Vector3f& landmark : points.landmarks) write(landmark.cast<double>(), kLandmarkColour);
    for (const Eigen::Vector3d& camera : points.cameras) write(camera, kCameraColour);
    file.Write(vertices);
    file.Finish(durability);
  } catch (...) {
    file.Discard();
    throw;
  }
}

}  // namespace turnscale

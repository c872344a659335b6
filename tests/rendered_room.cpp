// SPDX-License-Identifier: MIT
#include "rendered_room.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kHalfHall = 20;
constexpr double kFloor = 1.6;
constexpr double kCeiling = -4;
constexpr double kLeverArm = 1.5;

// Fixed pseudo-random gray of a grid point.
double GrayAt(int64_t u, int64_t v, int surface) {
  uint64_t h = static_cast<uint64_t>(u) * 0x9E3779B97F4A7C15u ^ static_cast<uint64_t>(v) * 0xC2B2AE3D27D4EB4Fu ^
               static_cast<uint64_t>(surface) * 0x165667B19E3779F9u;
  h = (h ^ h >> 31) * 0xD6E8FEB86659FD93u;
  return static_cast<double>((h ^ h >> 32) & 255);
}

double Noise(double u, double v, int surface) {
  const double u0 = std::floor(u);
  const double v0 = std::floor(v);
  const auto at = [&](int i, int j) {
    return GrayAt(static_cast<int64_t>(u0) + i, static_cast<int64_t>(v0) + j, surface);
  };
  const double a = u - u0;
  const double b = v - v0;
  return (1 - b) * ((1 - a) * at(0, 0) + a * at(1, 0)) + b * ((1 - a) * at(0, 1) + a * at(1, 1));
}

// The nearest of the six planes that the ray meets from inside the box.
double Gray(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d low(-kHalfHall, kCeiling, -kHalfHall);
  const Eigen::Vector3d high(kHalfHall, kFloor, kHalfHall);
  double nearest = std::numeric_limits<double>::infinity();
  int surface = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (ray[axis] == 0) continue;
    const double distance = ((ray[axis] > 0 ? high : low)[axis] - origin[axis]) / ray[axis];
    if (distance >= nearest) continue;
    nearest = distance;
    surface = 2 * axis + (ray[axis] > 0 ? 1 : 0);
  }
  const Eigen::Vector3d point = origin + nearest * ray;
  const int axis = surface / 2;
  const double u = point[(axis + 1) % 3];
  const double v = point[(axis + 2) % 3];
  return 0.6 * Noise(1.7 * u, 1.7 * v, surface) + 0.4 * Noise(6.1 * u, 6.1 * v, surface + 6);
}

}  // namespace

cv::Mat RenderRoom(const RigidTransform& world_from_camera) {
  cv::Mat image(kRoomHeight, kRoomWidth, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const Eigen::Vector3d ray = world_from_camera.rotation * kRoomPinhole.Ray({x, y});
      image.at<uint8_t>(y, x) = static_cast<uint8_t>(std::clamp(Gray(world_from_camera.translation, ray), 0.0, 255.0));
    }
  }
  return image;
}

void WriteRoomDrive(const std::filesystem::path& folder, int frames) {
  std::filesystem::create_directories(folder / "image_0");
  std::ofstream times(folder / "times.txt");
  std::ofstream(folder / "calib.txt") << fmt::format("P0: {} 0 {} 0 0 {} {} 0 0 0 1 0\n", kRoomPinhole.fx,
                                                     kRoomPinhole.cx, kRoomPinhole.fy, kRoomPinhole.cy);
  constexpr double kStep = 0.35;  // metres a frame
  RigidTransform world_from_vehicle{Eigen::Quaterniond::Identity(), {-6, 0, -14}};
  for (int i = 0; i < frames; ++i) {
    const RigidTransform vehicle_from_camera{Eigen::Quaterniond::Identity(), {0, 0, kLeverArm}};
    cv::imwrite((folder / "image_0" / fmt::format("{:06}.png", i)).string(),
                RenderRoom(world_from_vehicle * vehicle_from_camera));
    times << fmt::format("{:.3f}\n", 0.1 * i);
    const double psi = i % 60 >= 20 && i % 60 < 50 ? 0.052 : 0.0;
    world_from_vehicle = world_from_vehicle * RigidTransform{RotationFromVector({0, psi, 0}),
                                                             {kStep * std::sin(psi / 2), 0, kStep * std::cos(psi / 2)}};
  }
}

}  // namespace turnscale

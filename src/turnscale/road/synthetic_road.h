// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/road/road_patches.h"

namespace turnscale {

/// A road with walls in a world whose y axis points down, for tests.
struct SyntheticRoad {
  double height = 1.5;     ///< of the world's origin above the road
  double contrast = 1;     ///< of the road's texture
  double half_width = 50;  ///< beyond it are kerbs
  double kerb = 0.15;      ///< their height
};

/// Value noise between 0 and 1, the same for the same place, smooth over 1.
inline double NoiseAt(double x, double y, std::uint32_t seed) {
  const auto corner = [&](double i, double j) {
    auto h = static_cast<std::uint32_t>(static_cast<std::int64_t>(i) * 374761393 +
                                        static_cast<std::int64_t>(j) * 668265263) +
             seed * 2246822519U;
    h = (h ^ (h >> 13)) * 1274126177U;
    return ((h ^ (h >> 16)) & 0xffffU) / 65535.0;
  };
  const double i = std::floor(x);
  const double j = std::floor(y);
  const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
  const double u = smooth(x - i);
  const double v = smooth(y - j);
  return (1 - v) * ((1 - u) * corner(i, j) + u * corner(i + 1, j)) +
         v * ((1 - u) * corner(i, j + 1) + u * corner(i + 1, j + 1));
}

/// What a camera sees of the road; the sky is even. `shade` changes the gray level at a pixel.
inline RoadImage RenderRoad(const SyntheticRoad& road, const CameraModel& camera,
                            const RigidTransform& world_from_camera,
                            const std::function<double(int, int, double)>& shade = {}) {
  cv::Mat gray(camera.height, camera.width, CV_8UC1);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      double level = 0;
      constexpr int kSamples = 2;  // each way
      for (int sample = 0; sample < kSamples * kSamples; ++sample) {
        const int column = sample % kSamples;
        const int row = sample / kSamples;
        const Eigen::Vector2d pixel(x + (column + 0.5) / kSamples - 0.5, y + (row + 0.5) / kSamples - 0.5);
        const auto ideal = camera.Undistort(pixel);
        const Eigen::Vector3d ray =
            ideal ? world_from_camera.rotation * camera.pinhole.Ray(*ideal) : Eigen::Vector3d(0, -1, 0);
        double value = 180;
        if (ray.y() > 1e-3) {
          Eigen::Vector3d point =
              world_from_camera.translation + (road.height - world_from_camera.translation.y()) / ray.y() * ray;
          if (std::abs(point.x()) > road.half_width)
            point = world_from_camera.translation +
                    (road.height - road.kerb - world_from_camera.translation.y()) / ray.y() * ray;
          value = 110 + road.contrast * (80 * (NoiseAt(point.x() / 0.3, point.z() / 0.3, 1) - 0.5) +
                                         50 * (NoiseAt(point.x() / 0.08, point.z() / 0.08, 2) - 0.5));
        }
        level += value / (kSamples * kSamples);
      }
      gray.at<uchar>(y, x) = cv::saturate_cast<uchar>(shade ? shade(x, y, level) : level);
    }
  }
  RoadImage image;
  image.gray = gray;
  // Pixel (x, y) shows what pixel (2x, 2y) does.
  image.half = cv::Mat(gray.rows / 2, gray.cols / 2, CV_8UC1);
  const auto at = [&](int x, int y) {
    return static_cast<int>(gray.at<uchar>(std::clamp(y, 0, gray.rows - 1), std::clamp(x, 0, gray.cols - 1)));
  };
  for (int y = 0; y < image.half.rows; ++y)
    for (int x = 0; x < image.half.cols; ++x) {
      int sum = 0;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) sum += (2 - std::abs(dx)) * (2 - std::abs(dy)) * at(2 * x + dx, 2 * y + dy);
      image.half.at<uchar>(y, x) = static_cast<uchar>((sum + 8) / 16);
    }
  return image;
}

}  // namespace turnscale

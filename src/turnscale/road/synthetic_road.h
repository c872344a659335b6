// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/road/road_patches.h"

namespace turnscale {

/// A road with walls in a world whose y axis points down, for tests.
struct SyntheticRoad {
  double height = 1.5;            ///< of the world's origin above the road
  double contrast = 1;            ///< of the road's texture
  double half_width = 50;         ///< beyond it are kerbs
  double kerb = 0.15;             ///< their height
  double vertical_curvature = 0;  ///< along z, rad per metre, positive where the road curves down
  double level_at = 0;            ///< z where it is level, metres
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

/// Where a ray from `origin` meets a road `height` below the world's origin, as a multiple of the ray; empty far away,
/// or where it does not.
inline std::optional<double> MeetRoad(const SyntheticRoad& road, double height, const Eigen::Vector3d& origin,
                                      const Eigen::Vector3d& ray) {
  // a t^2 - 2 b t + c = 0, of which the root that the ray comes to first.
  const double k = road.vertical_curvature;
  const double a = 0.5 * k * ray.z() * ray.z();
  const double ahead = origin.z() - road.level_at;
  const double b = 0.5 * (ray.y() - k * ahead * ray.z());
  const double c = height + 0.5 * k * ahead * ahead - origin.y();
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0)) return std::nullopt;
  const double inverse = b + std::sqrt(discriminant);
  return inverse > 1e-3 ? std::optional(c / inverse) : std::nullopt;
}

/// Changes the gray level at a pixel (x, y).
using Shade = std::function<double(int, int, double)>;

/// What a camera sees of the road; the sky is even.
inline RoadImage RenderRoad(const SyntheticRoad& road, const CameraModel& camera,
                            const RigidTransform& world_from_camera, const Shade& shade = {}) {
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
        const Eigen::Vector3d& origin = world_from_camera.translation;
        if (const auto distance = MeetRoad(road, road.height, origin, ray)) {
          Eigen::Vector3d point = origin + *distance * ray;
          if (std::abs(point.x()) > road.half_width)
            point = origin + MeetRoad(road, road.height - road.kerb, origin, ray).value_or(*distance) * ray;
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

/// Two views of a road and the region where the road is expected in the later one.
struct RoadViews {
  CameraModel camera;
  RoadImage earlier;
  RoadImage current;
  RigidTransform earlier_from_current;
  RoadRegion region;

  RoadPair Pair() const { return {current, earlier, camera, earlier_from_current, {}}; }
};

/// The camera drives straight ahead, from the world's origin by `travel` metres.
inline RoadViews ViewRoad(const CameraModel& camera, const SyntheticRoad& road,
                          const Eigen::Vector3d& yaw_pitch_roll_deg, double travel = 0.9,
                          const Shade& shade_earlier = {}, const Shade& shade_current = {}) {
  const Eigen::Vector3d angles = yaw_pitch_roll_deg / kDegreesPerRadian;
  const Eigen::Quaterniond world_from_camera = RotationFromYawPitchRoll({angles.x(), angles.y(), angles.z()});
  const RigidTransform earlier{world_from_camera, {0, 0, 0}};
  const RigidTransform current{world_from_camera, {0, 0, travel}};
  RoadViews views{camera,
                  RenderRoad(road, camera, earlier, shade_earlier),
                  RenderRoad(road, camera, current, shade_current),
                  earlier.inverse() * current,
                  {}};
  views.region.level_from_camera = world_from_camera.toRotationMatrix();
  return views;
}

}  // namespace turnscale

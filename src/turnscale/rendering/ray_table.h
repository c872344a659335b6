// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "turnscale/camera/camera_model.h"

namespace turnscale {

/// Where a pixel looks, in the camera frame.
struct PixelRay {
  Eigen::Vector3f direction = Eigen::Vector3f::Zero();  ///< unit; zero where the lens sees nothing
  float width = 0;                                      ///< angle that the pixel covers, radians

  bool sees() const { return width > 0; }
};

/// The rays of all pixels of a camera: lens models are costly to invert.
class RayTable {
 public:
  /// Throws InternalError for a camera without an image size.
  RayTable(const CameraModel& camera, int threads);

  const CameraModel& camera() const { return camera_; }
  const PixelRay& At(int row, int column) const { return rays_[static_cast<size_t>(row) * camera_.width + column]; }

  /// Ray through a point of a pixel that sees, `offset` from its centre (within half a pixel).
  Eigen::Vector3f Inside(int row, int column, const Eigen::Vector2f& offset) const;

 private:
  Eigen::Vector3f Step(int row, int column, int down, int right) const;

  CameraModel camera_;
  std::vector<PixelRay> rays_;
};

/// Direction of a pixel in the camera frame, unit; nothing where the lens sees nothing in front of the image plane.
std::optional<Eigen::Vector3d> RayOf(const CameraModel& camera, const Eigen::Vector2d& pixel);

/// Keeps the table of the camera that was asked for last. Safe to use from several threads.
class RayTableCache {
 public:
  std::shared_ptr<const RayTable> Get(const CameraModel& camera, int threads);

 private:
  std::mutex mutex_;
  std::shared_ptr<const RayTable> table_;
};

}  // namespace turnscale

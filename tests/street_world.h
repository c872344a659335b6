// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// A textured solid with walls along the axes of the world (x right, y down, z forward; the ground is y = 0).
struct Block {
  Eigen::Vector3d low;
  Eigen::Vector3d high;
};

/// The ray (in the camera frame, z = 1) of each pixel of the camera's image, row by row, through its lens.
std::vector<Eigen::Vector3d> PixelRays(const CameraModel& camera);

/// Streets between blocks, drawn by casting a ray through each pixel. Same input, same image.
class StreetWorld {
 public:
  explicit StreetWorld(std::vector<Block> blocks);

  /// 8-bit gray image without noise. `rays` are the camera's, from PixelRays.
  cv::Mat Render(const CameraModel& camera, const std::vector<Eigen::Vector3d>& rays,
                 const RigidTransform& world_from_camera) const;
  /// The same of a rolling shutter: each row has a pose.
  cv::Mat Render(const CameraModel& camera, const std::vector<Eigen::Vector3d>& rays,
                 const std::vector<RigidTransform>& world_from_camera) const;

 private:
  struct Hit {
    double distance = 0;  ///< in lengths of the ray; infinite for the sky
    int surface = 0;      ///< which wall, for its own piece of texture
    int axis = 0;         ///< the wall's normal
  };

  Hit Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) const;
  float Gray(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray, double pixel_angle) const;
  float Texel(float u, float v, float footprint) const;

  std::vector<Block> blocks_;
  std::vector<cv::Mat> texture_;  ///< halved from level to level, so that distance does not alias
};

}  // namespace turnscale

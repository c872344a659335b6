// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>

namespace turnscale {

/// The ideal camera: all pixels behind the camera model are in its (undistorted) image, pixel centres at integers.
struct Pinhole {
  double fx = 1;  ///< focal length, pixels
  double fy = 1;  ///< focal length, pixels
  double cx = 0;  ///< principal point, pixels
  double cy = 0;  ///< principal point, pixels

  /// Pixel of a point with z > 0 in the camera frame.
  Eigen::Vector2d Project(const Eigen::Vector3d& x_in_camera) const {
    const double inverse_depth = 1.0 / x_in_camera.z();
    return {fx * x_in_camera.x() * inverse_depth + cx, fy * x_in_camera.y() * inverse_depth + cy};
  }

  /// Point at depth 1 (z = 1) on the pixel's ray.
  Eigen::Vector3d Ray(const Eigen::Vector2d& pixel) const {
    return {(pixel.x() - cx) / fx, (pixel.y() - cy) / fy, 1.0};
  }

  bool operator==(const Pinhole&) const = default;
};

}  // namespace turnscale

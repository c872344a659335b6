// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "turnscale/geometry/pinhole.h"

namespace turnscale {

enum class LensModel {
  kPinhole,           ///< no distortion
  kRadialTangential,  ///< k1 k2 p1 p2 k3 (OpenCV's and Kalibr's radtan)
  kEquidistant,       ///< fisheye k1 k2 k3 k4 (Kannala-Brandt; OpenCV's fisheye, Kalibr's equidistant)
};

/// A calibrated camera: intrinsics, lens model and image size. Pixel centres are at integer coordinates.
struct CameraModel {
  Pinhole pinhole;
  LensModel lens = LensModel::kPinhole;
  std::array<double, 5> distortion = {0, 0, 0, 0, 0};  ///< in the lens model's order, zero-filled
  int width = 0;                                       ///< pixels; 0 if not in the camera file
  int height = 0;                                      ///< pixels; 0 if not in the camera file

  /// Residual radial distortion of the calibration (radial_correction.h), estimated by the odometry:
  /// undistorted pixels are corrected by it.
  double radial_correction = 0;

  /// Distorted pixel of a point in the camera frame; nothing where the lens cannot see it.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& x_in_camera) const;

  /// The pixel that the ideal pinhole camera (same intrinsics) would show; nothing where the ray is not in front of
  /// the image plane or the model cannot be inverted.
  std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& pixel) const;

  bool operator==(const CameraModel&) const = default;
};

}  // namespace turnscale

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

/// Where the rows of an image follow one another as its sensor has read them: a step along x or y of the image. Down,
/// unless the image was rotated or mirrored since.
struct ReadDirection {
  int x = 0;
  int y = 1;

  bool operator==(const ReadDirection&) const = default;
};

/// The one along the columns where `direction` is along the rows' order: to the right, or down.
inline ReadDirection Across(const ReadDirection& direction) {
  return direction.x == 0 ? ReadDirection{1, 0} : ReadDirection{0, 1};
}

/// A calibrated camera: intrinsics, lens model and image size. Pixel centres are at integer coordinates.
struct CameraModel {
  Pinhole pinhole;
  LensModel lens = LensModel::kPinhole;
  std::array<double, 5> distortion = {0, 0, 0, 0, 0};  ///< in the lens model's order, zero-filled
  int width = 0;                                       ///< pixels; 0 if not in the camera file
  int height = 0;                                      ///< pixels; 0 if not in the camera file

  /// Residual radial distortion of the calibration, estimated by the odometry: undistorted pixels are corrected by it
  /// (CorrectRadially).
  double radial_correction = 0;

  /// Standard deviation of the focal length, pixels; 0 if the camera file does not state it. Of both axes together.
  double focal_sigma = 0;
  /// Standard deviation of fy / fx, relative; 0 if the camera file does not state it.
  double aspect_sigma = 0;

  /// Of the images: the camera file's if it states one.
  ReadDirection read_direction = {};
  bool is_read_direction_stated = false;  ///< by the camera file

  /// Readout time of a rolling shutter from the first row of the image as it was stored to the last one, along
  /// `read_direction`, seconds; below 0 if it begins with the last one, 0 of a global shutter. The time of an image is
  /// that of its middle row. Project and Undistort are of one instant.
  double readout = 0;
  /// Standard deviation of it, seconds. 0 if it is exact; where the readout is 0 too, it is not known.
  double readout_sigma = 0;
  bool is_readout_known() const { return readout != 0 || readout_sigma != 0; }

  /// Distorted pixel of a point in the camera frame; nothing where the lens cannot see it.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& x_in_camera) const;
  /// The same of a point in front of the image plane; nothing of others, even if the lens is wide enough to see them.
  std::optional<Eigen::Vector2d> ProjectInFront(const Eigen::Vector3d& x_in_camera) const {
    return x_in_camera.z() > 0 ? Project(x_in_camera) : std::nullopt;
  }

  /// The pixel that the ideal pinhole camera (same intrinsics) would show; nothing where the ray is not in front of
  /// the image plane or the model cannot be inverted.
  std::optional<Eigen::Vector2d> Undistort(const Eigen::Vector2d& pixel) const;

  bool operator==(const CameraModel&) const = default;
};

/// Where the lens shows a point of the plane z = 1, and the derivative of that by the point.
struct DistortedPoint {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

/// OpenCV's and Kalibr's model with k = k1 k2 p1 p2 k3.
DistortedPoint DistortRadialTangential(const std::array<double, 5>& k, const Eigen::Vector2d& point);

/// Inverse of the lens on the plane z = 1, where the camera's calibration has it: what a distorted point is without
/// distortion, and the derivative of that by the distorted point. Nothing where no ray leads there.
struct UndistortedPoint {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};
std::optional<UndistortedPoint> UndistortPoint(const CameraModel& camera, const Eigen::Vector2d& distorted);

/// Angle that the equidistant fisheye with k = k1 k2 k3 k4 makes of the angle to the optical axis (radians).
double DistortAngle(const std::array<double, 5>& k, double theta);

/// Inverse of DistortRadialTangential. Nothing beyond the radius at which the model folds back over itself.
std::optional<Eigen::Vector2d> UndistortRadialTangential(const std::array<double, 5>& k,
                                                         const Eigen::Vector2d& distorted);

/// Inverse of DistortAngle for angles in [0, pi]; nothing where no angle below the model's fold gives `distorted`.
std::optional<double> UndistortAngle(const std::array<double, 5>& k, double distorted);

/// Whether the radial part of the model still rises from the image centre up to this radius (plane z = 1): only there
/// does a pixel belong to one ray.
bool RadialRisesUpTo(const std::array<double, 5>& k, double radius);

/// Likewise for the equidistant fisheye up to this angle (radians).
bool AngleRisesUpTo(const std::array<double, 5>& k, double theta);

/// Moves a pixel away from the principal point (towards it where `correction` < 0) by the share correction * r^2, r
/// being its distance from the principal point in focal lengths: what a calibration has left of the lens's distortion.
Eigen::Vector2d CorrectRadially(const Pinhole& pinhole, double correction, const Eigen::Vector2d& pixel);

/// The pixel that CorrectRadially moves to this one. Exact to rounding for corrections of a few per cent. A negative
/// correction moves no pixel beyond (2/3) / sqrt(3 |correction|) focal lengths: what is asked for there has no meaning.
Eigen::Vector2d UndoRadialCorrection(const Pinhole& pinhole, double correction, const Eigen::Vector2d& pixel);

/// A pixel that was corrected by `from`, corrected by `to` instead.
Eigen::Vector2d ChangeRadialCorrection(const Pinhole& pinhole, double from, double to, const Eigen::Vector2d& pixel);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/camera/camera_model.h"

#include <cmath>
#include <numbers>

#include "turnscale/camera/lens.h"
#include "turnscale/camera/radial_correction.h"

namespace turnscale {
namespace {

Eigen::Vector2d PixelOf(const Pinhole& pinhole, const Eigen::Vector2d& point) {
  return {pinhole.fx * point.x() + pinhole.cx, pinhole.fy * point.y() + pinhole.cy};
}

// The point that the fisheye shows of the direction (x, y, z), as seen on the plane z = 1.
std::optional<Eigen::Vector2d> Fisheye(const std::array<double, 5>& k, const Eigen::Vector3d& x_in_camera) {
  const double across = x_in_camera.head<2>().norm();
  const double theta = std::atan2(across, x_in_camera.z());
  if (across == 0) return theta == 0 ? std::optional<Eigen::Vector2d>(Eigen::Vector2d::Zero()) : std::nullopt;
  if (!AngleRisesUpTo(k, theta)) return std::nullopt;
  return x_in_camera.head<2>() * (DistortAngle(k, theta) / across);
}

std::optional<Eigen::Vector2d> UndistortFisheye(const std::array<double, 5>& k, const Eigen::Vector2d& distorted) {
  const double angle = distorted.norm();
  if (angle == 0) return distorted;
  const std::optional<double> theta = UndistortAngle(k, angle);
  if (!theta || *theta >= std::numbers::pi / 2) return std::nullopt;
  return distorted * (std::tan(*theta) / angle);
}

// What the calibration file alone says.
std::optional<Eigen::Vector2d> ProjectCalibrated(const CameraModel& camera, const Eigen::Vector3d& x_in_camera) {
  if (camera.lens == LensModel::kEquidistant) {
    const std::optional<Eigen::Vector2d> shown = Fisheye(camera.distortion, x_in_camera);
    return shown ? std::optional(PixelOf(camera.pinhole, *shown)) : std::nullopt;
  }
  if (!(x_in_camera.z() > 0)) return std::nullopt;
  if (camera.lens == LensModel::kPinhole) return camera.pinhole.Project(x_in_camera);
  const Eigen::Vector2d point = x_in_camera.head<2>() / x_in_camera.z();
  if (!RadialRisesUpTo(camera.distortion, point.norm())) return std::nullopt;
  return PixelOf(camera.pinhole, DistortRadialTangential(camera.distortion, point).point);
}

std::optional<Eigen::Vector2d> UndistortCalibrated(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  if (!pixel.allFinite()) return std::nullopt;
  if (camera.lens == LensModel::kPinhole) return pixel;
  const Eigen::Vector2d shown = camera.pinhole.Ray(pixel).head<2>();
  const std::optional<Eigen::Vector2d> point = camera.lens == LensModel::kEquidistant
                                                   ? UndistortFisheye(camera.distortion, shown)
                                                   : UndistortRadialTangential(camera.distortion, shown);
  return point ? std::optional(PixelOf(camera.pinhole, *point)) : std::nullopt;
}

}  // namespace

std::optional<Eigen::Vector2d> CameraModel::Project(const Eigen::Vector3d& x_in_camera) const {
  if (radial_correction == 0 || !(x_in_camera.z() > 0)) return ProjectCalibrated(*this, x_in_camera);
  const Eigen::Vector2d ideal = UndoRadialCorrection(pinhole, radial_correction, pinhole.Project(x_in_camera));
  return ProjectCalibrated(*this, pinhole.Ray(ideal));
}

std::optional<Eigen::Vector2d> CameraModel::Undistort(const Eigen::Vector2d& pixel) const {
  const std::optional<Eigen::Vector2d> ideal = UndistortCalibrated(*this, pixel);
  return ideal && radial_correction != 0 ? std::optional(CorrectRadially(pinhole, radial_correction, *ideal)) : ideal;
}

}  // namespace turnscale

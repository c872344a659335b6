// SPDX-License-Identifier: MIT
#include "turnscale/camera/camera_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace turnscale {
namespace {

constexpr int kMaxNewtonSteps = 50;
// On the plane z = 1: far below 1e-9 pixels for any real focal length.
constexpr double kConverged = 1e-13;

// A slope that is far above its rounding errors.
constexpr double kClearSlope = 1e-9;

// d/dr of r (1 + a0 r^2 + a1 r^4 + a2 r^6 + a3 r^8), looked at in steps fine enough for lens polynomials.
bool RisesUpTo(const std::array<double, 4>& a, double r) {
  // Least where only what falls counts: above rounding, no step can find a fall. So it is for nearly every pixel.
  const double end = r * r;
  const auto falling = [](double coefficient) { return std::min(coefficient, 0.0); };
  const double least =
      1 + end * (3 * falling(a[0]) + end * (5 * falling(a[1]) + end * (7 * falling(a[2]) + end * 9 * falling(a[3]))));
  if (least > kClearSlope) return true;
  constexpr int kSteps = 32;
  for (int i = 1; i <= kSteps; ++i) {
    const double u = r * r * i / kSteps;
    if (!(1 + u * (3 * a[0] + u * (5 * a[1] + u * (7 * a[2] + u * 9 * a[3]))) > 0)) return false;
  }
  return true;
}

double AngleSlope(const std::array<double, 5>& k, double theta) {
  const double u = theta * theta;
  return 1 + u * (3 * k[0] + u * (5 * k[1] + u * (7 * k[2] + u * 9 * k[3])));
}

// Whether radius (1 + correction radius^2) reaches so far: where the correction is negative, it falls beyond a maximum.
bool CorrectionReaches(double correction, double corrected_radius) {
  return !(-27 * correction * corrected_radius * corrected_radius > 4);
}

constexpr int kNewtonSteps = 8;
constexpr double kSmallChange = 0.05;  // of a radius, relative

Eigen::Vector2d Scaled(const Pinhole& pinhole, const Eigen::Vector2d& pixel, double share) {
  const Eigen::Vector2d centre(pinhole.cx, pinhole.cy);
  return centre + (1 + share) * (pixel - centre);
}

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

// Of the calibration file alone.
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

// Inverse of the lens on the plane z = 1; nothing where no ray leads there.
std::optional<Eigen::Vector2d> UndistortOnPlane(const CameraModel& camera, const Eigen::Vector2d& distorted) {
  switch (camera.lens) {
    case LensModel::kPinhole:
      return distorted;
    case LensModel::kRadialTangential:
      return UndistortRadialTangential(camera.distortion, distorted);
    case LensModel::kEquidistant:
      return UndistortFisheye(camera.distortion, distorted);
  }
  return std::nullopt;
}

// Derivative of UndistortOnPlane, which gives `point`, by the distorted point.
Eigen::Matrix2d UndistortionJacobian(const CameraModel& camera, const Eigen::Vector2d& distorted,
                                     const Eigen::Vector2d& point) {
  if (camera.lens == LensModel::kRadialTangential)
    return DistortRadialTangential(camera.distortion, point).jacobian.inverse();
  const double shown = distorted.norm();
  if (camera.lens == LensModel::kPinhole || shown == 0) return Eigen::Matrix2d::Identity();
  const double radius = point.norm();
  const Eigen::Vector2d outward = distorted / shown;
  const double along = (1 + radius * radius) / AngleSlope(camera.distortion, std::atan(radius));
  const double across = radius / shown;
  return across * Eigen::Matrix2d::Identity() + (along - across) * outward * outward.transpose();
}

std::optional<Eigen::Vector2d> UndistortCalibrated(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  if (!pixel.allFinite()) return std::nullopt;
  // Not by way of the plane, which would round.
  if (camera.lens == LensModel::kPinhole) return pixel;
  const std::optional<Eigen::Vector2d> point = UndistortOnPlane(camera, camera.pinhole.Ray(pixel).head<2>());
  return point ? std::optional(PixelOf(camera.pinhole, *point)) : std::nullopt;
}

}  // namespace

DistortedPoint DistortRadialTangential(const std::array<double, 5>& k, const Eigen::Vector2d& point) {
  const auto [k1, k2, p1, p2, k3] = k;
  const double x = point.x();
  const double y = point.y();
  const double r2 = x * x + y * y;
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = k1 + r2 * (2 * k2 + r2 * 3 * k3);  // d radial / d r2
  DistortedPoint distorted;
  distorted.point = {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                     y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  const double mixed = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  distorted.jacobian << radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x, mixed,  //
      mixed, radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  return distorted;
}

double DistortAngle(const std::array<double, 5>& k, double theta) {
  const double u = theta * theta;
  return theta * (1 + u * (k[0] + u * (k[1] + u * (k[2] + u * k[3]))));
}

std::optional<Eigen::Vector2d> UndistortRadialTangential(const std::array<double, 5>& k,
                                                         const Eigen::Vector2d& distorted) {
  Eigen::Vector2d point = distorted;
  DistortedPoint shown = DistortRadialTangential(k, point);
  Eigen::Vector2d error = shown.point - distorted;
  for (int i = 0; i < kMaxNewtonSteps && error.norm() > 0; ++i) {
    Eigen::Vector2d step = shown.jacobian.inverse() * error;
    if (!step.allFinite()) return std::nullopt;
    // Halved until it helps: near the fold the full step leaps to the far side. One that rounds to none never helps.
    DistortedPoint next = DistortRadialTangential(k, point - step);
    for (int half = 0; half < 10 && (next.point - distorted).norm() >= error.norm() && point - step != point; ++half) {
      step *= 0.5;
      next = DistortRadialTangential(k, point - step);
    }
    if ((next.point - distorted).norm() >= error.norm()) break;
    point -= step;
    shown = next;
    error = shown.point - distorted;
  }
  if (!(error.norm() < kConverged * (1 + distorted.norm()))) return std::nullopt;
  if (shown.jacobian.determinant() <= 0 || !RadialRisesUpTo(k, point.norm())) return std::nullopt;
  return point;
}

std::optional<UndistortedPoint> UndistortPoint(const CameraModel& camera, const Eigen::Vector2d& distorted) {
  const std::optional<Eigen::Vector2d> point = UndistortOnPlane(camera, distorted);
  if (!point) return std::nullopt;
  return UndistortedPoint{*point, UndistortionJacobian(camera, distorted, *point)};
}

std::optional<double> UndistortAngle(const std::array<double, 5>& k, double distorted) {
  double theta = std::min(distorted, std::numbers::pi);
  double error = DistortAngle(k, theta) - distorted;
  for (int i = 0; i < kMaxNewtonSteps && error != 0; ++i) {
    double step = error / AngleSlope(k, theta);
    if (!std::isfinite(step)) return std::nullopt;
    const auto error_after = [&] { return std::abs(DistortAngle(k, theta - step) - distorted); };
    for (int half = 0; half < 10 && error_after() >= std::abs(error) && theta - step != theta; ++half) step *= 0.5;
    if (error_after() >= std::abs(error)) break;
    theta -= step;
    error = DistortAngle(k, theta) - distorted;
  }
  if (!(std::abs(error) < kConverged) || theta < 0 || theta > std::numbers::pi) return std::nullopt;
  return AngleRisesUpTo(k, theta) ? std::optional(theta) : std::nullopt;
}

bool RadialRisesUpTo(const std::array<double, 5>& k, double radius) { return RisesUpTo({k[0], k[1], k[4], 0}, radius); }

bool AngleRisesUpTo(const std::array<double, 5>& k, double theta) { return RisesUpTo({k[0], k[1], k[2], k[3]}, theta); }

Eigen::Vector2d CorrectRadially(const Pinhole& pinhole, double correction, const Eigen::Vector2d& pixel) {
  return Scaled(pinhole, pixel, correction * pinhole.Ray(pixel).head<2>().squaredNorm());
}

Eigen::Vector2d UndoRadialCorrection(const Pinhole& pinhole, double correction, const Eigen::Vector2d& pixel) {
  // Newton on radius (1 + correction radius^2) = corrected radius.
  const double corrected = pinhole.Ray(pixel).head<2>().norm();
  if (correction == 0 || corrected == 0) return pixel;
  // The series of the inverse is close where the correction is small.
  const double change = correction * corrected * corrected;
  double radius = std::abs(change) < kSmallChange ? corrected * (1 - change * (1 - 3 * change)) : corrected;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const double error = radius * (1 + correction * radius * radius) - corrected;
    const double step_back = error / (1 + 3 * correction * radius * radius);
    if (radius - step_back == radius) break;
    radius -= step_back;
  }
  return Scaled(pinhole, pixel, radius / corrected - 1);
}

Eigen::Vector2d ChangeRadialCorrection(const Pinhole& pinhole, double from, double to, const Eigen::Vector2d& pixel) {
  return CorrectRadially(pinhole, to, UndoRadialCorrection(pinhole, from, pixel));
}

std::optional<Eigen::Vector2d> CameraModel::Project(const Eigen::Vector3d& x_in_camera) const {
  if (radial_correction == 0 || !(x_in_camera.z() > 0)) return ProjectCalibrated(*this, x_in_camera);
  if (!CorrectionReaches(radial_correction, x_in_camera.head<2>().norm() / x_in_camera.z())) return std::nullopt;
  const Eigen::Vector2d ideal = UndoRadialCorrection(pinhole, radial_correction, pinhole.Project(x_in_camera));
  return ProjectCalibrated(*this, pinhole.Ray(ideal));
}

std::optional<Eigen::Vector2d> CameraModel::Undistort(const Eigen::Vector2d& pixel) const {
  const std::optional<Eigen::Vector2d> ideal = UndistortCalibrated(*this, pixel);
  return ideal && radial_correction != 0 ? std::optional(CorrectRadially(pinhole, radial_correction, *ideal)) : ideal;
}

}  // namespace turnscale

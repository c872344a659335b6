// SPDX-License-Identifier: MIT
#include "turnscale/camera/lens.h"

#include <cmath>
#include <numbers>

#include <Eigen/LU>

namespace turnscale {
namespace {

constexpr int kMaxNewtonSteps = 50;
// On the plane z = 1: far below 1e-9 pixels for any real focal length.
constexpr double kConverged = 1e-13;

// d/dr of r (1 + a0 r^2 + a1 r^4 + a2 r^6 + a3 r^8), looked at in steps fine enough for lens polynomials.
bool RisesUpTo(const std::array<double, 4>& a, double r) {
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
    // Halved until it helps: near the fold the full step leaps to the far side.
    DistortedPoint next = DistortRadialTangential(k, point - step);
    for (int half = 0; half < 10 && (next.point - distorted).norm() >= error.norm(); ++half) {
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

std::optional<double> UndistortAngle(const std::array<double, 5>& k, double distorted) {
  double theta = std::min(distorted, std::numbers::pi);
  double error = DistortAngle(k, theta) - distorted;
  for (int i = 0; i < kMaxNewtonSteps && error != 0; ++i) {
    double step = error / AngleSlope(k, theta);
    if (!std::isfinite(step)) return std::nullopt;
    const auto error_after = [&] { return std::abs(DistortAngle(k, theta - step) - distorted); };
    for (int half = 0; half < 10 && error_after() >= std::abs(error); ++half) step *= 0.5;
    if (error_after() >= std::abs(error)) break;
    theta -= step;
    error = DistortAngle(k, theta) - distorted;
  }
  if (!(std::abs(error) < kConverged) || theta < 0 || theta > std::numbers::pi) return std::nullopt;
  return AngleRisesUpTo(k, theta) ? std::optional(theta) : std::nullopt;
}

bool RadialRisesUpTo(const std::array<double, 5>& k, double radius) { return RisesUpTo({k[0], k[1], k[4], 0}, radius); }

bool AngleRisesUpTo(const std::array<double, 5>& k, double theta) { return RisesUpTo({k[0], k[1], k[2], k[3]}, theta); }

}  // namespace turnscale

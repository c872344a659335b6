// SPDX-License-Identifier: MIT
#include "turnscale/camera/radial_correction.h"

namespace turnscale {
namespace {

constexpr int kNewtonSteps = 8;

Eigen::Vector2d Scaled(const Pinhole& pinhole, const Eigen::Vector2d& pixel, double share) {
  const Eigen::Vector2d centre(pinhole.cx, pinhole.cy);
  return centre + (1 + share) * (pixel - centre);
}

}  // namespace

Eigen::Vector2d CorrectRadially(const Pinhole& pinhole, double correction, const Eigen::Vector2d& pixel) {
  return Scaled(pinhole, pixel, correction * pinhole.Ray(pixel).head<2>().squaredNorm());
}

Eigen::Vector2d UndoRadialCorrection(const Pinhole& pinhole, double correction, const Eigen::Vector2d& pixel) {
  // Newton on radius (1 + correction radius^2) = corrected radius.
  const double corrected = pinhole.Ray(pixel).head<2>().norm();
  if (correction == 0 || corrected == 0) return pixel;
  double radius = corrected;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const double error = radius * (1 + correction * radius * radius) - corrected;
    radius -= error / (1 + 3 * correction * radius * radius);
  }
  return Scaled(pinhole, pixel, radius / corrected - 1);
}

}  // namespace turnscale

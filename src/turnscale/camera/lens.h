// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

namespace turnscale {

/// Where the lens shows a point of the plane z = 1, and the derivative of that by the point.
struct DistortedPoint {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

/// OpenCV's and Kalibr's model with k = k1 k2 p1 p2 k3.
DistortedPoint DistortRadialTangential(const std::array<double, 5>& k, const Eigen::Vector2d& point);

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

}  // namespace turnscale

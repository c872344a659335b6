// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace turnscale {

/// A step as the refinement sees it: how the camera turned, and which way it went.
struct StepMeasurement {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< previous_from_current
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();          ///< unit vector in the previous camera frame
  double length = 0;                                             ///< camera's travel, in the odometry's unit
  int frames = 1;                                                ///< of which this is the mean
};

/// theta, where the camera goes in A (23), from the turning angle and the lever arm in units of the camera's travel:
/// theta = psi/2 + asin(2 lever_ratio sin(psi/2)). The same as (23), with the camera's travel s for the rear axle's:
/// rho^2 = s^2 - 4 L^2 sin^2(psi/2).
double TravelDirection(double psi, double lever_ratio);

/// Residuals of a step in vehicle axes, and their derivatives.
struct StepResidual {
  using Vector = Eigen::Matrix<double, 6, 1>;
  /// First three: sqrt(8) times the vector part of the quaternion of Q R^ Q^T R(psi)^T, whose square is the Frobenius
  /// norm of (15). Last three: Q u^ - t/|t|, which has the minimiser of (15)'s second part but not its flat bottom.
  Vector value;
  Eigen::Matrix<double, 6, 3> by_rotation;  ///< by a small rotation vector d in vehicle axes: Q becomes exp(d) Q
  Vector by_psi;
  Vector by_ratio;
};

/// Throws nothing; |2 lever_ratio sin(psi/2)| above 0.95 is taken as that, with derivative 0.
StepResidual EvaluateStep(const StepMeasurement& step, const Eigen::Quaterniond& vehicle_from_camera, double psi,
                          double lever_ratio);

}  // namespace turnscale

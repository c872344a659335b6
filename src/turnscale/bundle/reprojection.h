// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "turnscale/geometry/pinhole.h"

namespace turnscale {

/// True where a point in the camera frame projects to a meaningful pixel. The bound is a direction (about 89.94 degrees
/// off the axis), not a depth, so that it does not depend on the unit of length.
inline bool IsInFront(const Eigen::Vector3d& x_in_camera) {
  return x_in_camera.z() > 1e-3 * (std::abs(x_in_camera.x()) + std::abs(x_in_camera.y()));
}

/// Derivative of a point's pixel by the point in the camera frame. The point is in front of the camera.
inline Eigen::Matrix<double, 2, 3> ProjectionJacobian(const Pinhole& pinhole, const Eigen::Vector3d& x) {
  Eigen::Matrix<double, 2, 3> by_x;
  by_x << pinhole.fx / x.z(), 0, -pinhole.fx * x.x() / (x.z() * x.z()),  //
      0, pinhole.fy / x.z(), -pinhole.fy * x.y() / (x.z() * x.z());
  return by_x;
}

/// Reprojection error (24) over sigma. The point is in front of the camera.
inline Eigen::Vector2d ReprojectionResidual(const Pinhole& pinhole, const Eigen::Vector3d& x_in_camera,
                                            const Eigen::Vector2d& pixel, double inverse_sigma) {
  return inverse_sigma * (pinhole.Project(x_in_camera) - pixel);
}

/// Huber's loss of a residual of the given squared length; quadratic where threshold is 0.
inline double HuberCost(double squared_norm, double threshold) {
  if (threshold <= 0 || squared_norm <= threshold * threshold) return 0.5 * squared_norm;
  return threshold * (std::sqrt(squared_norm) - 0.5 * threshold);
}

/// Second-order model of one observation's cost. With kDof = 6 the variables are (phi, delta), with kDof = 3 delta
/// alone: x_in_camera = Exp(phi) R (X - c + delta). A step of the point adds to delta, a step of the centre takes from
/// it, so the same numbers serve the camera and the point.
template <int kDof>
struct ObservationModel {
  Eigen::Matrix<double, kDof, kDof> hessian;
  Eigen::Matrix<double, kDof, 1> gradient;
};

/// Gauss-Newton model with Huber's weight min(1, threshold / |r|); returns the cost. The point is in front.
template <int kDof>
double GaussNewtonModel(const Pinhole& pinhole, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& x_in_camera,
                        const Eigen::Vector2d& pixel, double inverse_sigma, double huber_threshold,
                        ObservationModel<kDof>& model);

/// The same in camera axes: of a step of x_in_camera alone.
struct CameraAxesModel {
  Eigen::Matrix3d newton;        ///< exact; may be indefinite
  Eigen::Matrix3d gauss_newton;  ///< with Huber's weight
  Eigen::Vector3d gradient;
  double cost = 0;
};

CameraAxesModel ModelInCameraAxes(const Pinhole& pinhole, const Eigen::Vector3d& x_in_camera,
                                  const Eigen::Vector2d& pixel, double inverse_sigma, double huber_threshold);

/// What the exact model in camera axes is in the variables of the adjustment.
template <int kDof>
void ExpandNewton(const CameraAxesModel& axes, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& x_in_camera,
                  ObservationModel<kDof>& model);

/// The cost's exact second derivatives: Gauss-Newton plus the curvature of the projection and of the loss. The Hessian
/// may be indefinite.
template <int kDof>
double NewtonModel(const Pinhole& pinhole, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& x_in_camera,
                   const Eigen::Vector2d& pixel, double inverse_sigma, double huber_threshold,
                   ObservationModel<kDof>& model);

}  // namespace turnscale

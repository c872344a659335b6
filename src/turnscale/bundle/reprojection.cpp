// SPDX-License-Identifier: MIT
#include "turnscale/bundle/reprojection.h"

#include "turnscale/geometry/rotation.h"

namespace turnscale {

template <int kDof>
double GaussNewtonModel(const Pinhole& pinhole, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& x_in_camera,
                        const Eigen::Vector2d& pixel, double inverse_sigma, double huber_threshold,
                        ObservationModel<kDof>& model) {
  const double x = x_in_camera.x();
  const double y = x_in_camera.y();
  const double z = x_in_camera.z();
  const double inverse_depth = 1.0 / z;
  const double u = x * inverse_depth;
  const double v = y * inverse_depth;
  double r0 = inverse_sigma * (pinhole.fx * u + pinhole.cx - pixel.x());
  double r1 = inverse_sigma * (pinhole.fy * v + pinhole.cy - pixel.y());

  double cost = r0 * r0 + r1 * r1;
  double scale = inverse_sigma * inverse_depth;
  if (huber_threshold > 0 && cost > huber_threshold * huber_threshold) {
    const double norm = std::sqrt(cost);
    const double root_weight = std::sqrt(huber_threshold / norm);
    cost = huber_threshold * (norm - 0.5 * huber_threshold);
    r0 *= root_weight;
    r1 *= root_weight;
    scale *= root_weight;
  } else {
    cost *= 0.5;
  }

  const double a = scale * pinhole.fx;
  const double b = scale * pinhole.fy;
  Eigen::Matrix<double, kDof, 1> J0;
  Eigen::Matrix<double, kDof, 1> J1;
  if constexpr (kDof == 6) {
    // -d(pixel)/dx [x]_x, written out: a rotation by phi moves x by phi cross x.
    J0.template head<3>() << -a * u * y, a * (z + u * x), -a * y;
    J1.template head<3>() << -b * (z + v * y), b * v * x, b * x;
  }
  J0.template tail<3>() = a * (rotation.row(0) - u * rotation.row(2));
  J1.template tail<3>() = b * (rotation.row(1) - v * rotation.row(2));
  model.hessian.noalias() = J0 * J0.transpose();
  model.hessian.noalias() += J1 * J1.transpose();
  model.gradient = J0 * r0 + J1 * r1;
  return cost;
}

template <int kDof>
double NewtonModel(const Pinhole& pinhole, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& x_in_camera,
                   const Eigen::Vector2d& pixel, double inverse_sigma, double huber_threshold,
                   ObservationModel<kDof>& model) {
  const double inverse_depth = 1.0 / x_in_camera.z();
  const double u = x_in_camera.x() * inverse_depth;
  const double v = x_in_camera.y() * inverse_depth;
  const Eigen::Vector2d r = ReprojectionResidual(pinhole, x_in_camera, pixel, inverse_sigma);
  const double squared_norm = r.squaredNorm();

  // In the loss's argument r: gradient weight * r, Hessian weight * (I - outlier r r^T).
  double weight = 1;
  double outlier = 0;
  if (huber_threshold > 0 && squared_norm > huber_threshold * huber_threshold) {
    weight = huber_threshold / std::sqrt(squared_norm);
    outlier = 1.0 / squared_norm;
  }
  const double a = inverse_sigma * pinhole.fx * inverse_depth;
  const double b = inverse_sigma * pinhole.fy * inverse_depth;
  Eigen::Matrix<double, 2, 3> J;
  J << a, 0, -a * u, 0, b, -b * v;
  const Eigen::Vector3d across = J.transpose() * r;
  const Eigen::Vector3d g = weight * across;
  Eigen::Matrix3d K = weight * (J.transpose() * J - outlier * across * across.transpose());
  // weight * sum over r_k times the second derivatives of x/z and y/z; they hold the gradient's own entries.
  K(0, 2) -= g.x() * inverse_depth;
  K(2, 0) -= g.x() * inverse_depth;
  K(1, 2) -= g.y() * inverse_depth;
  K(2, 1) -= g.y() * inverse_depth;
  K(2, 2) += 2.0 * (g.x() * u + g.y() * v) * inverse_depth;

  const Eigen::Matrix3d KR = K * rotation;
  if constexpr (kDof == 6) {
    const Eigen::Matrix3d X = Skew(x_in_camera);
    model.hessian.template topLeftCorner<3, 3>() =
        X * K * X.transpose() + 0.5 * (x_in_camera * g.transpose() + g * x_in_camera.transpose());
    model.hessian.template topRightCorner<3, 3>() = X * KR - Skew(g) * rotation;
    model.hessian.template bottomLeftCorner<3, 3>() = model.hessian.template topRightCorner<3, 3>().transpose();
    model.gradient.template head<3>() = x_in_camera.cross(g);
  }
  model.hessian.template bottomRightCorner<3, 3>() = rotation.transpose() * KR;
  model.gradient.template tail<3>() = rotation.transpose() * g;
  return HuberCost(squared_norm, huber_threshold);
}

template double GaussNewtonModel<3>(const Pinhole&, const Eigen::Matrix3d&, const Eigen::Vector3d&,
                                    const Eigen::Vector2d&, double, double, ObservationModel<3>&);
template double GaussNewtonModel<6>(const Pinhole&, const Eigen::Matrix3d&, const Eigen::Vector3d&,
                                    const Eigen::Vector2d&, double, double, ObservationModel<6>&);
template double NewtonModel<3>(const Pinhole&, const Eigen::Matrix3d&, const Eigen::Vector3d&, const Eigen::Vector2d&,
                               double, double, ObservationModel<3>&);
template double NewtonModel<6>(const Pinhole&, const Eigen::Matrix3d&, const Eigen::Vector3d&, const Eigen::Vector2d&,
                               double, double, ObservationModel<6>&);

}  // namespace turnscale

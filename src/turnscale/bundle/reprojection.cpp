// SPDX-License-Identifier: MIT
#include "turnscale/bundle/reprojection.h"

#include <cmath>

#include <Eigen/Geometry>

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

CameraAxesModel ModelInCameraAxes(const Pinhole& pinhole, const Eigen::Vector3d& x_in_camera,
                                  const Eigen::Vector2d& pixel, double inverse_sigma, double huber_threshold) {
  const double inverse_depth = 1.0 / x_in_camera.z();
  const double u = x_in_camera.x() * inverse_depth;
  const double v = x_in_camera.y() * inverse_depth;
  const Eigen::Vector2d r = ReprojectionResidual(pinhole, x_in_camera, pixel, inverse_sigma);
  const double squared_norm = r.squaredNorm();
  CameraAxesModel model;
  model.cost = HuberCost(squared_norm, huber_threshold);

  // The Jacobian of r is (a, 0, -a u; 0, b, -b v).
  const double a = inverse_sigma * pinhole.fx * inverse_depth;
  const double b = inverse_sigma * pinhole.fy * inverse_depth;
  const double au = a * u;
  const double bv = b * v;
  const Eigen::Vector3d across(a * r.x(), b * r.y(), -au * r.x() - bv * r.y());
  model.gauss_newton << a * a, 0, -au * a,  //
      0, b * b, -bv * b,                    //
      -au * a, -bv * b, au * au + bv * bv;
  model.newton = model.gauss_newton;
  model.gradient = across;
  if (huber_threshold > 0 && squared_norm > huber_threshold * huber_threshold) {
    // In the loss's argument r: gradient weight * r, Hessian weight * (I - r r^T / r^T r).
    const double weight = huber_threshold / std::sqrt(squared_norm);
    model.newton = weight * (model.gauss_newton - (1.0 / squared_norm) * across * across.transpose());
    model.gauss_newton *= weight;
    model.gradient *= weight;
  }
  // weight * sum over r_k times the second derivatives of x/z and y/z; they hold the gradient's own entries.
  const Eigen::Vector3d& g = model.gradient;
  model.newton(0, 2) -= g.x() * inverse_depth;
  model.newton(2, 0) -= g.x() * inverse_depth;
  model.newton(1, 2) -= g.y() * inverse_depth;
  model.newton(2, 1) -= g.y() * inverse_depth;
  model.newton(2, 2) += 2.0 * (g.x() * u + g.y() * v) * inverse_depth;
  return model;
}

template <int kDof>
void ExpandNewton(const CameraAxesModel& axes, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& x_in_camera,
                  ObservationModel<kDof>& model) {
  const Eigen::Vector3d& x = x_in_camera;
  const Eigen::Vector3d& g = axes.gradient;
  const Eigen::Matrix3d turned = axes.newton * rotation;
  if constexpr (kDof == 6) {
    Eigen::Matrix3d crossed;  // [x]_x K
    for (int column = 0; column < 3; ++column) crossed.col(column) = x.cross(axes.newton.col(column));
    for (int row = 0; row < 3; ++row) {
      model.hessian.template block<1, 3>(row, 0) = x.cross(crossed.row(row)).transpose();
    }
    model.hessian.template topLeftCorner<3, 3>() += 0.5 * (x * g.transpose() + g * x.transpose());
    for (int column = 0; column < 3; ++column) {
      model.hessian.template block<3, 1>(0, 3 + column) = x.cross(turned.col(column)) - g.cross(rotation.col(column));
    }
    model.hessian.template bottomLeftCorner<3, 3>() = model.hessian.template topRightCorner<3, 3>().transpose();
    model.gradient.template head<3>() = x.cross(g);
  }
  model.hessian.template bottomRightCorner<3, 3>().noalias() = rotation.transpose() * turned;
  model.gradient.template tail<3>().noalias() = rotation.transpose() * g;
}

template <int kDof>
double NewtonModel(const Pinhole& pinhole, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& x_in_camera,
                   const Eigen::Vector2d& pixel, double inverse_sigma, double huber_threshold,
                   ObservationModel<kDof>& model) {
  const CameraAxesModel axes = ModelInCameraAxes(pinhole, x_in_camera, pixel, inverse_sigma, huber_threshold);
  ExpandNewton(axes, rotation, x_in_camera, model);
  return axes.cost;
}

template void ExpandNewton<3>(const CameraAxesModel&, const Eigen::Matrix3d&, const Eigen::Vector3d&,
                              ObservationModel<3>&);
template void ExpandNewton<6>(const CameraAxesModel&, const Eigen::Matrix3d&, const Eigen::Vector3d&,
                              ObservationModel<6>&);
template double GaussNewtonModel<3>(const Pinhole&, const Eigen::Matrix3d&, const Eigen::Vector3d&,
                                    const Eigen::Vector2d&, double, double, ObservationModel<3>&);
template double GaussNewtonModel<6>(const Pinhole&, const Eigen::Matrix3d&, const Eigen::Vector3d&,
                                    const Eigen::Vector2d&, double, double, ObservationModel<6>&);
template double NewtonModel<3>(const Pinhole&, const Eigen::Matrix3d&, const Eigen::Vector3d&, const Eigen::Vector2d&,
                               double, double, ObservationModel<3>&);
template double NewtonModel<6>(const Pinhole&, const Eigen::Matrix3d&, const Eigen::Vector3d&, const Eigen::Vector2d&,
                               double, double, ObservationModel<6>&);

}  // namespace turnscale

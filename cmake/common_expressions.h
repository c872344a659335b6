// SPDX-License-Identifier: MIT
// Only for the precompiled headers: expressions that most sources use (by Clang's -ftime-trace), so that Clang
// instantiates their templates once. Nothing calls these functions.
#pragma once

#include <Eigen/Dense>

namespace turnscale::precompiled {

template <typename Vector>
double OfVectors(Vector a, const Vector& b) {
  Vector sum = Vector::Zero();
  sum += 2.0 * a + b * 0.5;
  sum -= (a - b) / 3.0;
  sum.setZero();
  sum = -a + Vector::Ones() + Vector::Constant(a[0]) + Vector::Unit(1) + a.normalized();
  sum = a.cwiseProduct(b) + a.cwiseAbs();
  if (a == b || !sum.allFinite()) return (a - b).norm();
  return a.dot(b) + a.norm() + a.squaredNorm() + (a - b).squaredNorm() + (a + b).norm() + a.maxCoeff() + a.sum();
}

template <typename Matrix, typename Vector>
Vector OfMatrices(const Matrix& a, const Matrix& b, const Vector& x) {
  Matrix product = a * b;
  product += a.transpose() * b + a * b.transpose();
  product *= 2.0;
  product = Matrix::Identity() - product + Matrix::Zero() + x * x.transpose();
  product.setZero();
  product(0, 0) = a.norm() + a.trace() + (a - b).norm();
  Vector y = product * x + a.transpose() * x;
  y += a.col(0) + b.row(0).transpose() + a.diagonal();
  y -= product * (a * x);
  return product * y;
}

inline Eigen::Vector3d OfRotations(const Eigen::Quaterniond& q, const Eigen::Vector3d& x) {
  Eigen::Quaterniond p = q * q.conjugate() * Eigen::Quaterniond::Identity() *
                         Eigen::Quaterniond(Eigen::AngleAxisd(x.norm(), Eigen::Vector3d::UnitY()));
  p = p.normalized();
  p.normalize();
  const Eigen::Matrix3d matrix = p.toRotationMatrix();
  const Eigen::AngleAxisd turn(p);
  return p * x + q.conjugate() * (x - matrix * x) + x.cross(p.vec()) + turn.angle() * turn.axis() +
         p.angularDistance(q) * Eigen::Vector3d(x.head<2>().homogeneous());
}

inline Eigen::Vector3d OfAll(const Eigen::Matrix3d& m, const Eigen::Matrix2d& n, const Eigen::Quaterniond& q) {
  const Eigen::Vector2d x = n.col(0);
  const Eigen::Vector3d y = m.col(0);
  const double sum = OfVectors<Eigen::Vector2d>(x, x) + OfVectors<Eigen::Vector3d>(y, y);
  return sum * OfMatrices(m, m, y) + OfRotations(q, y) + OfMatrices(n, n, x).homogeneous();
}

}  // namespace turnscale::precompiled

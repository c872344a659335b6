// SPDX-License-Identifier: MIT
#include "turnscale/mapping/intrinsics_change.h"

#include <cmath>

#include <Eigen/Geometry>

namespace turnscale {

Pinhole ChangedPinhole(const Pinhole& given, const IntrinsicsChange::Vector& change) {
  const double ratio = std::exp(change[IntrinsicsChange::kLogFocal]);
  return {ratio * given.fx, ratio * std::exp(change[IntrinsicsChange::kLogAspect]) * given.fy,
          given.cx + change[IntrinsicsChange::kCentreX], given.cy + change[IntrinsicsChange::kCentreY]};
}

std::optional<CorrectedPixel> Correct(const CameraModel& camera, const IntrinsicsChange::Vector& change,
                                      const Eigen::Vector2d& distorted) {
  const Pinhole pinhole = ChangedPinhole(camera.pinhole, change);
  const Eigen::Vector2d point = pinhole.Ray(distorted).head<2>();
  const std::optional<UndistortedPoint> ideal = UndistortPoint(camera, point);
  if (!ideal) return std::nullopt;
  const double square = point.squaredNorm();
  const auto terms = change.segment<IntrinsicsChange::kCorrectionTerms>(IntrinsicsChange::kCorrection);
  const double share = square * (terms[0] + square * (terms[1] + square * terms[2]));
  const double share_by_square = terms[0] + square * (2 * terms[1] + square * 3 * terms[2]);
  const Eigen::RowVector2d share_by_point = 2 * share_by_square * point.transpose();
  const Eigen::Vector2d ray = (1 + share) * ideal->point;
  return CorrectedPixel{pinhole.Project(ray.homogeneous()), ideal->point,
                        (1 + share) * ideal->jacobian + ideal->point * share_by_point};
}

Eigen::Matrix<double, 2, IntrinsicsChange::kEntries> IntrinsicsJacobian(const Pinhole& pinhole,
                                                                        const Eigen::Vector3d& x_in_camera,
                                                                        const Eigen::Vector2d& distorted,
                                                                        const CorrectedPixel& corrected,
                                                                        const Eigen::Vector2d& row_motion) {
  const Eigen::DiagonalMatrix<double, 2> focal(pinhole.fx, pinhole.fy);
  const Eigen::Matrix2d by_pixel = focal * corrected.jacobian * focal.inverse();
  const double square = distorted.squaredNorm();
  const Eigen::Vector2d outward = focal * corrected.lens_point;
  Eigen::Matrix<double, 2, IntrinsicsChange::kEntries> J;
  const Eigen::Vector2d residual = pinhole.Project(x_in_camera) - corrected.pixel;
  const Eigen::Vector2d vertical = Eigen::Vector2d::UnitY();
  J.col(IntrinsicsChange::kLogFocal) = residual + focal * (corrected.jacobian * distorted);
  J.col(IntrinsicsChange::kLogAspect) =
      residual.y() * vertical + focal * (corrected.jacobian * (distorted.y() * vertical));
  J.col(IntrinsicsChange::kReadout) = row_motion;
  J.middleCols<2>(IntrinsicsChange::kCentreX) = by_pixel;
  J.col(IntrinsicsChange::kCorrection) = -square * outward;
  J.col(IntrinsicsChange::kCorrection4) = -square * square * outward;
  J.col(IntrinsicsChange::kCorrection6) = -square * square * square * outward;
  return J;
}

}  // namespace turnscale

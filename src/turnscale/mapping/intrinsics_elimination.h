// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/mapping/intrinsics_change.h"

namespace turnscale {

/// Derivatives of one residual of a window, over sigma and with the root of Huber's weight. Pose unknowns are
/// (phi, delta): x_in_camera = Exp(phi) R (X - c + delta), so that the point's derivatives are those of delta.
struct IntrinsicsRow {
  static constexpr int kPoseDof = 6;
  /// Of a point: two fit one whatever the camera.
  static constexpr std::size_t kFewestOfPoint = 3;

  int column = -1;  ///< first of the pose's in the reduced system; below 0: it holds still
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, kPoseDof> pose;
  Eigen::Matrix<double, 2, IntrinsicsChange::kEntries> intrinsics;

  auto point() const { return pose.rightCols<3>(); }
};

/// Derivatives of a point by the intrinsics.
using PointByIntrinsics = Eigen::Matrix<double, 3, IntrinsicsChange::kEntries>;

/// The normal equations of a window without its points: poses but the first, then the intrinsics. Upper triangle.
struct ReducedSystem {
  explicit ReducedSystem(int cameras)
      : poses(IntrinsicsRow::kPoseDof * (cameras - 1)),
        hessian(Eigen::MatrixXd::Zero(poses + IntrinsicsChange::kEntries, poses + IntrinsicsChange::kEntries)),
        gradient(Eigen::VectorXd::Zero(poses + IntrinsicsChange::kEntries)) {}

  int poses;  ///< unknowns
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
};

/// One point's normal equations, solved for the point: it moves by -(step + by_intrinsics * intrinsics + the sum of
/// edge blocks times their poses).
struct EliminatedPoint {
  struct Edge {
    int column;
    Eigen::Matrix<double, 3, IntrinsicsRow::kPoseDof> block;
  };
  Eigen::Vector3d step;
  PointByIntrinsics by_intrinsics;
  std::vector<Edge> edges;
};

/// Adds the rows of one point to the system and takes the point out. Nothing where they do not determine it.
std::optional<EliminatedPoint> Eliminate(const std::vector<IntrinsicsRow>& rows, ReducedSystem& system);

/// How poses and points move with the intrinsics, to first order: for a step of these, and without one. A point that is
/// not determined stays.
struct IntrinsicsResponse {
  Eigen::MatrixXd poses;  ///< a column an entry of IntrinsicsChange
  Eigen::VectorXd pose_step;
  std::vector<PointByIntrinsics> points;
  std::vector<Eigen::Vector3d> point_step;
};

/// What a system says of the intrinsics, whatever the poses.
struct MarginalIntrinsics {
  IntrinsicsChange::Matrix information;
  IntrinsicsChange::Vector gradient;
  IntrinsicsResponse response;
};

/// Takes the poses out, with the unit of length held, and finds how they and the points follow. Nothing where the
/// points do not determine the poses. `points`: of Eliminate, in order; `camera_from_world`: of all cameras of the
/// system.
std::optional<MarginalIntrinsics> Marginalize(const ReducedSystem& system,
                                              const std::vector<std::optional<EliminatedPoint>>& points,
                                              const std::vector<RigidTransform>& camera_from_world);

}  // namespace turnscale

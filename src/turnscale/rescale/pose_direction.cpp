// SPDX-License-Identifier: MIT
#include "turnscale/rescale/pose_direction.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

namespace turnscale {
namespace {

// Steps of a path whose directions are compared: long against the noise of poses, short against a turn.
constexpr int kSteps = 400;

Eigen::Vector3d MotionBetween(const RigidTransform& from, const RigidTransform& to) {
  return (from.inverse() * to).translation;
}

// The share of the path, in (1/3, 1], that goes along the body's axis along which most of it goes. 1 if there is none.
double ShareAlongOneAxis(const std::vector<Trajectory>& pieces) {
  double length = 0;
  for (const Trajectory& piece : pieces)
    for (std::size_t i = 1; i < piece.size(); ++i)
      length += MotionBetween(piece[i - 1].world_from_camera, piece[i].world_from_camera).norm();
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double total = 0;
  for (const Trajectory& piece : pieces) {
    std::size_t first = 0;
    for (std::size_t i = 1; i < piece.size(); ++i) {
      const Eigen::Vector3d motion = MotionBetween(piece[first].world_from_camera, piece[i].world_from_camera);
      if (!(motion.norm() > length / kSteps)) continue;
      scatter += motion * motion.transpose() / motion.norm();
      total += motion.norm();
      first = i;
    }
  }
  if (total == 0) return 1;
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter / total).eigenvalues()[2];
}

}  // namespace

bool AreInverse(const std::vector<Trajectory>& pieces) {
  std::vector<Trajectory> inverse = pieces;
  for (Trajectory& piece : inverse)
    for (StampedPose& pose : piece) pose.world_from_camera = pose.world_from_camera.inverse();
  constexpr double kMostAcross = 0.05;
  constexpr double kFewer = 0.2;
  const double across = 1 - ShareAlongOneAxis(pieces);
  return across > kMostAcross && 1 - ShareAlongOneAxis(inverse) < kFewer * across;
}

}  // namespace turnscale

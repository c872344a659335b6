// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/body_axes.h"

#include <Eigen/SVD>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Sum of products of corresponding vectors, over the sum of the products of their lengths.
struct Correlation {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  double total = 0;

  void Add(const Eigen::Vector3d& estimate, const Eigen::Vector3d& truth) {
    sum += estimate * truth.transpose();
    total += estimate.norm() * truth.norm();
  }
  Eigen::Matrix3d Mean() const { return total > 0 ? Eigen::Matrix3d(sum / total) : Eigen::Matrix3d::Zero(); }
};

}  // namespace

BodyAxes CompareBodyAxes(const PosePairs& pairs, const std::vector<Step>& steps) {
  Correlation ways;
  Correlation turns;
  for (const Step& step : steps) {
    const RigidTransform estimate = pairs[step.first].estimate.inverse() * pairs[step.last].estimate;
    const RigidTransform truth = pairs[step.first].truth.inverse() * pairs[step.last].truth;
    // Of the estimate the direction only: its scale may drift.
    ways.Add(estimate.translation.normalized(), truth.translation);
    turns.Add(VectorFromRotation(estimate.rotation), VectorFromRotation(truth.rotation));
  }
  const Eigen::Matrix3d way = ways.Mean();
  const Eigen::Matrix3d turn = turns.Mean();
  // The way shows all but the angle about itself: on a straight, turns are little but noise, and would bend the others.
  constexpr double kWeightOfTurns = 0.1;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(way + kWeightOfTurns * turn, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) *= -1;
  const Eigen::Matrix3d rotation = u * svd.matrixV().transpose();
  const auto along = [&](const Eigen::Matrix3d& mean) { return (rotation.transpose() * mean).trace(); };
  return {Eigen::Quaterniond(rotation), {way.trace(), turn.trace()}, {along(way), along(turn)}};
}

RigidTransform WithOtherAxes(const RigidTransform& world_from_body, const Eigen::Quaterniond& other_from_body) {
  return {other_from_body * world_from_body.rotation * other_from_body.conjugate(),
          other_from_body * world_from_body.translation};
}

}  // namespace turnscale

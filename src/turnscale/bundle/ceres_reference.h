// SPDX-License-Identifier: MIT
#pragma once

#include <memory>

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/bundle/bundle_problem.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {

/// Reprojection error for Ceres' automatic differentiation: camera (rotation vector, centre), point.
struct CeresReprojection {
  template <typename T>
  bool operator()(const T* rotation, const T* centre, const T* point, T* residual) const {
    const T offset[3] = {point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]};
    T x[3];
    ceres::AngleAxisRotatePoint(rotation, offset, x);
    residual[0] = (pinhole.fx * x[0] / x[2] + pinhole.cx - seen.pixel.x()) / seen.sigma;
    residual[1] = (pinhole.fy * x[1] / x[2] + pinhole.cy - seen.pixel.y()) / seen.sigma;
    return true;
  }

  Pinhole pinhole;
  BundleObservation seen;
};

/// Error of a measured distance for Ceres, in sigmas.
struct CeresDistance {
  template <typename T>
  bool operator()(const T* a, const T* b, T* residual) const {
    using std::sqrt;
    const T d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    residual[0] = (sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) / measured.between.distance - 1.0) / measured.sigma;
    return true;
  }

  MeasuredDistance measured;
};

/// The same cost as AdjustBundle's without constraints, minimised by Ceres on one thread; the result goes into
/// `problem`. Independent of our solver: automatic derivatives, another rotation parameter, Ceres' own algebra.
inline ceres::Solver::Summary AdjustWithCeres(const BundleOptions& options, ceres::Solver::Options solver_options,
                                              BundleProblem& problem) {
  ceres::Problem ceres_problem;
  BundleState state = StateFromProblem(problem);
  std::vector<Eigen::Vector3d> rotations;
  for (const RigidTransform& pose : problem.camera_from_world) {
    rotations.push_back(VectorFromRotation(pose.rotation));
  }
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (const BundleObservation& seen : problem.observations) {
    auto* residual =
        new ceres::AutoDiffCostFunction<CeresReprojection, 2, 3, 3, 3>(new CeresReprojection{problem.pinhole, seen});
    ceres_problem.AddResidualBlock(residual, new ceres::HuberLoss(options.huber_threshold),
                                   rotations[seen.camera].data(), state.centres[seen.camera].data(),
                                   state.points[seen.point].data());
    ordering->AddElementToGroup(state.points[seen.point].data(), 0);
    ordering->AddElementToGroup(rotations[seen.camera].data(), 1);
    ordering->AddElementToGroup(state.centres[seen.camera].data(), 1);
  }
  for (const MeasuredDistance& measured : problem.measured_distances) {
    ceres_problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CeresDistance, 1, 3, 3>(new CeresDistance{measured}),
                                   nullptr, state.centres[measured.between.camera_a].data(),
                                   state.centres[measured.between.camera_b].data());
  }
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    if (!ceres_problem.HasParameterBlock(rotations[i].data())) continue;
    if (options.fix_rotations || problem.camera_is_fixed[i]) {
      ceres_problem.SetParameterBlockConstant(rotations[i].data());
    }
    if (problem.camera_is_fixed[i]) ceres_problem.SetParameterBlockConstant(state.centres[i].data());
  }
  solver_options.linear_solver_type = ceres::SPARSE_SCHUR;
  solver_options.linear_solver_ordering = ordering;
  solver_options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options, &ceres_problem, &summary);
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    if (!problem.camera_is_fixed[i]) state.rotations[i] = RotationFromVector(rotations[i]).toRotationMatrix();
  }
  StateToProblem(state, options.fix_rotations, problem);
  return summary;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/mapping/pose_estimation.h"

#include <cmath>

#include <Eigen/Cholesky>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/cell_weights.h"

namespace turnscale {
namespace {

constexpr int kRounds = 4;
constexpr double kStepTolerance = 1e-8;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// Unit of length for the step test, so that it does not depend on the map's unit.
double TypicalDistance(const std::vector<PointSighting>& sightings, const RigidTransform& camera_from_world) {
  double sum = 0;
  for (const PointSighting& sighting : sightings) sum += (camera_from_world * sighting.x_in_world).norm();
  return sightings.empty() ? 1.0 : sum / static_cast<double>(sightings.size());
}

struct Normal {
  Matrix6d matrix = Matrix6d::Zero();  // its lower triangle: the factorisation reads no more
  Vector6d gradient = Vector6d::Zero();
};

std::vector<double> Weights(const PoseEstimationOptions& options, const Pinhole& pinhole,
                            const std::vector<PointSighting>& sightings) {
  std::vector<Eigen::Vector2d> pixels;
  pixels.reserve(sightings.size());
  for (const PointSighting& sighting : sightings) pixels.push_back(sighting.pixel);
  return CellWeights(pinhole, pixels, options.max_cell_weight);
}

Normal BuildNormal(const PoseEstimationOptions& options, const Pinhole& pinhole,
                   const std::vector<PointSighting>& sightings, const std::vector<double>& weights,
                   const std::vector<char>& used, const RigidTransform& camera_from_world) {
  Normal normal;
  const Eigen::Matrix3d R = camera_from_world.rotation.toRotationMatrix();
  for (size_t i = 0; i < sightings.size(); ++i) {
    if (used[i] == 0) continue;
    const Eigen::Vector3d x = R * sightings[i].x_in_world + camera_from_world.translation;
    if (!(x.z() > 0)) continue;
    const double inverse_depth = 1.0 / x.z();
    const Eigen::Vector2d residual = pinhole.Project(x) - sightings[i].pixel;
    const double error = residual.norm();
    const double weight = error > options.huber_threshold ? weights[i] * options.huber_threshold / error : weights[i];
    // Derivatives of the pixel's two coordinates by the position: (a, 0, b) and (0, c, d); by the rotation about the
    // camera: minus that times the cross product with the point. One about the world's origin would move a camera far
    // from it by the square of the angle times the distance.
    const double a = pinhole.fx * inverse_depth;
    const double b = -pinhole.fx * x.x() * inverse_depth * inverse_depth;
    const double c = pinhole.fy * inverse_depth;
    const double d = -pinhole.fy * x.y() * inverse_depth * inverse_depth;
    Vector6d J0;
    Vector6d J1;
    J0 << b * x.y(), a * x.z() - b * x.x(), -a * x.y(), a, 0, b;
    J1 << d * x.y() - c * x.z(), -d * x.x(), c * x.x(), 0, c, d;
    const Vector6d weighted0 = weight * J0;
    const Vector6d weighted1 = weight * J1;
    for (int column = 0; column < 6; ++column)
      for (int row = column; row < 6; ++row)
        normal.matrix(row, column) += weighted0[row] * J0[column] + weighted1[row] * J1[column];
    normal.gradient += weighted0 * residual.x() + weighted1 * residual.y();
  }
  return normal;
}

// Returns whether any sighting has become an inlier or an outlier.
bool Classify(const PoseEstimationOptions& options, const Pinhole& pinhole, const std::vector<PointSighting>& sightings,
              PoseEstimate& estimate) {
  bool changed = false;
  estimate.inliers = 0;
  for (size_t i = 0; i < sightings.size(); ++i) {
    const Eigen::Vector3d x = estimate.camera_from_world * sightings[i].x_in_world;
    const double squared = x.z() > 0 ? (pinhole.Project(x) - sightings[i].pixel).squaredNorm() : HUGE_VAL;
    const char inlier = squared <= options.inlier_threshold * options.inlier_threshold ? 1 : 0;
    changed |= inlier != estimate.inlier[i];
    estimate.inlier[i] = inlier;
    estimate.inliers += inlier;
  }
  return changed;
}

PoseEstimate Fit(const PoseEstimationOptions& options, const Pinhole& pinhole,
                 const std::vector<PointSighting>& sightings, const std::vector<double>& weights,
                 const RigidTransform& initial) {
  PoseEstimate estimate;
  estimate.camera_from_world = initial;
  estimate.inlier.assign(sightings.size(), 1);
  const double distance = TypicalDistance(sightings, initial);
  for (int round = 0; round < kRounds; ++round) {
    bool settled = false;
    for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
      const Normal normal =
          BuildNormal(options, pinhole, sightings, weights, estimate.inlier, estimate.camera_from_world);
      const Eigen::LDLT<Matrix6d> factor(normal.matrix);
      const Vector6d step = -factor.solve(normal.gradient);
      if (factor.info() != Eigen::Success || !step.allFinite()) break;
      estimate.camera_from_world =
          RigidTransform{RotationFromVector(step.head<3>()), step.tail<3>()} * estimate.camera_from_world;
      settled = step.head<3>().norm() + step.tail<3>().norm() / distance < kStepTolerance;
      if (settled) break;
    }
    if (!Classify(options, pinhole, sightings, estimate) && settled) break;
  }
  return estimate;
}

void Weigh(const std::vector<double>& weights, PoseEstimate& estimate) {
  double all = 0;
  for (size_t i = 0; i < weights.size(); ++i) {
    all += weights[i];
    if (estimate.inlier[i] != 0) estimate.inlier_weight += weights[i];
  }
  estimate.inlier_share = all > 0 ? estimate.inlier_weight / all : 0;
}

}  // namespace

void PoseEstimationOptions::Check() const {
  if (!(inlier_threshold > 0)) throw InputError("inlier_threshold: has to be positive");
  if (!(huber_threshold > 0)) throw InputError("huber_threshold: has to be positive");
  if (!(min_agreeing_share >= 0 && min_agreeing_share <= 1)) throw InputError("min_agreeing_share: has to be in 0...1");
  if (!(max_cell_weight > 0)) throw InputError("max_cell_weight: has to be positive");
  if (max_iterations < 1) throw InputError("max_iterations: has to be at least 1");
}

PoseEstimate EstimatePose(const PoseEstimationOptions& options, const Pinhole& pinhole,
                          const std::vector<PointSighting>& sightings, const RigidTransform& initial) {
  const std::vector<double> weights = Weights(options, pinhole, sightings);
  const std::vector<double> alike(sightings.size(), 1.0);
  PoseEstimate estimate = Fit(options, pinhole, sightings, alike, initial);
  Weigh(weights, estimate);
  if (estimate.inlier_share >= options.min_agreeing_share) return estimate;
  PoseEstimate balanced = Fit(options, pinhole, sightings, weights, initial);
  Weigh(weights, balanced);
  return balanced.inlier_weight > estimate.inlier_weight ? balanced : estimate;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "turnscale/bundle/bundle_problem.h"

namespace turnscale {

/// A drive of known truth for tests and benchmarks of bundle adjustment. Lengths in metres.
struct SyntheticDriveOptions {
  int cameras = 10;
  int points = 1500;
  int observations = 8000;   ///< wanted; what the views allow may be a little less
  double step = 1.0;         ///< between keyframes
  int turn_every = 60;       ///< one turn begins every so many keyframes
  int turn_length = 10;      ///< keyframes a turn takes
  double turn_angle = 0.09;  ///< between keyframes of a turn, radians
  double pixel_noise = 0.5;  ///< standard deviation, pixels
  double outliers = 0;       ///< share of observations that are tens of pixels off
  unsigned seed = 1;
};

struct SyntheticDrive {
  BundleProblem truth;       ///< true poses and points, noisy pixels, first camera fixed, no distances
  std::vector<int> turning;  ///< cameras whose step from the one before belongs to a turn
};

SyntheticDrive MakeSyntheticDrive(const SyntheticDriveOptions& options);

/// Moves free cameras and points by Gaussian noise: `position` metres, `angle` radians; points along their first ray
/// and across by the share `depth` of their distance.
void Disturb(double position, double angle, double depth, unsigned seed, BundleProblem& problem);

/// Scales the drive about its first camera, as odometry with a drifting unit would: each step by a factor that goes
/// linearly from `first` to `last`. Points move with the first camera that sees them.
void DriftScale(double first, double last, BundleProblem& problem);

/// True distances between consecutive cameras of the turns, evenly chosen, at most `count`.
std::vector<DistanceConstraint> TurnDistances(const SyntheticDrive& drive, int count);

inline Eigen::Vector3d Centre(const BundleProblem& problem, std::size_t camera) {
  return problem.camera_from_world[camera].inverse().translation;
}

}  // namespace turnscale

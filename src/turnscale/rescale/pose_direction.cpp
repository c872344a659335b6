// SPDX-License-Identifier: MIT
#include "turnscale/rescale/pose_direction.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Steps of a path whose directions are compared: long against the noise of poses, short against a turn.
constexpr int kSteps = 400;
// Of them, the share that turns least: in turns a camera ahead of the rear axle goes sideways, too.
constexpr double kStraightest = 1.0 / 3;
constexpr std::size_t kLeastSteps = 10;

// The motion from one pose to a later one in the body's axes, if the poses are world_from_camera and if they are
// camera_from_world.
struct Step {
  Eigen::Vector3d as_given = Eigen::Vector3d::Zero();
  Eigen::Vector3d as_inverse = Eigen::Vector3d::Zero();
  double turn = 0;  // rad, either way

  // Read the wrong way round, the camera goes about the origin in turns, which may be far away.
  double length() const { return std::min(as_given.norm(), as_inverse.norm()); }
};

Step StepBetween(const RigidTransform& from, const RigidTransform& to) {
  return {(from.inverse() * to).translation, (from * to.inverse()).translation,
          RotationAngle(from.rotation.conjugate() * to.rotation)};
}

// On a straight, both readings have the same length. In a turn, one of them is longer by the way about the origin.
bool IsAsLongEitherWay(const Step& step) {
  constexpr double kMostRatio = 1.1;
  return step.length() * kMostRatio > std::max(step.as_given.norm(), step.as_inverse.norm());
}

// In the order of their turning rate, the straightest first.
std::vector<Step> StepsOf(const std::vector<Trajectory>& pieces) {
  double length = 0;
  for (const Trajectory& piece : pieces)
    for (std::size_t i = 1; i < piece.size(); ++i)
      length += StepBetween(piece[i - 1].world_from_camera, piece[i].world_from_camera).length();
  std::vector<Step> steps;
  for (const Trajectory& piece : pieces) {
    std::size_t first = 0;
    for (std::size_t i = 1; i < piece.size(); ++i) {
      const Step step = StepBetween(piece[first].world_from_camera, piece[i].world_from_camera);
      if (!(step.length() > length / kSteps)) continue;
      steps.push_back(step);
      first = i;
    }
  }
  std::ranges::stable_sort(steps, {}, [](const Step& step) { return step.turn / step.length(); });
  return steps;
}

// The share of the motion that does not go along the axis along which most of it goes.
double ShareAcross(const std::vector<Step>& steps, Eigen::Vector3d Step::*motion) {
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double total = 0;
  for (const Step& step : steps) {
    const Eigen::Vector3d& moved = step.*motion;
    scatter += moved * moved.transpose() / moved.norm();
    total += moved.norm();
  }
  if (total == 0) return 0;
  return 1 - Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter / total).eigenvalues()[2];
}

}  // namespace

bool AreInverse(const std::vector<Trajectory>& pieces) {
  std::vector<Step> steps = StepsOf(pieces);
  steps.resize(static_cast<std::size_t>(std::ceil(kStraightest * static_cast<double>(steps.size()))));
  std::erase_if(steps, [](const Step& step) { return !IsAsLongEitherWay(step); });
  if (steps.size() < kLeastSteps) return false;
  // World_from_camera poses of recorded drives reach 0.002, their inverses 0.013 or more where a drive has straights in
  // different directions.
  constexpr double kMostAcross = 0.01;
  // Right poses of a camera that swings by 4 degrees (rms) may exceed that, too, but their inverses then have 0.8 of it
  // or more (simulated). Inverse poses of one that swings by up to 2 degrees usually have ten times the share of the
  // right ones. The bound is far from right poses, as what is found inverse is refused.
  constexpr double kFewer = 0.1;
  const double across = ShareAcross(steps, &Step::as_given);
  return across > kMostAcross && ShareAcross(steps, &Step::as_inverse) < kFewer * across;
}

}  // namespace turnscale

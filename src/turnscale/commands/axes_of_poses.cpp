// SPDX-License-Identifier: MIT
#include "turnscale/commands/axes_of_poses.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "turnscale/calibration/camera_axes.h"
#include "turnscale/evaluation/body_axes.h"
#include "turnscale/evaluation/evaluation.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/rescale/pose_direction.h"

namespace turnscale {
namespace {

// Smaller angles are errors of the estimate, or of how the camera is mounted, and count as such.
constexpr double kOtherAxes = 20 / kDegreesPerRadian;
constexpr double kAlike = 0.8;
constexpr double kUnlike = 0.5;
// On a path that turns less, the noise of its turns would show the third angle between the bodies.
constexpr double kLeastTurn = 0.2;

// Long against the noise of positions, short against a turn.
std::vector<Step> StepsFor(const PosePairs& pairs) {
  StepErrorOptions options;
  options.length = std::clamp(TruePathLength(pairs) / 100, 1.0, 5.0);  // metres
  return StepsAlongPath(pairs, options);
}

using PoseOfPair = RigidTransform PosePair::*;

AxisConvention ConventionOf(const PosePairs& pairs, const std::vector<Step>& steps, PoseOfPair pose) {
  std::vector<CameraStep> motions;
  for (const Step& step : steps)
    motions.push_back({(pairs[step.first].*pose).inverse() * (pairs[step.last].*pose), 1, 0, 0});
  return FindAxisConvention(motions);
}

void Turn(PosePairs& pairs, PoseOfPair pose, const Eigen::Quaterniond& other_from_body) {
  for (PosePair& pair : pairs) pair.*pose = WithOtherAxes(pair.*pose, other_from_body);
}

// Where the axes of a body point, as a camera sees it; nothing where they are askew to the camera's.
std::optional<std::string> NamesOf(const Eigen::Quaterniond& camera_from_body) {
  constexpr std::array kPositive = {"right", "down", "forward"};
  constexpr std::array kNegative = {"left", "up", "backward"};
  constexpr double kCosine20Deg = 0.94;
  const Eigen::Matrix3d axes = camera_from_body.toRotationMatrix();
  std::string names;
  for (int axis = 0; axis < 3; ++axis) {
    int along = 0;
    if (axes.col(axis).cwiseAbs().maxCoeff(&along) < kCosine20Deg) return std::nullopt;
    names += fmt::format("{}{} {}", axis == 0 ? "" : ", ", "xyz"[axis],
                         axes(along, axis) > 0 ? kPositive[along] : kNegative[along]);
  }
  return names;
}

// Whether a body turns by kLeastTurn in all.
bool Turns(const PosePairs& pairs, PoseOfPair pose) {
  return std::ranges::any_of(pairs, [&](const PosePair& pair) {
    return RotationAngle((pairs.front().*pose).rotation.conjugate() * (pair.*pose).rotation) > kLeastTurn;
  });
}

std::string TurnedWarning(const std::string& turned, const std::string& whose,
                          const Eigen::Quaterniond& other_from_turned, AxisConvention other) {
  const std::optional<std::string> names =
      other == AxisConvention::kCamera ? NamesOf(other_from_turned) : std::optional<std::string>();
  return fmt::format(
      "{}: the axes of its poses ({}) are not those of {}; they are turned to these by the constant rotation "
      "that fits the motion best, so the errors leave out how the camera is mounted",
      turned, names.value_or(fmt::format("turned by {:.0f} deg", kDegreesPerRadian * RotationAngle(other_from_turned))),
      whose);
}

bool AreInverse(const PosePairs& pairs, PoseOfPair pose) {
  Trajectory path;
  for (const PosePair& pair : pairs) path.push_back({pair.time, pair.*pose});
  return turnscale::AreInverse({path});
}

// Poses of one of the two that are camera_from_world; empty where none are, or both.
std::string InverseWarning(const ComparedPoses& compared, const PosePairs& pairs) {
  const bool of_estimate = AreInverse(pairs, &PosePair::estimate);
  if (of_estimate == AreInverse(pairs, &PosePair::truth)) return {};
  return fmt::format(
      "{}: its poses are camera_from_world, and rotation and translation errors tell nothing; give the inverse poses",
      of_estimate ? compared.estimate : compared.truth);
}

// Whether the motions are alike once the poses of one of the two are inverted.
bool IsOneInverse(PosePairs pairs, const std::vector<Step>& steps) {
  for (PosePair& pair : pairs) pair.estimate = pair.estimate.inverse();
  const BodyAxes axes = CompareBodyAxes(pairs, steps);
  return axes.as_given.way > kAlike && axes.as_given.turn > kAlike;
}

}  // namespace

std::string UniteAxes(const ComparedPoses& compared, PosePairs& pairs) {
  const std::vector<Step> steps = StepsFor(pairs);
  if (steps.empty()) return {};
  if (std::string inverse = InverseWarning(compared, pairs); !inverse.empty()) return inverse;
  const BodyAxes axes = CompareBodyAxes(pairs, steps);
  AxisConvention estimate = ConventionOf(pairs, steps, &PosePair::estimate);
  const AxisConvention truth = ConventionOf(pairs, steps, &PosePair::truth);
  const bool turns = Turns(pairs, &PosePair::estimate) && Turns(pairs, &PosePair::truth);
  const bool alike = turns && std::min(axes.turned.way, axes.turned.turn) > kAlike;
  std::string warning;
  if (alike && RotationAngle(axes.estimate_from_truth) > kOtherAxes) {
    if (!compared.keeps_axes && estimate != AxisConvention::kCamera && truth == AxisConvention::kCamera) {
      const Eigen::Quaterniond truth_from_estimate = axes.estimate_from_truth.conjugate();
      warning = TurnedWarning(compared.estimate, "the ground truth", truth_from_estimate, truth);
      Turn(pairs, &PosePair::estimate, truth_from_estimate);
      estimate = truth;
    } else {
      warning = TurnedWarning(compared.truth, "the estimate", axes.estimate_from_truth, estimate);
      Turn(pairs, &PosePair::truth, axes.estimate_from_truth);
    }
  } else if (!alike && axes.as_given.way < kUnlike) {
    if (!turns && axes.turned.way > kAlike)
      return compared.truth +
             ": its poses have other body axes than the estimate's, and the drive turns too little to tell which: "
             "rotation and translation errors tell nothing; give both in camera axes";
    return fmt::format(
        "{}: each in its own axes, it moves in other directions than the estimate: rotation and translation errors "
        "tell nothing; {}",
        compared.truth,
        IsOneInverse(pairs, steps)
            ? "one of the two files has camera_from_world poses; give the inverse of these"
            : "check that both files have world_from_camera poses of the same drive, in camera axes");
  }
  if (!compared.keeps_axes && estimate != AxisConvention::kCamera) {
    const Eigen::Quaterniond camera_from_body = BodyFromCamera(estimate).conjugate();
    Turn(pairs, &PosePair::estimate, camera_from_body);
    Turn(pairs, &PosePair::truth, camera_from_body);
  }
  return warning;
}

}  // namespace turnscale

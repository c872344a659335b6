// SPDX-License-Identifier: MIT
#include "turnscale/bundle/bundle_problem.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

// Whoever makes a problem answers for its indices and sizes.
void Require(bool fine, const std::string& what, SourcePlace where = SourcePlace::Here()) {
  Ensure(fine, "bundle problem: " + what, where);
}

// What is computed may come to this.
void RequireNumber(bool fine, const std::string& what) {
  if (!fine) throw NumericalError("bundle problem: " + what);
}

std::string At(const char* list, std::size_t i) { return std::string(list) + "[" + std::to_string(i) + "]"; }

bool IsIndex(int i, std::size_t size) { return i >= 0 && static_cast<std::size_t>(i) < size; }

void CheckCameras(const BundleProblem& problem) {
  const Pinhole& pinhole = problem.pinhole;
  RequireNumber(std::isfinite(pinhole.fx) && pinhole.fx > 0, "pinhole.fx is not a positive number");
  RequireNumber(std::isfinite(pinhole.fy) && pinhole.fy > 0, "pinhole.fy is not a positive number");
  RequireNumber(std::isfinite(pinhole.cx) && std::isfinite(pinhole.cy), "pinhole.cx or pinhole.cy is not a number");
  Require(problem.camera_is_fixed.size() == problem.camera_from_world.size(),
          "camera_is_fixed has " + std::to_string(problem.camera_is_fixed.size()) + " entries for " +
              std::to_string(problem.camera_from_world.size()) + " cameras");
  Require(std::any_of(problem.camera_is_fixed.begin(), problem.camera_is_fixed.end(), [](char f) { return f != 0; }),
          "camera_is_fixed fixes no camera; at least one has to be");
  for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
    const RigidTransform& pose = problem.camera_from_world[i];
    if (!pose.IsFinite()) {
      RequireNumber(false, At("camera_from_world", i) + " is not a number");
    }
    if (std::abs(pose.rotation.norm() - 1.0) > 1e-6) {
      RequireNumber(false, At("camera_from_world", i) + " has a rotation that is not a unit quaternion");
    }
  }
}

void CheckObservations(const BundleProblem& problem) {
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    if (!problem.points[i].allFinite()) RequireNumber(false, At("points", i) + " is not a number");
  }
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& seen = problem.observations[i];
    if (!IsIndex(seen.camera, problem.camera_from_world.size())) {
      Require(false, At("observations", i) + " names camera " + std::to_string(seen.camera) + ", which does not exist");
    }
    if (!IsIndex(seen.point, problem.points.size())) {
      Require(false, At("observations", i) + " names point " + std::to_string(seen.point) + ", which does not exist");
    }
    if (!seen.pixel.allFinite()) RequireNumber(false, At("observations", i) + ".pixel is not a number");
    if (!std::isfinite(seen.sigma) || seen.sigma <= 0) {
      Require(false, At("observations", i) + ".sigma is not a positive number");
    }
  }
}

void CheckDistance(const BundleProblem& problem, const DistanceConstraint& held, const std::string& name) {
  Require(IsIndex(held.camera_a, problem.camera_from_world.size()) &&
              IsIndex(held.camera_b, problem.camera_from_world.size()),
          name + " names a camera that does not exist");
  Require(held.camera_a != held.camera_b, name + " constrains the distance of a camera to itself");
  Require(!problem.camera_is_fixed[held.camera_a] || !problem.camera_is_fixed[held.camera_b],
          name + " constrains the distance of two fixed cameras");
  Require(std::isfinite(held.distance) && held.distance > 0, name + ".distance is not a positive number");
}

void CheckDistances(const BundleProblem& problem) {
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < problem.distances.size(); ++i) {
    const DistanceConstraint& held = problem.distances[i];
    CheckDistance(problem, held, At("distances", i));
    pairs.emplace_back(std::minmax(held.camera_a, held.camera_b));
  }
  for (std::size_t i = 0; i < problem.measured_distances.size(); ++i) {
    const auto& [between, sigma] = problem.measured_distances[i];
    CheckDistance(problem, between, At("measured_distances", i));
    Require(std::isfinite(sigma) && sigma > 0, At("measured_distances", i) + ".sigma is not a positive number");
  }
  std::sort(pairs.begin(), pairs.end());
  const auto twice = std::adjacent_find(pairs.begin(), pairs.end());
  if (twice != pairs.end()) {
    Require(false, "distances has cameras " + std::to_string(twice->first) + " and " + std::to_string(twice->second) +
                       " twice");
  }
}

}  // namespace

void CheckProblem(const BundleProblem& problem) {
  CheckCameras(problem);
  CheckObservations(problem);
  CheckDistances(problem);
}

BundleState StateFromProblem(const BundleProblem& problem) {
  BundleState state;
  state.rotations.reserve(problem.camera_from_world.size());
  state.centres.reserve(problem.camera_from_world.size());
  for (const RigidTransform& camera_from_world : problem.camera_from_world) {
    const Eigen::Matrix3d R = camera_from_world.rotation.normalized().toRotationMatrix();
    state.rotations.push_back(R);
    state.centres.push_back(-(R.transpose() * camera_from_world.translation));
  }
  state.points = problem.points;
  return state;
}

void StateToProblem(const BundleState& state, bool fix_rotations, BundleProblem& problem) {
  for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
    if (problem.camera_is_fixed[i]) continue;
    RigidTransform& camera_from_world = problem.camera_from_world[i];
    camera_from_world.translation = -(state.rotations[i] * state.centres[i]);
    if (!fix_rotations) camera_from_world.rotation = Eigen::Quaterniond(state.rotations[i]).normalized();
  }
  problem.points = state.points;
}

}  // namespace turnscale

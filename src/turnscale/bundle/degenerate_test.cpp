// SPDX-License-Identifier: MIT
#include <exception>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/bundle/synthetic_drive.h"

namespace turnscale {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

BundleProblem Small() {
  SyntheticDriveOptions options;
  options.cameras = 5;
  options.points = 60;
  options.observations = 250;
  BundleProblem problem = MakeSyntheticDrive(options).truth;
  problem.camera_is_fixed[1] = 1;
  Disturb(0.02, 0.002, 0.02, 1, problem);
  return problem;
}

BundleProblem SmallAdjusted() {
  BundleProblem problem = Small();
  EXPECT_TRUE(AdjustBundle({}, problem).converged);
  return problem;
}

void ExpectCamerasAsIn(const BundleProblem& expected, const BundleProblem& actual) {
  for (std::size_t i = 0; i < expected.camera_from_world.size(); ++i) {
    EXPECT_LT((actual.camera_from_world[i].translation - expected.camera_from_world[i].translation).norm(), 1e-6);
  }
}

void ExpectFinite(const BundleProblem& problem) {
  for (const Eigen::Vector3d& point : problem.points) EXPECT_TRUE(point.allFinite());
  for (const RigidTransform& pose : problem.camera_from_world) {
    EXPECT_TRUE(pose.translation.allFinite());
    EXPECT_TRUE(pose.rotation.coeffs().allFinite());
  }
}

TEST(Degenerate, PointSeenOnceFitsItsPixelAndPullsNoCamera) {
  BundleProblem problem = Small();
  const Eigen::Vector2d pixel(300, 200);
  problem.points.push_back(problem.camera_from_world[3].inverse() * (10.0 * problem.pinhole.Ray({310, 195})).eval());
  problem.observations.push_back({3, static_cast<int>(problem.points.size()) - 1, pixel, 1.0});
  BundleOptions options;
  options.relative_cost_tolerance = 1e-12;
  EXPECT_TRUE(AdjustBundle(options, problem).converged);
  const Eigen::Vector3d x_in_camera = problem.camera_from_world[3] * problem.points.back();
  EXPECT_LT((problem.pinhole.Project(x_in_camera) - pixel).norm(), 1e-4);
  EXPECT_NEAR(x_in_camera.norm(), 10.0, 1.0) << "nothing says how far it is, so it stays about there";

  BundleProblem without = Small();
  AdjustBundle(options, without);
  ExpectCamerasAsIn(without, problem);
}

TEST(Degenerate, PointSeenByNobodyStays) {
  BundleProblem problem = Small();
  problem.points.emplace_back(1, 2, 3);
  EXPECT_TRUE(AdjustBundle({}, problem).converged);
  EXPECT_EQ(problem.points.back(), Eigen::Vector3d(1, 2, 3));
}

TEST(Degenerate, CameraThatSeesNothingStays) {
  BundleProblem problem = Small();
  const RigidTransform pose{Eigen::Quaterniond::Identity(), {1, 2, 3}};
  problem.camera_from_world.push_back(pose);
  problem.camera_is_fixed.push_back(0);
  const BundleSummary summary = AdjustBundle({}, problem);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT((problem.camera_from_world.back().translation - pose.translation).norm(), 1e-14);
  problem.camera_from_world.pop_back();
  ExpectCamerasAsIn(SmallAdjusted(), problem);
}

TEST(Degenerate, CameraThatSeesNothingStillKeepsItsDistance) {
  BundleProblem problem = Small();
  problem.camera_from_world.push_back({Eigen::Quaterniond::Identity(), {1, 2, 3}});
  problem.camera_is_fixed.push_back(0);
  problem.distances = {{4, 5, 2.5}};
  const BundleSummary summary = AdjustBundle({}, problem);
  EXPECT_TRUE(summary.converged) << summary.message;
  const double distance =
      (problem.camera_from_world[4].inverse().translation - problem.camera_from_world[5].inverse().translation).norm();
  EXPECT_NEAR(distance, 2.5, 2.5e-9);
}

TEST(Degenerate, ObservationFromBehindIsLeftOutAndCounted) {
  BundleProblem problem = Small();
  problem.points.push_back(problem.camera_from_world[3].inverse() * Eigen::Vector3d(0.5, 0.5, -4));
  problem.observations.push_back({3, static_cast<int>(problem.points.size()) - 1, {300, 200}, 1.0});
  const BundleSummary summary = AdjustBundle({}, problem);
  EXPECT_TRUE(summary.converged);
  EXPECT_NE(summary.message.find("left out 1 observation"), std::string::npos) << summary.message;
  ExpectCamerasAsIn(SmallAdjusted(), problem);
}

TEST(Degenerate, PointAtTheCamerasOwnCentreIsLeftOut) {
  BundleProblem problem = Small();
  problem.points.push_back(problem.camera_from_world[0].inverse().translation);
  problem.observations.push_back({0, static_cast<int>(problem.points.size()) - 1, {300, 200}, 1.0});
  EXPECT_TRUE(AdjustBundle({}, problem).converged);
  ExpectFinite(problem);
}

TEST(Degenerate, StepThatWouldPassBehindTheCameraStaysInFront) {
  // A point just in front of the camera whose pixels say it is far away: the full step overshoots wildly.
  for (const double depth : {0.01, 0.05, 300.0, 1e6}) {
    BundleProblem problem = Small();
    const Eigen::Vector3d truth = problem.points[0];
    const int camera = problem.observations[0].camera;
    ASSERT_EQ(problem.observations[0].point, 0);
    const RigidTransform world_from_camera = problem.camera_from_world[camera].inverse();
    problem.points[0] = world_from_camera.translation + depth * (truth - world_from_camera.translation).normalized();
    BundleOptions options;
    options.max_iterations = 50;
    const BundleSummary summary = AdjustBundle(options, problem);
    ExpectFinite(problem);
    EXPECT_TRUE(std::isfinite(summary.final_cost));
    EXPECT_LE(summary.final_cost, summary.initial_cost);
    for (const BundleObservation& seen : problem.observations) {
      if (seen.point != 0 || seen.camera != camera) continue;
      EXPECT_GT((problem.camera_from_world[camera] * problem.points[0]).z(), 0) << "depth " << depth;
    }
    BundleProblem undisturbed = Small();
    EXPECT_NEAR(summary.final_cost, AdjustBundle(options, undisturbed).final_cost, 5.0) << "depth " << depth;
  }
}

TEST(Degenerate, EverythingFixedButThePoints) {
  BundleProblem problem = Small();
  problem.camera_is_fixed.assign(5, 1);
  const BundleSummary summary = AdjustBundle({}, problem);
  EXPECT_TRUE(summary.converged) << summary.message;
  EXPECT_LT(summary.final_cost, 0.99 * summary.initial_cost);
}

TEST(Degenerate, NothingToSee) {
  BundleProblem problem = Small();
  problem.observations.clear();
  problem.points.clear();
  const BundleSummary summary = AdjustBundle({}, problem);
  EXPECT_TRUE(summary.converged);
  EXPECT_EQ(summary.final_cost, 0.0);
}

TEST(Degenerate, ContradictingDistancesEndWithoutSuccess) {
  BundleProblem problem = Small();
  problem.distances = {{2, 3, 1.0}, {3, 4, 1.0}, {2, 4, 5.0}};
  BundleOptions options;
  options.max_iterations = 30;
  const BundleSummary summary = AdjustBundle(options, problem);
  EXPECT_FALSE(summary.converged);
  EXPECT_GT(summary.constraint_residual, 1e-3);
  ExpectFinite(problem);
}

/// The message of the Error that AdjustBundle throws; empty where it throws none.
template <class Error>
std::string Complaint(BundleProblem problem, const BundleOptions& options = {}) {
  try {
    AdjustBundle(options, problem);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

template <class Error>
void ExpectComplaint(const char* name, const std::function<void(BundleProblem&)>& spoil) {
  BundleProblem problem = Small();
  spoil(problem);
  const std::string complaint = Complaint<Error>(problem);
  EXPECT_NE(complaint.find(name), std::string::npos) << name << ": " << complaint;
}

TEST(Degenerate, WhatIsNoNumberIsNamed) {
  const auto expect = ExpectComplaint<NumericalError>;
  expect("pinhole.fx", [](BundleProblem& p) { p.pinhole.fx = -1; });
  expect("pinhole.fy", [](BundleProblem& p) { p.pinhole.fy = kNaN; });
  expect("pinhole.cx", [](BundleProblem& p) { p.pinhole.cx = kNaN; });
  expect("camera_from_world[2]", [](BundleProblem& p) { p.camera_from_world[2].translation.x() = kNaN; });
  expect("unit quaternion", [](BundleProblem& p) { p.camera_from_world[2].rotation.coeffs() *= 2; });
  expect("points[7]", [](BundleProblem& p) { p.points[7].z() = kNaN; });
  expect("observations[3].pixel", [](BundleProblem& p) { p.observations[3].pixel.x() = kNaN; });
  expect("at the same position", [](BundleProblem& p) {
    p.camera_from_world[3] = p.camera_from_world[2];
    p.distances = {{2, 3, 1.0}};
  });
  EXPECT_EQ(Complaint<std::exception>(Small()), "");
}

TEST(Degenerate, MistakesOfTheCallerAreNamed) {
  const auto expect = ExpectComplaint<InternalError>;
  expect("camera_is_fixed has 4 entries", [](BundleProblem& p) { p.camera_is_fixed.pop_back(); });
  expect("fixes no camera", [](BundleProblem& p) { p.camera_is_fixed.assign(5, 0); });
  expect("observations[3] names camera 5", [](BundleProblem& p) { p.observations[3].camera = 5; });
  expect("observations[3] names camera -1", [](BundleProblem& p) { p.observations[3].camera = -1; });
  expect("observations[3] names point 60", [](BundleProblem& p) { p.observations[3].point = 60; });
  expect("observations[3].sigma", [](BundleProblem& p) { p.observations[3].sigma = 0; });
  expect("distances[0] names a camera", [](BundleProblem& p) { p.distances = {{2, 9, 1.0}}; });
  expect("distances[0] constrains the distance of a camera", [](BundleProblem& p) { p.distances = {{2, 2, 1.0}}; });
  expect("distances[0] constrains the distance of two fixed", [](BundleProblem& p) { p.distances = {{0, 1, 1.0}}; });
  expect("distances[0].distance", [](BundleProblem& p) { p.distances = {{2, 3, 0.0}}; });
  expect("distances[0].distance", [](BundleProblem& p) { p.distances = {{2, 3, kNaN}}; });
  expect("cameras 2 and 3 twice", [](BundleProblem& p) { p.distances = {{2, 3, 1.0}, {3, 2, 1.0}}; });
  expect("measured_distances[0] names a camera", [](BundleProblem& p) { p.measured_distances = {{{2, 9, 1.0}, 0.1}}; });
  expect("measured_distances[0].sigma", [](BundleProblem& p) { p.measured_distances = {{{2, 3, 1.0}, 0.0}}; });
  expect(" at bundle/bundle_problem.cpp:", [](BundleProblem& p) { p.camera_is_fixed.pop_back(); });
}

TEST(Degenerate, TryingForgivesNumbersAndNoMistakes) {
  BundleProblem astray = Small();
  astray.points[7].z() = kNaN;
  EXPECT_FALSE(TryAdjustBundle({}, astray));
  BundleProblem mistaken = Small();
  mistaken.observations[3].camera = 5;
  EXPECT_THROW(TryAdjustBundle({}, mistaken), InternalError);
}

TEST(Degenerate, BadOptionsAreRefusedByName) {
  const auto expect = [](const char* name, const auto& spoil) {
    BundleOptions options;
    spoil(options);
    EXPECT_NE(Complaint<InputError>(Small(), options).find(name), std::string::npos) << name;
  };
  expect("max_iterations", [](BundleOptions& o) { o.max_iterations = -1; });
  expect("huber_threshold", [](BundleOptions& o) { o.huber_threshold = kNaN; });
  expect("relative_cost_tolerance", [](BundleOptions& o) { o.relative_cost_tolerance = -1; });
  expect("kkt_tolerance", [](BundleOptions& o) { o.kkt_tolerance = kNaN; });
  expect("initial_damping", [](BundleOptions& o) { o.initial_damping = -1; });
}

}  // namespace
}  // namespace turnscale

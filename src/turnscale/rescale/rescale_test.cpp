// SPDX-License-Identifier: MIT
#include "turnscale/rescale/rescale.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/rescale/test_rescale_drive.h"

namespace turnscale {
namespace {

TEST(Rescale, FindsTheMetreOfAPerfectDrive) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(6), kCar, kIdentity, kUnit);
  for (const bool drifting : {true, false}) {
    RescaleOptions options = OptionsFor(kCar);
    options.drifting = drifting;
    const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
    ASSERT_TRUE(result.observable) << result.reason;
    EXPECT_LT(WorstLogError(result, drive), 0.0014)
        << "steps of two poses are no single circle where the curvature changes";
    EXPECT_EQ(result.estimate->turns.size(), 6u);
    EXPECT_NEAR(result.estimate->car.side_slip, kCar.side_slip, 2e-4);
    EXPECT_NEAR(result.estimate->car.yaw_error, 0, 5e-5);
  }
}

TEST(Rescale, AnyUnitGivesTheSameMetres) {
  const ScaledDrive a = MakeScaledDrive(CityRoute(5), kCar, kIdentity, 1.0, {.position = 0.004}, 3);
  const ScaledDrive b = MakeScaledDrive(CityRoute(5), kCar, kIdentity, 250.0, {.position = 0.004}, 3);
  const RescaleResult in_a = RescaleTrajectory(OptionsFor(kCar), a.trajectory);
  const RescaleResult in_b = RescaleTrajectory(OptionsFor(kCar), b.trajectory);
  ASSERT_TRUE(in_a.observable && in_b.observable);
  EXPECT_NEAR(in_a.length, in_b.length, 1e-6 * in_a.length);
}

double RootMeanSquare(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// What one scale for the whole drive leaves at best.
double SpreadOfLogScale(const ScaledDrive& drive) {
  double mean = 0;
  for (const double scale : drive.metres_per_unit) mean += std::log(scale);
  mean /= static_cast<double>(drive.metres_per_unit.size());
  std::vector<double> off;
  for (const double scale : drive.metres_per_unit) off.push_back(std::log(scale) - mean);
  return RootMeanSquare(off);
}

TEST(Rescale, FollowsADriftAndSaysHowWell) {
  double inside = 0;
  double count = 0;
  double followed = 0;
  double constant = 0;
  for (const std::uint64_t seed : {11, 12, 13, 14, 15, 16}) {
    const ScaledDrive drive = MakeScaledDrive(CityRoute(16), kCar, kIdentity, kUnit,
                                              {.position = 0.006, .rotation = 0.0003, .drift = 0.002}, seed);
    RescaleOptions options = OptionsFor(kCar);
    options.car.lever_arm_sigma = 0;  // the tape is exact here
    options.estimator.drift.per_100m = 0.02;
    const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
    ASSERT_TRUE(result.observable) << result.reason;
    EXPECT_TRUE(result.estimate->converged);
    std::vector<double> errors;
    for (std::size_t i = 0; i < result.poses.size(); ++i) {
      errors.push_back(std::log(result.poses[i].metres_per_unit / drive.metres_per_unit[i]));
      inside += std::abs(errors.back()) <= result.poses[i].sigma ? 1 : 0;
      ++count;
    }
    followed += RootMeanSquare(errors);
    constant += SpreadOfLogScale(drive);
  }
  EXPECT_LT(followed, 0.5 * constant);
  EXPECT_GT(inside / count, 0.55);
  // Sigma allows for errors of a turn that these drives do not have.
  EXPECT_LT(inside / count, 0.93);
}

double StepLength(const Trajectory& path, std::size_t i) {
  return (path[i].world_from_camera.translation - path[i - 1].world_from_camera.translation).norm();
}

TEST(Rescale, MetricTrajectoryIsTheDriveInMetres) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(6), kCar, kIdentity, kUnit, {.drift = 0.001}, 4);
  const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), drive.trajectory);
  ASSERT_TRUE(result.observable);
  ASSERT_EQ(result.metric.size(), drive.trajectory.size());
  double length = 0;
  for (std::size_t i = 1; i < result.metric.size(); ++i) {
    const double step = StepLength(result.metric, i);
    length += step;
    EXPECT_NEAR(step / (drive.metres_per_unit[i] * StepLength(drive.trajectory, i)), 1, 0.032);
    const double scale = step / StepLength(drive.trajectory, i);
    const auto [low, high] = std::minmax(result.poses[i - 1].metres_per_unit, result.poses[i].metres_per_unit);
    EXPECT_GT(scale, low - 1e-9 * kUnit);
    EXPECT_LT(scale, high + 1e-9 * kUnit);
    EXPECT_EQ(result.metric[i].time, drive.trajectory[i].time);
    EXPECT_EQ(result.metric[i].world_from_camera.rotation.coeffs(),
              drive.trajectory[i].world_from_camera.rotation.coeffs());
  }
  EXPECT_NEAR(result.length / length, 1, 1e-4);
}

TEST(Rescale, FilteredScaleBeginsInsideTheFirstTurn) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(6), kCar, kIdentity, kUnit, {.position = 0.004}, 9);
  const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), drive.trajectory);
  ASSERT_TRUE(result.observable);
  const PosesOfTurn first = PosesOf(result, 0);
  for (int i = 0; i <= first.first; ++i) EXPECT_EQ(result.poses[i].filtered_metres_per_unit, 0);
  const RescaledPose& at_end = result.poses[first.last];
  EXPECT_NEAR(at_end.filtered_metres_per_unit / kUnit, 1, 0.006);
  EXPECT_GT(at_end.filtered_sigma, result.poses.back().sigma);
  EXPECT_EQ(result.poses[first.last - 1].filtered_sigma > 0, true) << "before the turn is over";
  for (std::size_t i = first.last; i < result.poses.size(); ++i) EXPECT_GT(result.poses[i].filtered_sigma, 0);
}

TEST(Rescale, TheWayAcrossAGapIsThatOfTheSpeedsBesideIt) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(4), kCar, kIdentity, kUnit, {.position = 0.002}, 3);
  // The straight before the second corner, at 9 m/s: three seconds are lost, and then the unit is a third.
  constexpr int kFirst = 118;
  constexpr int kAfter = 148;
  Trajectory path;
  for (int i = 0; i < static_cast<int>(drive.trajectory.size()); ++i) {
    StampedPose pose = drive.trajectory[i];
    if (i >= kAfter) pose.world_from_camera.translation *= 3;
    if (i < kFirst || i >= kAfter) path.push_back(pose);
  }
  const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), path, {{kFirst, 0.4}});
  ASSERT_TRUE(result.observable) << result.reason;
  const auto place = [&](int i) { return result.metric[i].world_from_camera.translation; };
  const double way = kUnit * (drive.trajectory[kAfter].world_from_camera.translation -
                              drive.trajectory[kFirst - 1].world_from_camera.translation)
                                 .norm();
  EXPECT_NEAR((place(kFirst) - place(kFirst - 1)).norm(), way, 0.1 * way);
  EXPECT_DOUBLE_EQ(result.gap_length, (place(kFirst) - place(kFirst - 1)).norm());
}

TEST(Rescale, KnowsHowLongTheWayWas) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(8), kCar, kIdentity, kUnit, {.position = 0.003}, 9);
  const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), drive.trajectory);
  ASSERT_TRUE(result.observable);
  double length = 0;
  for (std::size_t i = 1; i < drive.trajectory.size(); ++i)
    length += kUnit * (drive.trajectory[i].world_from_camera.translation -
                       drive.trajectory[i - 1].world_from_camera.translation)
                          .norm();
  EXPECT_NEAR(std::log(result.length / length), 0, 0.005);
  EXPECT_LT(result.estimate->length_sigma, 0.05);
}

}  // namespace
}  // namespace turnscale

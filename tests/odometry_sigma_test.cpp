// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "odometry_run.h"
#include "street_drive.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/drive_scale.h"
#include "turnscale/run/run_summary.h"

namespace turnscale {
namespace {

// Small images, which make a drive cheap.
StreetDriveOptions SmallStreet() { return {.width = 320, .height = 128}; }

// A car that drives through the turns as the rendered one: what its tyres slip at that speed it has in length.
constexpr double kSpeedInTurns = 3.2;  // m/s
constexpr double kCarSlip = kUsualSideSlip;
constexpr double kCarLength = kStreetLeverArm + kCarSlip * kSpeedInTurns * kSpeedInTurns;

// What is told of the car, wrong by so many standard deviations of what is stated of each.
VehicleOptions ToldWrong(double lever_arm, double side_slip, double yaw, const Eigen::Quaterniond& mount) {
  VehicleOptions vehicle;
  vehicle.lever_arm = kCarLength + lever_arm * kTapeSigma;
  vehicle.side_slip = kCarSlip + side_slip * vehicle.side_slip_sigma;
  vehicle.vehicle_from_camera = RotationFromYawPitchRoll({yaw * vehicle.yaw_sigma, 0, 0}) * mount;
  vehicle.calibrate_camera = false;
  return vehicle;
}

// The map does not depend on what is told of the car, so that one drive does for all of it.
RefinedScale ScaleOf(const Map& map, const VehicleOptions& vehicle) {
  OdometryOptions options;
  options.vehicle = vehicle;
  DriveScale scale(options);
  scale.Add(map);
  return scale.Refine(map);
}

double LengthOf(const std::vector<Eigen::Vector3d>& places) {
  double length = 0;
  for (size_t i = 1; i < places.size(); ++i) length += (places[i] - places[i - 1]).norm();
  return length;
}

// Error of the logarithm of the path's length from keyframe to keyframe.
double LengthError(const RefinedScale& refined, const Map& map, const StreetDrive& drive) {
  std::vector<Eigen::Vector3d> truth;
  for (const Keyframe& keyframe : map.keyframes) truth.push_back(drive.world_from_camera[keyframe.frame].translation);
  return std::log(LengthOf(refined.path.centres) / LengthOf(truth));
}

TEST(OdometrySigma, CoversWhatTheCarIsToldWrong) {
  const auto mount = [](double yaw, double pitch, double roll) {
    return RotationFromYawPitchRoll({yaw / kDegreesPerRadian, pitch / kDegreesPerRadian, roll / kDegreesPerRadian});
  };
  std::vector<StreetDriveOptions> streets(4, SmallStreet());
  for (unsigned i = 0; i < streets.size(); ++i) streets[i].noise = i;
  streets[1].vehicle_from_camera = mount(3, -4, 1);
  streets[2].vehicle_from_camera = mount(-5, 3, -2);
  streets[2].frames = streets[3].frames = 75;
  // Means of eight parts of the normal distribution, each as likely as the others.
  const std::vector<double> normal = {-1.65, -0.90, -0.49, -0.16, 0.16, 0.49, 0.90, 1.65};
  std::vector<double> deviations;
  for (size_t street = 0; street < streets.size(); ++street) {
    const StreetDrive drive = RenderStreetDrive(streets[street]);
    const Eigen::Quaterniond& turned = streets[street].vehicle_from_camera;
    OdometryOptions options;
    options.vehicle = ToldWrong(0, 0, 0, turned);
    // The map alone, from which the scale is computed again, does not tell the height above the road.
    options.road.enabled = false;
    const OdometryRun run = RunOdometry(options, drive);
    ASSERT_TRUE(run.scale.estimate) << run.scale.reason;
    const RefinedScale again = ScaleOf(run.map, options.vehicle);
    ASSERT_TRUE(again.estimate) << again.reason;
    EXPECT_NEAR(again.estimate->length_sigma, run.scale.estimate->length_sigma, 1e-9);
    EXPECT_NEAR(LengthOf(again.path.centres), LengthOf(run.scale.path.centres), 1e-6);
    for (size_t i = 0; i < normal.size(); ++i) {
      const VehicleOptions told =
          ToldWrong(normal[i], normal[(3 * i + street) % 8], normal[(5 * i + 2 * street) % 8], turned);
      const RefinedScale refined = ScaleOf(run.map, told);
      ASSERT_TRUE(refined.estimate) << refined.reason;
      EXPECT_FALSE(refined.estimate->uses_single_turns);
      deviations.push_back(LengthError(refined, run.map, drive) / refined.estimate->length_sigma);
    }
  }
  const auto count = static_cast<double>(deviations.size());
  double sum = 0;
  double squares = 0;
  for (const double deviation : deviations) {
    sum += deviation;
    squares += deviation * deviation;
    // Three like errors of 1.65 sigma to one side are 2.9 sigma of their sum.
    EXPECT_LT(std::abs(deviation), 2.5);
  }
  EXPECT_LT(std::abs(sum / count), 0.75) << "what the odometry has wrong is much the same in all four streets";
  EXPECT_GT(std::sqrt(squares / count), 0.7);
  EXPECT_LT(std::sqrt(squares / count), 1.2);
  const auto within_one = std::ranges::count_if(deviations, [](double d) { return std::abs(d) < 1; });
  EXPECT_GT(static_cast<double>(within_one), 0.55 * count);
  EXPECT_LT(static_cast<double>(within_one), 0.85 * count);
}

// Calibration and times are right here, but in the second turn the car turns about another point.
TEST(OdometrySigma, CoversTurnsThatContradictEachOther) {
  StreetDriveOptions street = SmallStreet();
  street.second_lever_arm = 1.9;
  const StreetDrive drive = RenderStreetDrive(street);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ASSERT_TRUE(run.scale.estimate) << run.scale.reason;
  EXPECT_TRUE(run.scale.contradicted_calibration.empty());
  EXPECT_TRUE(run.scale.estimate->test.contradicted);
  EXPECT_TRUE(run.scale.estimate->uses_single_turns);
  const RunSummary summary = SummaryOf({}, run.refined, run.scale);
  EXPECT_TRUE(std::ranges::any_of(
      summary.warnings, [](const std::string& warning) { return warning.starts_with("the turns disagree"); }));
  ASSERT_TRUE(AllPosed(run.refined));
  const double error = MeasureRun(run.refined, drive.world_from_camera).path_length;
  EXPECT_LT(std::abs(error), run.scale.estimate->length_sigma);
  for (const TurnResult& turn : run.turns) EXPECT_TRUE(turn.used) << turn.reason;

  OdometryOptions turns = StreetOptions();
  turns.scale.method = ScaleMethod::kTurns;
  const double error_of_turns = MeasureRun(RunOdometry(turns, drive).refined, drive.world_from_camera).path_length;
  EXPECT_LT(std::abs(error), std::abs(error_of_turns) + 0.001);
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/scale/image_stabilisation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/random.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/base/test_seeds.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/scale/scale_estimator.h"
#include "turnscale/scale/synthetic_steps.h"
#include "turnscale/scale/test_estimates.h"

namespace turnscale {
namespace {

CarPrior KnownCar(const LeverArm& car) {
  CarPrior prior = PriorOf(car);
  prior.side_slip_sigma = 0.1 * car.side_slip;
  return prior;
}

/// Weight of the camera's orientation at a delay, s, in that of an image.
using Stabiliser = std::function<double(double)>;

double Unstabilised(double delay) { return std::abs(delay) < 1e-9 ? 1 : 0; }

Stabiliser DelayedBy(double seconds) {
  return [=](double delay) { return delay / seconds >= 0 ? std::exp(-delay / seconds) : 0.0; };
}

Stabiliser CentredOver(double seconds) {
  return [=](double delay) { return std::exp(-0.5 * std::pow(delay / seconds, 2)); };
}

/// The poses of stabilised images, in vehicle axes, on a car that turns gradually, into turns of different speeds.
struct StabilisedDrive {
  Trajectory path;  ///< in an arbitrary unit
  double metres = 0;
};
const std::vector<double> kTurnSpeeds = {3.0, 7.0, 4.0, 8.0, 5.0, 3.5, 6.5, 7.5, 4.5, 5.5};
StabilisedDrive MakeStabilised(const Stabiliser& stabiliser, double interval, const LeverArm& car = kCar,
                               const std::vector<double>& turn_speeds = kTurnSpeeds) {
  constexpr double kBetween = 5;  // seconds of a straight
  constexpr double kMostDelay = 2.5;
  std::vector<double> headings = {0};
  std::vector<double> speeds = {6};
  const auto drive_on = [&](double seconds, double speed, const auto& rate) {
    for (int i = 0; i < static_cast<int>(seconds / interval); ++i) {
      speeds.push_back(0.9 * speeds.back() + 0.1 * speed);
      headings.push_back(headings.back() + interval * rate((i + 0.5) * interval));
    }
  };
  const auto straight = [](double) { return 0.0; };
  drive_on(kBetween, 6, straight);
  double side = 1;
  for (const double speed : turn_speeds) {
    const double seconds = 22 / speed;
    drive_on(kBetween, speed, straight);
    drive_on(seconds, speed, [&](double time) {
      return side * std::numbers::pi / seconds * std::pow(std::sin(std::numbers::pi * time / seconds), 2);
    });
    side = -side;
  }
  drive_on(kBetween, 6, straight);
  const auto facing = [](double heading) { return RotationFromVector(Eigen::Vector3d(0, heading, 0)); };
  StabilisedDrive drive;
  Eigen::Vector3d axle = Eigen::Vector3d::Zero();
  Eigen::Vector3d before;
  for (int i = 0; i < static_cast<int>(headings.size()); ++i) {
    const int most = static_cast<int>(kMostDelay / interval);
    double weights = 0;
    double heading = 0;
    for (int k = std::max(i - most, 0); k <= std::min(i + most, static_cast<int>(headings.size()) - 1); ++k) {
      const double weight = stabiliser((i - k) * interval);
      weights += weight;
      heading += weight * headings[k];
    }
    const Eigen::Vector3d camera = axle + facing(headings[i]) * Eigen::Vector3d(0, 0, car.At(speeds[i]));
    drive.path.push_back({i * interval, {facing(heading / weights), camera / kUnit}});
    if (i > 0) drive.metres += (camera - before).norm();
    before = camera;
    const double turned = i + 1 < static_cast<int>(headings.size()) ? headings[i + 1] - headings[i] : 0;
    axle += facing(headings[i] + 0.5 * turned) * Eigen::Vector3d(0, 0, speeds[i] * interval);
  }
  return drive;
}

ScaleEstimate EstimateOf(const StabilisedDrive& drive, const CarPrior& car = KnownCar(kCar)) {
  ScaleEstimateResult result = EstimateScale(CutIntoSteps(drive.path, {}, true, {}), car, {});
  EXPECT_TRUE(result.estimate) << result.reason;
  return result.estimate.value_or(ScaleEstimate{});
}

double RelativeError(const ScaleEstimate& estimate, const StabilisedDrive& drive) {
  return Metres(estimate) / drive.metres - 1;
}

TEST(ImageStabilisation, IsNotFoundWithoutOne) {
  for (const double interval : {0.03, 0.1}) {
    const StabilisedDrive drive = MakeStabilised(Unstabilised, interval);
    const ScaleEstimate estimate = EstimateOf(drive);
    EXPECT_FALSE(estimate.is_stabilised()) << interval;
    EXPECT_NEAR(RelativeError(estimate, drive), 0, 0.005) << interval;
  }
}

TEST(ImageStabilisation, AllowsForALag) {
  for (const double interval : {0.03, 0.1})
    for (const double lag : {0.06, 0.15, -0.1}) {
      const StabilisedDrive drive = MakeStabilised(DelayedBy(lag), interval);
      const ScaleEstimate estimate = EstimateOf(drive);
      ASSERT_TRUE(estimate.image_lag) << lag << ", " << interval;
      EXPECT_NEAR(estimate.image_lag->found, lag, 2 * estimate.image_lag->found_sigma + 0.5 * interval);
      EXPECT_LT(std::abs(RelativeError(estimate, drive)), 2 * estimate.length_sigma) << lag << ", " << interval;
      EXPECT_FALSE(estimate.has_reliable_car());
      EXPECT_TRUE(estimate.image_lag->is_confirmed());
      EXPECT_TRUE(estimate.image_lag->is_used);
    }
}

TEST(ImageStabilisation, SigmaCoversALagThatTwoTurnsShow) {
  const StabilisedDrive drive = MakeStabilised(DelayedBy(0.2), 0.1, kCar, {3, 8});
  const ScaleEstimate estimate = EstimateOf(drive);
  ASSERT_TRUE(estimate.image_lag);
  EXPECT_TRUE(estimate.image_lag->is_used);
  EXPECT_FALSE(estimate.image_lag->is_confirmed());
  EXPECT_GT(estimate.image_lag->scale_error, 0.1);
  EXPECT_GT(estimate.length_sigma, estimate.image_lag->scale_error) << "there may be none";
  EXPECT_LT(std::abs(RelativeError(estimate, drive)), estimate.length_sigma);
}

TEST(ImageStabilisation, SigmaCoversALagThatIsNotAdopted) {
  ScaleEstimatorOptions options;
  options.stabilisation.adopts_lag = false;
  for (const double lag : {0.15, 0.0}) {
    const StabilisedDrive drive = MakeStabilised(lag > 0 ? DelayedBy(lag) : Stabiliser(Unstabilised), 0.1);
    const ScaleEstimateResult result = EstimateScale(CutIntoSteps(drive.path, {}, true, {}), KnownCar(kCar), options);
    ASSERT_TRUE(result.estimate) << result.reason;
    ASSERT_EQ(result.estimate->image_lag.has_value(), lag > 0);
    EXPECT_LT(std::abs(RelativeError(*result.estimate, drive)), 2 * result.estimate->length_sigma);
    if (lag == 0) continue;
    EXPECT_FALSE(result.estimate->image_lag->is_used);
    EXPECT_NEAR(result.estimate->image_lag->found, lag, 0.05);
    EXPECT_GT(std::abs(RelativeError(*result.estimate, drive)), 0.1) << "as if there were none";
  }
}

TEST(ImageStabilisation, ADelayAloneIsNoSmoothing) {
  constexpr double kSeconds = 0.3;
  const auto delayed = [](double delay) { return std::abs(delay - kSeconds) < 1e-9 ? 1.0 : 0.0; };
  const StabilisedDrive drive = MakeStabilised(delayed, 0.1);
  CarPrior car = KnownCar(kCar);
  car.image_lag_sigma = 0.2;
  const ScaleEstimate estimate = EstimateOf(drive, car);
  ASSERT_TRUE(estimate.image_lag);
  EXPECT_NEAR(estimate.image_lag->found, kSeconds, 0.05);
  EXPECT_FALSE(estimate.image_smoothing);
}

TEST(ImageStabilisation, SigmaCoversSmoothing) {
  for (const double interval : {0.03, 0.1})
    for (const double smoothing : {0.4, 0.6}) {
      const StabilisedDrive drive = MakeStabilised(CentredOver(smoothing), interval);
      const ScaleEstimate estimate = EstimateOf(drive);
      ASSERT_TRUE(estimate.image_smoothing) << smoothing << ", " << interval;
      EXPECT_NEAR(std::sqrt(estimate.image_smoothing->variance), smoothing, 0.3 * smoothing);
      EXPECT_LT(RelativeError(estimate, drive), -0.01) << "turns are slower in the images";
      EXPECT_LT(std::abs(RelativeError(estimate, drive)), 2 * estimate.length_sigma);
      EXPECT_FALSE(estimate.has_reliable_car());
    }
}

TEST(ImageStabilisation, SmoothingLeavesALagInDoubt) {
  const StabilisedDrive drive = MakeStabilised(CentredOver(0.5), 0.1);
  CarPrior without_lag = KnownCar(kCar);
  without_lag.image_lag_sigma = 1e-4;
  const ScaleEstimate certain = EstimateOf(drive, without_lag);
  const ScaleEstimate doubtful = EstimateOf(drive);
  ASSERT_TRUE(certain.image_smoothing && doubtful.image_smoothing);
  EXPECT_GT(doubtful.image_smoothing->scale_error, certain.image_smoothing->scale_error + 0.005);
  EXPECT_GT(doubtful.length_sigma, certain.length_sigma);
}

TEST(ImageStabilisation, SmoothingIsNotLookedForWithAGivenHeight) {
  const StabilisedDrive drive = MakeStabilised(CentredOver(0.5), 0.1);
  CarPrior car = KnownCar(kCar);
  car.camera_height = 1.4;
  car.camera_height_sigma = 0.014;
  EXPECT_FALSE(EstimateOf(drive, car).image_smoothing);
}

TEST(ImageStabilisation, IsLookedForUnlessDisabled) {
  const std::vector<VehicleStep> steps = CutIntoSteps(MakeStabilised(DelayedBy(0.15), 0.1).path, {}, true, {});
  ScaleEstimatorOptions options;
  options.uses_single_turns = true;
  ScaleEstimateResult result = EstimateScale(steps, KnownCar(kCar), options);
  ASSERT_TRUE(result.estimate) << result.reason;
  EXPECT_TRUE(result.estimate->image_lag) << "of single-turn scales, too";
  options.stabilisation.enabled = false;
  result = EstimateScale(steps, KnownCar(kCar), options);
  ASSERT_TRUE(result.estimate) << result.reason;
  EXPECT_FALSE(result.estimate->is_stabilised());
}

TEST(ImageStabilisation, AKnownStabilisationIsAllowedForFromTheStart) {
  CarPrior car = KnownCar(kCar);
  car.image_lag_sigma = 0.2;
  const StabilisedDrive unstabilised = MakeStabilised(Unstabilised, 0.1);
  const ScaleEstimate unknown = EstimateOf(unstabilised);
  const ScaleEstimate known = EstimateOf(unstabilised, car);
  ASSERT_TRUE(known.image_lag);
  EXPECT_NEAR(known.image_lag->found, 0, 2 * known.image_lag->found_sigma);
  EXPECT_LT(std::abs(RelativeError(known, unstabilised)), 2 * known.length_sigma);
  EXPECT_GT(known.length_sigma, 1.5 * unknown.length_sigma) << "it has to be found out that there is no lag";
}

// With what is told of the car wrong by up to two of its standard deviations.
TEST(ImageStabilisation, TurnsOfOneSpeedAreNeverTakenForALag) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  Random random(3);
  for (int seed = 0; seed < 200; ++seed) {
    std::vector<StretchOfRoad> road;
    for (int turn = 0; turn < 2 + seed % 3; ++turn) {
      road.push_back({20, 0, 4, 8});
      road.push_back({25, (random.Chance(0.5) ? 3.5 : -3.5) * kDegree, 0.3, 3.2});
    }
    road.push_back({20, 0, 4, 8});
    const double yaw = kEstimatedYawSigma * random.Uniform(-2, 2);
    const SyntheticSteps drive = MakeSteps(road, kCar, yaw, kUnit, AsStated({}), seed);
    CarPrior car;
    car.lever_arm = kCar.length + kTapeSigma * random.Uniform(-2, 2);
    car.side_slip = std::max(kCar.side_slip + kUsualSideSlipSigma * random.Uniform(-2, 2), 0.0);
    const ScaleEstimateResult result = EstimateScale(drive.steps, car, {});
    ASSERT_TRUE(result.estimate) << result.reason;
    EXPECT_FALSE(result.estimate->image_lag) << seed;
  }
}

TEST(ImageStabilisation, TheLagOfAnEarlierDriveIsUsedWithTurnsOfOneSpeed) {
  std::vector<StretchOfRoad> road;
  for (const double side : {1.0, -1.0}) {
    road.push_back({20, 0, 4, 8});
    road.push_back({25, side * 3.5 * kDegree, 0.5, 6});
  }
  road.push_back({20, 0, 4, 8});
  const SyntheticSteps drive = MakeSteps(road, kCar, 0, kUnit, {.direction = 0.2 * kDegree, .lag = 0.1});
  CarPrior car = KnownCar(kCar);
  car.image_lag = 0.11;
  car.image_lag_sigma = 0.02;
  const ScaleEstimateResult result = EstimateScale(drive.steps, car, {});
  ASSERT_TRUE(result.estimate) << result.reason;
  EXPECT_LT(std::abs(Metres(*result.estimate) / drive.metres - 1), 2 * result.estimate->length_sigma);
  EXPECT_LT(std::abs(Metres(*result.estimate) / drive.metres - 1), 0.08);
}

TEST(ImageStabilisation, NeedsTimes) {
  for (const Stabiliser& stabiliser : {DelayedBy(0.15), CentredOver(0.5)}) {
    std::vector<VehicleStep> steps = CutIntoSteps(MakeStabilised(stabiliser, 0.1).path, {}, true, {});
    for (VehicleStep& step : steps) step.duration = 0;
    const ScaleEstimateResult result = EstimateScale(steps, KnownCar(kCar), {});
    ASSERT_TRUE(result.estimate) << result.reason;
    EXPECT_FALSE(result.estimate->is_stabilised());
  }
}

TEST(ImageStabilisation, ALagNeedsTurnsOfDifferentSpeeds) {
  std::vector<StretchOfRoad> road;
  for (const double side : {1.0, -1.0, 1.0, -1.0}) {
    road.push_back({20, 0, 4, 8});
    road.push_back({25, side * 3.5 * kDegree, 0.5, 6});
  }
  road.push_back({20, 0, 4, 8});
  const SyntheticSteps drive = MakeSteps(road, kCar, 0, kUnit, {.direction = 0.2 * kDegree, .lag = 0.1});
  const ScaleEstimateResult result = EstimateScale(drive.steps, KnownCar(kCar), {});
  ASSERT_TRUE(result.estimate) << result.reason;
  EXPECT_FALSE(result.estimate->image_lag);
}

TEST(ImageStabilisation, ALagIsFoundInReverseToo) {
  constexpr LeverArm kRigid{1.5, 0};  // slip is not the same on the way back
  StabilisedDrive drive = MakeStabilised(DelayedBy(0.15), 0.1, kRigid);
  // On the way back, what lagged behind is ahead.
  const double end = drive.path.back().time;
  std::ranges::reverse(drive.path);
  for (StampedPose& pose : drive.path) pose.time = end - pose.time;
  const ScaleEstimate estimate = EstimateOf(drive, KnownCar(kRigid));
  ASSERT_TRUE(estimate.image_lag);
  EXPECT_NEAR(estimate.image_lag->found, -0.15, 0.05);
}

struct FalseAlarms {
  int lags = 0;
  int smoothings = 0;
};
FalseAlarms CountFalseAlarms(int drives, const DriveErrors& errors, const CarPrior& car) {
  FalseAlarms count;
  for (int seed = 0; seed < drives; ++seed) {
    const SyntheticSteps drive = MakeSteps(TownRoad(8, seed), kCar, 0, kUnit, errors, seed);
    const ScaleEstimateResult result = EstimateScale(drive.steps, car, {});
    if (!result.estimate) {
      count.lags += result.reason.starts_with("the images seem to be stabilised") ? 1 : 0;
      continue;
    }
    count.lags += result.estimate->image_lag ? 1 : 0;
    count.smoothings += result.estimate->image_smoothing ? 1 : 0;
  }
  return count;
}

TEST(ImageStabilisation, OtherErrorsAreSeldomTakenForIt) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  constexpr int kDrives = 200;
  const DriveErrors as_stated = AsStated({});
  DriveErrors scattered = as_stated;
  scattered.lever_arm = 0.06;
  CarPrior wrong_slip = KnownCar(kCar);
  wrong_slip.side_slip = 1.24 * kCar.side_slip;
  wrong_slip.side_slip_sigma = 0.12 * kCar.side_slip;
  for (const auto& [errors, car, most] : {std::tuple{as_stated, KnownCar(kCar), 0.01},
                                          {as_stated, KnownCar({1.1 * kCar.length, kCar.side_slip}), 0.02},
                                          {as_stated, wrong_slip, 0.02},
                                          {scattered, KnownCar(kCar), 0.05}}) {
    const FalseAlarms found = CountFalseAlarms(kDrives, errors, car);
    EXPECT_LE(found.lags, most * kDrives);
    EXPECT_EQ(found.smoothings, 0);
  }
}

TEST(ImageStabilisation, AWrongLengthIsNoLagWhereTheHeightIsGiven) {
  int lags = 0;
  for (int seed = 0; seed < SeedsToTest(20); ++seed)
    for (const double factor : {0.8, 1.2}) {
      SyntheticSteps drive = MakeSteps(TownRoad(8, seed), kCar, 0, kUnit, kNoise, seed);
      ShowRoad(1.4, {.step = 0.01, .road = 0.01}, seed, drive);
      CarPrior wrong = KnownCar({factor * kCar.length, kCar.side_slip});
      wrong.camera_height = 1.4;
      wrong.camera_height_sigma = 0.014;
      const ScaleEstimateResult result = EstimateScale(drive.steps, wrong, {});
      ASSERT_TRUE(result.estimate) << result.reason;
      lags += result.estimate->image_lag ? 1 : 0;
    }
  EXPECT_LE(lags, 1);
}

TEST(StabilisationOptions, RefusesSenselessValues) {
  const auto refused = [](auto change) { return RefusedField<StabilisationOptions>(change); };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_EQ(refused([](auto& o) { o.min_lag_deviation = 0; }), "min_lag_deviation");
  EXPECT_EQ(refused([](auto& o) { o.min_lag_deviation_with_less_scatter = 4; }), "min_lag_deviation_with_less_scatter");
  EXPECT_EQ(refused([](auto& o) { o.min_reduction_significance = 0; }), "min_reduction_significance");
  EXPECT_EQ(refused([](auto& o) { o.min_scale_change = -1; }), "min_scale_change");
  EXPECT_EQ(refused([](auto& o) { o.lag_sigma = 0; }), "lag_sigma");
  EXPECT_EQ(refused([](auto& o) { o.min_lag_turns = -1; }), "min_lag_turns");
  EXPECT_EQ(refused([](auto& o) { o.max_lag_sigma = 0; }), "max_lag_sigma");
  EXPECT_EQ(refused([](auto& o) { o.min_smoothing = 0; }), "min_smoothing");
  EXPECT_EQ(refused([](auto& o) { o.min_smoothing_deviation = 0; }), "min_smoothing_deviation");
}

}  // namespace
}  // namespace turnscale

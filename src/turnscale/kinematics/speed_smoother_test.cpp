// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/speed_smoother.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"

namespace turnscale {
namespace {

constexpr double kInterval = 0.1;

// Pulls away, cruises, brakes to a stop, and reverses.
double TrueSpeed(double t) {
  if (t < 20) return 12 * std::pow(std::sin(t * M_PI / 40), 2);
  if (t < 40) return 12;
  if (t < 46) return 12 - 2 * (t - 40);
  if (t < 50) return 0;
  return -1.5 * std::pow(std::sin((t - 50) * M_PI / 20), 2);
}

struct NoisyDrive {
  std::vector<PathReading> readings;
  std::vector<double> speeds;
};

NoisyDrive DriveWithNoise(double noise, unsigned seed) {
  Random random(seed);
  NoisyDrive drive;
  double position = 0;
  constexpr int kFine = 100;
  for (int i = 0; i <= 600; ++i) {
    const double time = kInterval * i;
    drive.readings.push_back({time, position + noise * random.Gaussian(), true});
    drive.speeds.push_back(TrueSpeed(time));
    for (int k = 0; k < kFine; ++k) position += TrueSpeed(time + kInterval * (k + 0.5) / kFine) * kInterval / kFine;
  }
  return drive;
}

TEST(SpeedSmoother, FollowsTheSpeedWithinItsSigma) {
  for (const double noise : {0.001, 0.01, 0.05}) {
    const NoisyDrive drive = DriveWithNoise(noise, 7);
    const std::vector<SpeedReading> speeds = SmoothSpeed(drive.readings);
    ASSERT_EQ(speeds.size(), drive.readings.size());
    int within = 0;
    double squares = 0;
    for (size_t i = 0; i < speeds.size(); ++i) {
      const double error = speeds[i].speed - drive.speeds[i];
      squares += error * error;
      within += std::abs(error) < 2 * speeds[i].sigma ? 1 : 0;
    }
    const auto count = static_cast<double>(speeds.size());
    const double rms = std::sqrt(squares / count);
    EXPECT_GT(within / count, 0.93) << noise;
    EXPECT_LT(rms, std::max(0.25 * noise / 0.05, 0.05)) << noise;
  }
}

TEST(SpeedSmoother, AnOutlierHardlyCounts) {
  NoisyDrive drive = DriveWithNoise(0.01, 3);
  drive.readings[300].position += 5;
  const std::vector<SpeedReading> speeds = SmoothSpeed(drive.readings);
  for (size_t i = 290; i < 310; ++i) EXPECT_NEAR(speeds[i].speed, drive.speeds[i], 0.6) << i;
}

TEST(SpeedSmoother, TheSigmaGrowsWhereNothingIsMeasured) {
  NoisyDrive drive = DriveWithNoise(0.01, 5);
  for (size_t i = 250; i < 290; ++i) drive.readings[i] = {drive.readings[i].time, 0, false};
  const std::vector<SpeedReading> speeds = SmoothSpeed(drive.readings);
  EXPECT_GT(speeds[270].sigma, 3 * speeds[200].sigma);
  EXPECT_NEAR(speeds[270].speed, drive.speeds[270], 2 * speeds[270].sigma);
  EXPECT_NEAR(speeds[320].speed, drive.speeds[320], 4 * speeds[320].sigma);
}

TEST(SpeedSmoother, AGapIsAsUncertainWithFewReadingsAsWithMany) {
  const auto sigma_within = [](int every) {
    NoisyDrive drive = DriveWithNoise(0.01, 5);
    std::vector<PathReading> readings;
    for (int i = 0; i <= 600; ++i) {
      PathReading reading = drive.readings[i];
      reading.measured = i < 250 || i > 290;
      if (reading.measured || i % every == 0) readings.push_back(reading);
    }
    return SpeedAt(SmoothSpeed(readings), drive.readings[270].time).value().sigma;
  };
  EXPECT_NEAR(sigma_within(1) / sigma_within(10), 1, 0.02);
}

TEST(SpeedSmoother, ReadingsOfOneTimeAreNoFault) {
  for (const SpeedReading& reading : SmoothSpeed({{0, 0, true}, {1, 1, true}, {1, 1, true}, {2, 2, true}}))
    EXPECT_NEAR(reading.speed, 1, 0.2);
}

TEST(SpeedSmoother, TooFewReadings) {
  EXPECT_TRUE(SmoothSpeed({}).empty());
  EXPECT_TRUE(SmoothSpeed({{0, 0, true}, {1, 1, true}}).empty());
  EXPECT_TRUE(SmoothSpeed({{0, 0, true}, {1, 1, true}, {2, 2, false}}).empty());
  EXPECT_THROW(SmoothSpeed({{0, 0, false}, {1, 0, true}, {2, 2, true}, {3, 4, true}}), InternalError);
}

TEST(SpeedAt, FindsTheReadingOfATime) {
  const std::vector<SpeedReading> readings = {{0.1, 1, 0}, {0.2, 2, 0}, {0.4, 4, 0}};
  EXPECT_EQ(SpeedAt(readings, 0.2 + 1e-9)->speed, 2);
  EXPECT_EQ(SpeedAt(readings, 0.4 - 1e-9)->speed, 4);
  for (const double time : {0.0, 0.3, 0.5}) EXPECT_FALSE(SpeedAt(readings, time)) << time;
  EXPECT_FALSE(SpeedAt({}, 0.1));
}

}  // namespace
}  // namespace turnscale

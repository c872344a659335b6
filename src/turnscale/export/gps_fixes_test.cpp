// SPDX-License-Identifier: MIT
#include "turnscale/export/gps_fixes.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/base/test_files.h"
#include "turnscale/export/path_error.h"
#include "turnscale/export/test_results.h"
#include "turnscale/export/utc_time.h"
#include "turnscale/geometry/random_vector.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

const Placement kTruth{{49.0112, 8.4225, 110}, 87.5 / kDegreesPerRadian};

// One fix a second along 500 m, with 5 m of noise in each direction; every tenth is 40 to 400 m off.
std::vector<GpsFix> NoisyFixes(const std::vector<LevelPlace>& path, unsigned seed, double path_scale = 1) {
  Random random(seed);
  const GeoFrame frame(kTruth.origin);
  std::vector<GpsFix> fixes;
  for (size_t i = 0; i < path.size(); i += 10) {
    Eigen::Vector3d place = path_scale * EastNorthUp(path[i].position, kTruth.heading);
    place.head<2>() += 5 * DrawVector<2>([&] { return random.Gaussian(); });
    if (i % 100 == 30) {
      place.y() += random.Uniform(-200, 200);
      place.x() += random.Uniform(40, 400);
    }
    fixes.push_back({path[i].time, frame.FromLocal(place), 5, true});
  }
  return fixes;
}

TEST(GpsFixes, GiveTheHeadingInNoiseAndOutliers) {
  const std::vector<LevelPlace> path = LevelPath(TestResults(501), "out");
  int within = 0;
  constexpr int kSeeds = 40;
  double squares = 0;
  double total = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const FixPlacement placed = PlaceByFixes(path, NoisyFixes(path, seed));
    const double error = std::remainder(placed.placement.heading - kTruth.heading, 2 * M_PI) * kDegreesPerRadian;
    EXPECT_LT(std::abs(error), 1.0) << seed;
    within += std::abs(error) < 0.5 ? 1 : 0;
    total = std::hypot(total, error);
    squares += std::pow(error / (placed.heading_sigma * kDegreesPerRadian), 2);
    EXPECT_GE(placed.outliers, 5) << seed;
    EXPECT_LE(placed.outliers, 8) << seed;
    EXPECT_TRUE(placed.fits) << seed;
    EXPECT_LT(GeoFrame(kTruth.origin).ToLocal(placed.placement.origin).head<2>().norm(), 5) << seed;
    EXPECT_NEAR(placed.scale, 1, 4 * placed.scale_sigma) << seed;
  }
  EXPECT_GE(within, kSeeds * 9 / 10);
  EXPECT_LT(total, 0.5 * std::sqrt(kSeeds)) << "0.5 degrees RMS";
  EXPECT_LT(std::sqrt(squares / kSeeds), 1.35);
  EXPECT_GT(std::sqrt(squares / kSeeds), 0.4) << "the sigma includes drift, which this path does not have";
}

// 1.5 km with a bend, a place per metre, as an odometry of this drift gives it.
std::vector<LevelPlace> PathWithDrift(unsigned seed) {
  Random random(seed);
  std::vector<LevelPlace> path(1501);
  double heading = 0;
  double log_scale = 0;
  for (size_t i = 1; i < path.size(); ++i) {
    heading += kHeadingDriftPer100m * 0.1 * random.Gaussian();
    log_scale += kScaleDriftPer100m * 0.1 * random.Gaussian();
    const double bend = i > 700 && i < 900 ? 0.006 : 0;
    path[i].time = 0.1 * static_cast<double>(i);
    heading += bend;
    path[i].position =
        path[i - 1].position + std::exp(log_scale) * Eigen::Vector3d(std::sin(heading), std::cos(heading), 0);
  }
  return path;
}

// Those of the same drive without drift, of a receiver as accurate as this.
std::vector<GpsFix> AccurateFixes(double sigma, unsigned seed) {
  Random random(seed);
  const GeoFrame frame(kTruth.origin);
  std::vector<GpsFix> fixes;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  double heading = 0;
  for (size_t i = 0; i <= 1500; ++i) {
    if (i > 0) {
      heading += i > 700 && i < 900 ? 0.006 : 0;
      place += Eigen::Vector3d(std::sin(heading), std::cos(heading), 0);
    }
    if (i % 20 != 0) continue;
    Eigen::Vector3d seen = EastNorthUp(place, kTruth.heading);
    seen.head<2>() += sigma * DrawVector<2>([&] { return random.Gaussian(); });
    if (i % 200 == 60) seen.y() += 300;
    fixes.push_back({0.1 * static_cast<double>(i), frame.FromLocal(seen), sigma, false});
  }
  return fixes;
}

TEST(GpsFixes, AreNoOutliersForTheDriftOfThePath) {
  constexpr unsigned kSeeds = 25;
  for (const double sigma : {0.05, 1.0, 5.0}) {
    double squares = 0;
    int outliers = 0;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      const FixPlacement placed = PlaceByFixes(PathWithDrift(seed), AccurateFixes(sigma, seed + 100));
      outliers += placed.outliers;
      EXPECT_GE(placed.outliers, 8) << "gross errors";
      EXPECT_TRUE(placed.fits) << sigma << ' ' << seed;
      const double error = std::remainder(placed.placement.heading - kTruth.heading, 2 * M_PI);
      squares += std::pow(error / placed.heading_sigma, 2);
    }
    EXPECT_LT(outliers, 10 * kSeeds) << sigma;
    EXPECT_NEAR(std::sqrt(squares / kSeeds), 1, 0.35) << sigma;
  }
}

TEST(GpsFixes, TheScaleIsReportedAndNotApplied) {
  const std::vector<LevelPlace> path = LevelPath(TestResults(501), "out");
  const FixPlacement placed = PlaceByFixes(path, NoisyFixes(path, 3, 1.05));
  EXPECT_NEAR(placed.scale, 1.05, 4 * placed.scale_sigma);
  EXPECT_GT(placed.scale, 1 + 3 * placed.scale_sigma);
  EXPECT_TRUE(placed.fits);
}

TEST(GpsFixes, OfALongDriveAreNoOutliersForItsErrorOfScale) {
  std::vector<LevelPlace> path(501);
  for (size_t i = 0; i < path.size(); ++i) {
    path[i].time = static_cast<double>(i);
    path[i].position = {200 * std::sin(0.01 * static_cast<double>(i)), 10.0 * static_cast<double>(i), 0};
  }
  std::vector<GpsFix> all = NoisyFixes(path, 7, 1.03);
  std::erase_if(all, [](const GpsFix& fix) { return std::fmod(fix.time, 100) == 30; });
  for (const std::vector<GpsFix>& fixes : {all, {all.front(), all.back()}, {all[0], all[20], all.back()}}) {
    const FixPlacement placed = PlaceByFixes(path, fixes);
    EXPECT_EQ(placed.outliers, 0) << fixes.size();
    EXPECT_TRUE(placed.fits) << fixes.size();
    EXPECT_NEAR(placed.scale, 1.03, 0.004) << fixes.size();
    EXPECT_NEAR(placed.placement.heading * kDegreesPerRadian, 87.5, 0.3) << fixes.size();
    // Half of the scale's error at each end.
    EXPECT_NEAR(GeoFrame(kTruth.origin).ToLocal(placed.placement.origin).head<2>().norm(), 75, 20) << fixes.size();
  }
}

// 1.6 km through a town, with a bend of up to 100 degrees every 150 m.
std::vector<LevelPlace> TownPath(unsigned seed) {
  Random random(seed);
  std::vector<LevelPlace> path(1601);
  double heading = 0;
  double rate = 0;
  for (size_t i = 1; i < path.size(); ++i) {
    if (i % 150 == 0) rate = random.Uniform(-0.12, 0.12);
    if (i % 150 == 15) rate = 0;
    heading += rate;
    path[i].time = 0.1 * static_cast<double>(i);
    path[i].position = path[i - 1].position + Eigen::Vector3d(std::sin(heading), std::cos(heading), 0);
  }
  return path;
}

// Every `step`-th place, with 2 m of noise.
std::vector<GpsFix> TownFixes(const std::vector<LevelPlace>& path, unsigned seed, size_t step = 20) {
  Random random(seed);
  const GeoFrame frame(kTruth.origin);
  std::vector<GpsFix> fixes;
  for (size_t i = 0; i < path.size(); i += step) {
    Eigen::Vector3d place = EastNorthUp(path[i].position, kTruth.heading);
    place.head<2>() += 2 * DrawVector<2>([&] { return random.Gaussian(); });
    fixes.push_back({path[i].time, frame.FromLocal(place), 2, false});
  }
  return fixes;
}

TEST(GpsFixes, ThatAreNotOfThePathDoNotFit) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const std::vector<LevelPlace> path = TownPath(seed);
    std::vector<GpsFix> fixes = TownFixes(path, seed + 100);
    for (size_t step : {20, 160, 400}) EXPECT_TRUE(PlaceByFixes(path, TownFixes(path, seed, step)).fits) << step;
    std::vector<GpsFix> thrown = fixes;
    for (size_t i = 3; i < thrown.size(); i += 7) thrown[i].point.latitude += i % 2 == 0 ? 60 / 111e3 : -60 / 111e3;
    const FixPlacement placed = PlaceByFixes(path, thrown);
    EXPECT_NEAR(placed.outliers, 12, 2) << seed;
    EXPECT_TRUE(placed.fits) << seed;
    for (const double sigma : {2.0, 5.0}) {
      for (GpsFix& fix : fixes) fix.sigma = sigma;
      std::vector<GpsFix> swapped = fixes;
      for (GpsFix& fix : swapped) std::swap(fix.point.latitude, fix.point.longitude);
      EXPECT_FALSE(PlaceByFixes(path, swapped).fits) << seed;
      std::vector<GpsFix> late = fixes;
      for (GpsFix& fix : late) fix.time += 30;
      EXPECT_FALSE(PlaceByFixes(path, late).fits) << seed;
    }
    EXPECT_FALSE(PlaceByFixes(path, TownFixes(TownPath(seed + 50), seed, 100)).fits) << seed;
  }
}

TEST(GpsFixes, TenPerSecondForAnHour) {
  std::vector<LevelPlace> path(36000);
  for (size_t i = 0; i < path.size(); ++i) {
    path[i].time = 0.1 * static_cast<double>(i);
    path[i].position = {3000 * std::sin(1e-3 * path[i].time), 10 * path[i].time, 2};
  }
  Random random(5);
  const GeoFrame frame(kTruth.origin);
  std::vector<GpsFix> fixes;
  for (size_t i = 0; i < path.size(); ++i) {
    Eigen::Vector3d place = EastNorthUp(path[i].position, kTruth.heading);
    place += DrawVector<3>([&] { return random.Gaussian(); }).cwiseProduct(Eigen::Vector3d(5, 5, 8));
    if (i % 10 == 3) place += Eigen::Vector3d(300, -200, 500);
    GeoPoint point = frame.FromLocal(place);
    // Above the sea, which is not the ellipsoid; and not in all of them.
    point.height = 110 + place.z();
    fixes.push_back({path[i].time, point, 5, i % 2 == 0});
  }
  const FixPlacement placed = PlaceByFixes(path, fixes);
  EXPECT_NEAR(placed.placement.heading, kTruth.heading, 2e-5);
  EXPECT_NEAR(placed.outliers, 3600, 10);
  EXPECT_TRUE(placed.fits);
  EXPECT_TRUE(placed.has_height);
  EXPECT_NEAR(placed.placement.origin.height, 110, 2);
}

TEST(GpsFixes, HeightsGiveTheMeanSlope) {
  const std::vector<LevelPlace> path = LevelPath(TestResults(501), "out");
  std::vector<GpsFix> fixes = NoisyFixes(path, 2);
  constexpr double kSlope = 0.05;
  for (GpsFix& fix : fixes) {
    fix.point.height = 110 + kSlope * path[std::lround(10 * fix.time)].position.y();
    fix.sigma = 1;
  }
  const FixPlacement placed = PlaceByFixes(path, fixes);
  const std::vector<GeoPlace> places = PlaceOnEarth(path, placed.placement);
  EXPECT_NEAR(places.front().point.height, 110, 0.5);
  EXPECT_NEAR(places[300].point.height - places[0].point.height, kSlope * path[300].position.y(), 0.5);
  for (GpsFix& fix : fixes) fix.has_height = false;
  const FixPlacement level = PlaceByFixes(path, fixes);
  EXPECT_FALSE(level.has_height);
  EXPECT_NEAR(PlaceOnEarth(path, level.placement)[300].point.height, 0, 0.1);
}

TEST(GpsFixes, NeedABaseline) {
  const std::vector<LevelPlace> path = LevelPath(TestResults(501), "out");
  std::vector<GpsFix> fixes = NoisyFixes(path, 1);
  EXPECT_THROW(PlaceByFixes(path, {fixes[0], fixes[1]}), InputError);
  EXPECT_THROW(PlaceByFixes(path, {fixes[0]}), InputError);
  for (GpsFix& fix : fixes) fix.time += 1000;
  EXPECT_THROW(PlaceByFixes(path, fixes), InputError);
}

TEST(GpsFixes, TooNearOnThePathButNotOnEarthNameWhatToCheck) {
  const std::vector<LevelPlace> path = LevelPath(TestResults(501), "out");
  const auto refusal = [&](const std::vector<GpsFix>& fixes) -> std::string {
    try {
      PlaceByFixes(path, fixes);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  std::vector<GpsFix> fixes = NoisyFixes(path, 1);
  fixes.resize(2);
  EXPECT_NE(refusal(fixes).find("give some from farther along the drive"), std::string::npos) << refusal(fixes);
  std::swap(fixes[1].point.latitude, fixes[1].point.longitude);
  EXPECT_NE(refusal(fixes).find("check the order of latitude and longitude"), std::string::npos) << refusal(fixes);
}

class GpsFixFileTest : public ::testing::Test {
 protected:
  GpsFixFileTest() : path_(ScratchPath("fixes.csv")) {}
  ~GpsFixFileTest() override { fs::remove(path_); }

  std::vector<GpsFix> Read(const std::string& text, std::optional<double> start = {}) const {
    std::ofstream(path_) << text;
    return ReadGpsFixes(path_, start);
  }
  std::string Refusal(const std::string& text) const {
    try {
      Read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path path_;
};

TEST_F(GpsFixFileTest, ReadsSecondsAndTimesOfDay) {
  const auto fixes = Read("time,latitude,longitude,sigma\n1.5,49.1,8.2,3\n4,49.2,8.3,\n");
  ASSERT_EQ(fixes.size(), 2u);
  EXPECT_EQ(fixes[0].time, 1.5);
  EXPECT_EQ(fixes[0].sigma, 3);
  EXPECT_EQ(fixes[1].sigma, 5);
  EXPECT_EQ(fixes[1].point.longitude, 8.3);
  EXPECT_FALSE(fixes[0].has_height);
  const auto high = Read("time,latitude,longitude,height\n1.5,49.1,8.2,113.5\n4,49.2,8.3,\n");
  EXPECT_TRUE(high[0].has_height);
  EXPECT_EQ(high[0].point.height, 113.5);
  EXPECT_FALSE(high[1].has_height);
  const auto of_day =
      Read("latitude,longitude,time\n1,2,2026-03-22T07:14:15+01:00\n", ParseUtcTime("2026-03-22T06:14:05Z"));
  EXPECT_EQ(of_day[0].time, 10);
  const std::string since_1970 = "time,latitude,longitude\n1774160055.25,1,2\n";
  EXPECT_EQ(Read(since_1970, ParseUtcTime("2026-03-22T06:14:05Z"))[0].time, 10.25);
  EXPECT_EQ(Read(since_1970, 0)[0].time, 1774160055.25) << "as are those of the drive";
}

TEST_F(GpsFixFileTest, NamesFileAndLine) {
  EXPECT_NE(Refusal("time,lat,lon\n").find("has no column 'latitude'"), std::string::npos);
  EXPECT_NE(Refusal("\xFF\xFEt").find("is text in UTF-16"), std::string::npos);
  EXPECT_NE(Refusal("time,latitude,longitude\n" + std::string(99, 'x') + ",1,2\n").find("x...' is not a time"),
            std::string::npos);
  EXPECT_NE(Refusal("time,latitude,longitude\n1,90,0\n").find("fixes.csv:2: is not a position"), std::string::npos);
  EXPECT_NE(Refusal("time,latitude,longitude\n1,151.2,-33.9\n")
                .find("fixes.csv:2: a latitude of 151.2 is beyond 90 degrees; are latitude and longitude swapped?"),
            std::string::npos);
  EXPECT_NE(Refusal("time,latitude,longitude\n1,1,1\n1,1,1\n").find("csv:3: its time does not come after"),
            std::string::npos);
  EXPECT_NE(Refusal("time,latitude,longitude\nsoon,1,1\n").find("'soon' is not a time"), std::string::npos);
  EXPECT_NE(Refusal("time,latitude,longitude\n2026-03-22T07:14:15+01:00,1,1\n").find("give --start-time too"),
            std::string::npos);
  EXPECT_NE(Refusal("time,latitude,longitude\n1774160055,1,1\n")
                .find("csv:2: its time is in seconds since 1970, 2026-03-22T06:14:15.000Z; give --start-time"),
            std::string::npos);
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/commands/rescale_report.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/rescale/test_rescale_drive.h"

namespace turnscale {
namespace {

// The line of the side slip; empty if there is none.
std::string SlipLine(const RescaleOptions& options, const LeverArm& car = kCar) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(10), car, kIdentity, kUnit, {.position = 0.002}, 7);
  const RescaleResult result = RescaleTrajectory(options, drive.trajectory);
  EXPECT_TRUE(result.observable) << result.reason;
  const std::string text = result.observable ? RescaleText(result) : "";
  const std::size_t at = text.find("side slip");
  return at == std::string::npos ? "" : text.substr(at, text.find('\n', at) - at);
}

TEST(RescaleText, HasTheSideSlipWithWhatWasAssumed) {
  RescaleOptions options = OptionsFor({kCar.length, 0.003});
  EXPECT_TRUE(SlipLine(options).ends_with("s^2/m, refined from the given 0.0030 +-0.0020 s^2/m")) << SlipLine(options);
  options.car.side_slip_sigma = 0;
  EXPECT_EQ(SlipLine(options), "side slip     0.0030 s^2/m, as given, not refined by the drive");
  options.timed = false;
  EXPECT_EQ(SlipLine(options), "") << "without a speed, it is not c that is assumed";
}

TEST(RescaleText, ANegativeSlipIsDoubtfulUnlessNoneWasAssumed) {
  const auto slip_line = [](double given) {
    RescaleOptions options = OptionsFor({kCar.length, given});
    options.estimator.stabilisation.enabled = false;  // a lag would explain these turns
    return SlipLine(options, {kCar.length, -0.003});
  };
  EXPECT_EQ(slip_line(0.001), "side slip     0, since the estimate would be negative: check lever arm and timestamps");
  EXPECT_EQ(slip_line(0), "side slip     0, since the estimate would be negative");
}

TEST(RescaleText, HasTheWayAcrossGapsThatThePathLacks) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(10), kCar, kIdentity, kUnit, {.position = 0.002}, 7);
  RescaleResult result = RescaleTrajectory(OptionsFor(kCar), drive.trajectory);
  EXPECT_EQ(RescaleText(result).find("gaps"), std::string::npos);
  result.gap_length = 21.14;
  EXPECT_NE(
      RescaleText(result).find(
          "turns used\ngaps          21.1 m more where tracking was lost or nothing was recorded, not measured\n"),
      std::string::npos)
      << RescaleText(result);
  EXPECT_EQ(nlohmann::json::parse(RescaleJson(result, "slam.tum", true, {}))["gap_length_m"], 21.14);
}

TEST(RescaleJson, HasTheWarnings) {
  const ScaledDrive drive = MakeScaledDrive(CityRoute(10), kCar, kIdentity, kUnit, {.position = 0.002}, 7);
  const RescaleResult result = RescaleTrajectory(OptionsFor(kCar), drive.trajectory);
  const std::vector<std::string> warnings = {"slam.tum: no timestamps", "slam.tum: the trajectory jumps"};
  EXPECT_EQ(nlohmann::json::parse(RescaleJson(result, "slam.tum", true, warnings))["warnings"],
            nlohmann::json(warnings));
}

}  // namespace
}  // namespace turnscale

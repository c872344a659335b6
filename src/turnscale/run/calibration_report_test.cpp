// SPDX-License-Identifier: MIT
#include "turnscale/run/calibration_report.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "turnscale/base/test_files.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/test_drive.h"
#include "turnscale/config/yaml_map.h"
#include "turnscale/run/settings.h"
#include "turnscale/run/vehicle_file.h"

namespace turnscale {
namespace {

const Eigen::Quaterniond kTilted = RotationFromYawPitchRoll({5 * kDeg, 15 * kDeg, -10 * kDeg});

std::vector<CameraStep> Steps() { return StepsAlong(TestPath(TestRoute({1, -1}), {1.2, 0}, kTilted)); }

TEST(CalibrationYaml, IsReadAsACameraRotation) {
  CalibrationReport report{"a \"drive\".mp4", 301, Calibrate(Steps()), std::nullopt};
  report.lever_arm = FitLeverArm({{Steps(), report.calibration.vehicle_from_camera}});
  const std::string path = ScratchPath("calibration.yaml");
  std::ofstream(path) << CalibrationYaml(report);
  EXPECT_LT(DegreesBetween(ReadCameraRotation(path), report.calibration.vehicle_from_camera), 1e-5);
  std::filesystem::remove(path);
}

TEST(CalibrationYaml, ARunKnowsHowLeverArmAndSlipErrTogether) {
  CalibrationReport report{"drive.mp4", 301, Calibrate(Steps()), std::nullopt};
  LeverArmFitOptions options;
  options.assumed_side_slip = kUsualSideSlip;
  options.assumed_side_slip_sigma = kUsualSideSlipSigma;
  report.lever_arm = FitLeverArm({{Steps(), report.calibration.vehicle_from_camera}}, options);
  const std::string path = ScratchPath("calibration.yaml");
  std::ofstream(path) << CalibrationYaml(report);
  VehicleOptions vehicle;
  ReadVehicleFile(path, vehicle);
  const LeverArmFit& arm = *report.lever_arm;
  EXPECT_NEAR(vehicle.LeverArmSigma(), arm.sigma_length, 1e-3);
  EXPECT_EQ(vehicle.side_slip_sigma, kUsualSideSlipSigma);
  EXPECT_NEAR(vehicle.lever_arm_slip_correlation, std::min(arm.slip_correlation, kMostCorrelation), 1e-4);
  EXPECT_GT(vehicle.lever_arm_slip_correlation, 0.9);
  const std::string text = CalibrationText(report);
  EXPECT_NE(text.find("(assumed, +-0.0020)"), std::string::npos) << text;
  EXPECT_NE(text.find("if the side slip is exactly that"), std::string::npos) << text;
}

TEST(CalibrationYaml, NamesOfAnyBytesAreValidYaml) {
  const CalibrationReport report{"caf\xe9 \"\x1b.mp4", 301, Calibrate(Steps()), std::nullopt};
  const std::string path = ScratchPath("calibration.yaml");
  std::ofstream(path) << CalibrationYaml(report);
  EXPECT_EQ(YamlMap(std::filesystem::path(path)).Text("input"), "caf\\xe9 \"\\x1b.mp4");
}

TEST(CalibrationHistory, TellsWhenTheFirstTurnCame) {
  const auto history = CalibrationHistory(Steps());
  EXPECT_FALSE(std::isfinite(history.front().sigma.roll));
  EXPECT_TRUE(std::isfinite(history.back().sigma.roll));
  EXPECT_LT(history[5].singular_values[1], 1e-6);
  EXPECT_GT(history.back().singular_values[1], 0.3);
  EXPECT_EQ(static_cast<size_t>(std::ranges::count(HistoryCsv(history), '\n')), history.size() + 1);
  const std::string svg = HistorySvg(history, "<drive>", YawPitchRollFromRotation(kTilted));
  EXPECT_NE(svg.find("&lt;drive&gt;"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(CalibrationHistory, ALongOneFitsAPage) {
  const CalibrationMoment moment = CalibrationHistory(Steps()).back();
  std::vector<CalibrationMoment> history(100000, moment);
  for (size_t i = 0; i < history.size(); ++i) history[i].time = 0.6 * static_cast<double>(i);
  const std::string flat = HistorySvg(history, "long");
  history[70001].psi = 1;
  const std::string svg = HistorySvg(history, "long");
  EXPECT_LT(svg.size(), 300000U);
  EXPECT_EQ(flat.find(">60<"), std::string::npos);
  EXPECT_NE(svg.find(">60<"), std::string::npos) << "the peak of 57.3 degrees is kept";
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/commands/run_command.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

// Standard deviation of L - c v^2, which the turns at one speed have shown.
double SigmaAt(double speed, const VehicleOptions& vehicle) {
  const double lever_arm = vehicle.LeverArmSigma();
  const double slip = vehicle.side_slip_sigma * speed * speed;
  return std::sqrt(lever_arm * lever_arm + slip * slip - 2 * vehicle.lever_arm_slip_correlation * lever_arm * slip);
}

TEST(CarArguments, AnotherSigmaOfTheSlipLeavesWhatTurnsHaveShown) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder.Path() / "car.yaml";
  std::ofstream(file) << "lever_arm: 1.45\nlever_arm_sigma: 0.13\nside_slip: 0.0045\nside_slip_sigma: 0.002\n"
                         "lever_arm_slip_correlation: 0.95\n";
  CarArguments car;
  car.vehicle = file;
  const VehicleOptions as_in_file = SettingsFrom(car, {}).odometry.vehicle;
  const double speed = std::sqrt(0.95 * 0.13 / 0.002);  // at which the file's turns were
  for (const double sigma : {0.0005, 0.004}) {
    car.side_slip_sigma = sigma;
    const VehicleOptions vehicle = SettingsFrom(car, {}).odometry.vehicle;
    EXPECT_EQ(vehicle.side_slip_sigma, sigma);
    EXPECT_NEAR(SigmaAt(speed, vehicle), SigmaAt(speed, as_in_file), 1e-9);
    EXPECT_EQ(vehicle.LeverArmSigma() < 0.13, sigma < 0.002) << "the lever arm follows the slip";
  }
  car.lever_arm_sigma = 0.05;
  EXPECT_EQ(SettingsFrom(car, {}).odometry.vehicle.LeverArmSigma(), 0.05) << "as given";
}

TEST(CarArguments, AnExactValueOfTheFileCorrelatesWithNothing) {
  const ScratchFolder folder;
  const std::filesystem::path file = folder.Path() / "car.yaml";
  CarArguments car;
  car.vehicle = file;
  for (const char* exact :
       {"lever_arm_sigma: 0\nside_slip_sigma: 0.002\n", "lever_arm_sigma: 0.1\nside_slip_sigma: 0\n"}) {
    std::ofstream(file) << "lever_arm: 1.45\nside_slip: 0.0045\nlever_arm_slip_correlation: 0.5\n" << exact;
    car.side_slip_sigma.reset();
    const double lever_arm_sigma = SettingsFrom(car, {}).odometry.vehicle.LeverArmSigma();
    car.side_slip_sigma = 0.001;
    const VehicleOptions vehicle = SettingsFrom(car, {}).odometry.vehicle;
    EXPECT_EQ(vehicle.lever_arm_slip_correlation, 0) << exact;
    EXPECT_EQ(vehicle.LeverArmSigma(), lever_arm_sigma) << exact;
    EXPECT_EQ(vehicle.side_slip_sigma, 0.001) << exact;
  }
}

TEST(CarArguments, AHeightThatIsGivenWasMeasured) {
  const ScratchFolder folder;
  CarArguments car;
  car.vehicle = folder.Path() / "car.yaml";
  std::ofstream(*car.vehicle) << "height: 1.4\nheight_sigma: 0.014\nheight_slip_correlation: 0.1\n";
  EXPECT_FALSE(SettingsFrom(car, {}).odometry.vehicle.has_measured_height());
  car.camera_height = "1.42";
  EXPECT_TRUE(SettingsFrom(car, {}).odometry.vehicle.has_measured_height());
}

TEST(Run, TheCalibrationThatIsNotUsedIsNamedBeforeTheCameraIsEstimated) {
  const ScratchFolder folder;
  const std::filesystem::path images = folder.Path() / "image_0";
  std::filesystem::create_directories(images);
  for (int i = 0; i < 3; ++i)
    std::ofstream(images / (std::to_string(i) + ".pgm")) << "P5\n320 240\n255\n" << std::string(320 * 240, 'x');
  std::ofstream(folder.Path() / "calib.txt") << "P0: 300 0 160 0 0 300 120 0 0 0 1 0\n";
  RunArguments arguments;
  arguments.images.inputs = {images};
  arguments.images.fps = 10;
  arguments.images.quiet = true;
  arguments.out = folder.Path() / "out";
  std::vector<std::string> told;
  RunHooks hooks;
  hooks.print_warnings = false;
  hooks.warn = [&](const std::string& warning) { told.push_back(warning); };
  hooks.phase = [&](const std::string& phase) { told.push_back(phase); };
  ExecuteRun(arguments, hooks);
  ASSERT_GE(told.size(), 2U);
  EXPECT_NE(told[0].find("calib.txt: is not used"), std::string::npos) << told[0];
  EXPECT_NE(told[1].find("estimating the intrinsics"), std::string::npos) << told[1];
  const auto is_hint = [](const std::string& one) { return one.find("is not used") != std::string::npos; };
  EXPECT_EQ(std::ranges::count_if(told, is_hint), 1);
}

}  // namespace
}  // namespace turnscale

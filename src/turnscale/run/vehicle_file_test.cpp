// SPDX-License-Identifier: MIT
#include "turnscale/run/vehicle_file.h"

#include <cmath>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

VehicleOptions ReadText(const std::string& text) {
  const std::filesystem::path file = ScratchPath("car.yaml");
  std::ofstream(file) << text;
  VehicleOptions vehicle;
  ReadVehicleFile(file, vehicle);
  return vehicle;
}

std::string Refused(const std::string& text) {
  try {
    ReadText(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

RefinedScale LearnedScale() {
  RefinedScale scale;
  scale.estimate.emplace();
  scale.estimate->converged = true;
  scale.estimate->car = {.yaw_error = 0.002,
                         .yaw_error_sigma = 0.001,
                         .side_slip = 0.0051,
                         .side_slip_sigma = 0.0007,
                         .lever_arm = 1.47,
                         .lever_arm_sigma = 0.02,
                         .camera_height = 1.31,
                         .camera_height_sigma = 0.02};
  return scale;
}

TEST(VehicleFile, TheNextDriveKnowsWhatThisOneHasLearned) {
  VehicleOptions vehicle;
  vehicle.lever_arm = 1.45;
  const Mount mount{.vehicle_from_camera = RotationFromYawPitchRoll({0.1, -0.05, 0.02}),
                    .found = true,
                    .sigma = {0.004, 0.002, 0.01}};
  const VehicleOptions next = ReadText(VehicleFileText(vehicle, mount, LearnedScale()));
  EXPECT_NEAR(next.lever_arm.value(), 1.47, 1e-6);
  EXPECT_NEAR(next.LeverArmSigma(), 0.02, 1e-6);
  EXPECT_NEAR(next.side_slip, 0.0051, 1e-8);
  EXPECT_NEAR(next.side_slip_sigma, 0.0007, 1e-8);
  EXPECT_NEAR(next.camera_height.value(), 1.31, 1e-6);
  EXPECT_NEAR(next.HeightSigma(), std::hypot(0.02, 0.0131), 1e-6) << "the load differs from drive to drive";
  EXPECT_TRUE(next.camera_known);
  EXPECT_TRUE(next.calibrate_camera) << "the next drive refines it";
  const YawPitchRoll angles = YawPitchRollFromRotation(next.vehicle_from_camera);
  EXPECT_NEAR(angles.yaw, 0.102, 1e-6);
  EXPECT_NEAR(angles.pitch, -0.05, 1e-6);
  EXPECT_NEAR(angles.roll, 0.02, 1e-6);
  EXPECT_GT(next.yaw_sigma, 0.001);
  EXPECT_LT(next.yaw_sigma, 0.003);
  EXPECT_NEAR(next.known_pitch_sigma, std::hypot(0.002, 0.4 / kDegreesPerRadian), 1e-6);
  EXPECT_NEAR(next.known_roll_sigma, std::hypot(0.01, 0.5 / kDegreesPerRadian), 1e-6);
  // A drive without a turn hands on what it was given.
  const VehicleOptions later =
      ReadText(VehicleFileText(next, Mount{.vehicle_from_camera = next.vehicle_from_camera}, {}));
  EXPECT_NEAR(later.known_roll_sigma, std::hypot(next.known_roll_sigma, 0.5 / kDegreesPerRadian), 1e-6);
}

TEST(VehicleFile, TheNextDriveKnowsHowTheErrorsCorrelate) {
  VehicleOptions vehicle;
  vehicle.lever_arm = 1.45;
  RefinedScale scale = LearnedScale();
  CarRefinement& car = scale.estimate->car;
  const auto next = [&] { return ReadText(VehicleFileText(vehicle, {}, scale)); };
  const double between_drives = 0.02 / std::hypot(0.02, 0.0131);
  car.height_correlation = 0.6;
  car.height_slip_correlation = -0.7;
  EXPECT_NEAR(next().height_correlation, 0.6 * between_drives, 1e-5);
  EXPECT_NEAR(next().height_slip_correlation, -0.7 * between_drives, 1e-5);
  // Those of lever arm and slip correlate as well, so that both may be large.
  car.height_correlation = 0.9;
  car.height_slip_correlation = -0.9;
  EXPECT_NEAR(next().height_correlation, 0.98 / std::sqrt(2) * between_drives, 1e-5);
  EXPECT_NEAR(next().height_slip_correlation, -0.98 / std::sqrt(2) * between_drives, 1e-5);
  car.lever_arm = 0;
  EXPECT_EQ(next().height_correlation, 0);
  EXPECT_NEAR(next().height_slip_correlation, -0.9 * between_drives, 1e-5);
  car.side_slip_sigma = 0;
  EXPECT_EQ(next().height_slip_correlation, 0) << "known exactly";
}

TEST(VehicleFile, TheNextDriveKnowsHowLeverArmAndSlipErrTogether) {
  VehicleOptions vehicle;
  vehicle.lever_arm = 1.45;
  RefinedScale scale = LearnedScale();
  CarRefinement& car = scale.estimate->car;
  const auto next = [&] { return ReadText(VehicleFileText(vehicle, {}, scale)); };
  EXPECT_EQ(next().lever_arm_slip_correlation, 0);
  car.lever_arm_slip_correlation = 0.8;
  EXPECT_NEAR(next().lever_arm_slip_correlation, 0.8, 1e-5);
  car.lever_arm_slip_correlation = 1;
  EXPECT_NEAR(next().lever_arm_slip_correlation, kMostCorrelation, 1e-5);
  // Errors that are nearly one: all correlations shrink, so that the file can be read.
  car.height_correlation = 0.7;
  car.height_slip_correlation = -0.7;
  car.lever_arm_slip_correlation = 0.5;
  const VehicleOptions shrunk = next();
  EXPECT_LT(shrunk.lever_arm_slip_correlation, 0.45);
  EXPECT_NEAR(shrunk.height_slip_correlation, -shrunk.height_correlation, 1e-5);
  // A drive that refines nothing hands on what it was given, less what its lengths disagree by.
  vehicle.lever_arm_sigma = 0.1;
  vehicle.lever_arm_slip_correlation = 0.9;
  scale.estimate.reset();
  EXPECT_NEAR(next().lever_arm_slip_correlation, 0.9, 1e-5);
  vehicle.lever_arm.reset();
  EXPECT_EQ(next().lever_arm_slip_correlation, 0);
}

TEST(VehicleFile, AFileWithoutCorrelationsIsAsBefore) {
  const VehicleOptions vehicle = ReadText("lever_arm: 1.5\nlever_arm_sigma: 0.1\nside_slip: 0.004\n");
  EXPECT_EQ(vehicle.lever_arm_slip_correlation, 0);
  EXPECT_EQ(ReadText("side_slip: 0.004\nlever_arm_slip_correlation: 0.5\n").lever_arm_slip_correlation, 0)
      << "of another lever arm";
  EXPECT_NE(Refused("lever_arm: 1\nside_slip: 0.004\nlever_arm_slip_correlation: -1.5\n")
                .find("lever_arm_slip_correlation: has to be between -1 and 1"),
            std::string::npos);
  const std::string errors = "lever_arm_sigma: 0.1\nside_slip_sigma: 0.002\nlever_arm_slip_correlation: 0.9\n";
  EXPECT_EQ(ReadText("lever_arm: 1\nside_slip: 0.004\n" + errors).lever_arm_slip_correlation, 0.9);
  for (const char* sigma : {"lever_arm_sigma: 0.1\n", "side_slip_sigma: 0.002\n"})
    EXPECT_EQ(ReadText(std::string("lever_arm: 1\nside_slip: 0.004\nlever_arm_slip_correlation: 0.9\n") + sigma)
                  .lever_arm_slip_correlation,
              0)
        << "of another sigma than the usual one that is taken instead";
  EXPECT_NE(Refused("lever_arm: 1\nside_slip: 0.004\n" + errors +
                    "height: 2\nheight_sigma: 1\nheight_correlation: 0.6\nheight_slip_correlation: -0.6\n")
                .find("lever_arm_slip_correlation"),
            std::string::npos);
}

TEST(VehicleFile, CorrelationsOfTheHeightShrinkByWhatChangesBetweenDrives) {
  const VehicleOptions next = ReadText(
      "lever_arm: 1.5\nside_slip: 0.005\nheight: 1.4\nheight_sigma: 0.014\nheight_correlation: 0.6\n"
      "height_slip_correlation: -0.7\n");
  EXPECT_NEAR(next.height_correlation, 0.6 / std::sqrt(2), 1e-9);
  EXPECT_NEAR(next.height_slip_correlation, -0.7 / std::sqrt(2), 1e-9);
  EXPECT_NE(Refused("height: 1\nheight_slip_correlation: 1.5\n").find("height_slip_correlation"), std::string::npos);
  EXPECT_NE(Refused("height: 2\nheight_sigma: 1\nheight_correlation: 0.9\nheight_slip_correlation: 0.9\n")
                .find("height_slip_correlation"),
            std::string::npos);
}

TEST(VehicleFile, LengthsThatDisagreeAreNoBetterKnownThanThat) {
  VehicleOptions vehicle;
  vehicle.lever_arm = 1.5;
  vehicle.camera_height = 1.4;
  RefinedScale scale = LearnedScale();
  scale.estimate->height_conflict = HeightConflict{1.4, 0.014, 1.26, 0.02, false};
  const VehicleOptions next = ReadText(VehicleFileText(vehicle, {}, scale));
  EXPECT_NEAR(next.lever_arm.value(), 1.5, 1e-9);
  EXPECT_NEAR(next.LeverArmSigma(), std::hypot(vehicle.LeverArmSigma(), 0.105 * 1.5), 1e-3);
  EXPECT_NEAR(next.camera_height.value(), 1.4, 1e-9);
  EXPECT_NEAR(next.HeightSigma(), 0.105 * 1.4, 2e-3);
  scale.estimate->height_conflict = HeightConflict{1.4, 0.014, 0.4, 0.02, false};
  const VehicleOptions doubtful = ReadText(VehicleFileText(vehicle, {}, scale));
  EXPECT_LT(doubtful.LeverArmSigma(), 1.5) << "below the lever arm, or it could not be read";
  EXPECT_LT(doubtful.HeightSigma(), 1.4);
}

TEST(VehicleFile, WhatIsNotKnownIsLeftOut) {
  const std::string text = VehicleFileText({}, {}, {});
  EXPECT_EQ(text.find("lever_arm:"), std::string::npos) << text;
  EXPECT_EQ(text.find("height:"), std::string::npos) << text;
  EXPECT_EQ(text.find("yaw_deg:"), std::string::npos) << text;
  const VehicleOptions next = ReadText(text);
  EXPECT_FALSE(next.lever_arm);
  EXPECT_FALSE(next.camera_height);
  EXPECT_FALSE(next.camera_known);
}

TEST(VehicleFile, ARotationFromBeforeTheCameraWasMovedIsLeftOut) {
  VehicleOptions vehicle;
  vehicle.lever_arm = 1.45;
  vehicle.camera_known = true;
  vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.1, -0.05, 0.02});
  Mount mount{.vehicle_from_camera = vehicle.vehicle_from_camera};
  EXPECT_TRUE(ReadText(VehicleFileText(vehicle, mount, {})).camera_known);
  mount.first_keyframe = 40;
  const VehicleOptions next = ReadText(VehicleFileText(vehicle, mount, {}));
  EXPECT_FALSE(next.camera_known);
  EXPECT_EQ(next.lever_arm, 1.45) << "the rest of the car stays";
  mount.found = true;
  EXPECT_TRUE(ReadText(VehicleFileText(vehicle, mount, {})).camera_known) << "a turn since has shown the new one";
}

TEST(VehicleFile, WhatWasGivenStays) {
  VehicleOptions vehicle;
  vehicle.camera_height = 1.2;
  const VehicleOptions next = ReadText(VehicleFileText(vehicle, {}, {}));
  EXPECT_NEAR(next.camera_height.value(), 1.2, 1e-9);
}

TEST(VehicleFile, TheNextDriveAllowsForTheLagOfStabilisedImages) {
  EXPECT_EQ(ReadText(VehicleFileText({}, {}, LearnedScale())).image_lag_sigma, 0);
  RefinedScale stabilised = LearnedScale();
  stabilised.estimate->image_lag = ImageLag{.found = -0.08, .found_sigma = 0.03};
  const VehicleOptions next = ReadText(VehicleFileText({}, {}, stabilised));
  EXPECT_NEAR(next.image_lag, -0.08, 1e-6);
  EXPECT_NEAR(next.image_lag_sigma, std::hypot(0.03, 0.02), 1e-6);
  EXPECT_EQ(ReadText("image_lag_sigma: 0.2\n").image_lag, 0);
  EXPECT_NE(Refused("image_lag: 0.1\n").find("needs image_lag_sigma"), std::string::npos);
  stabilised.estimate->is_doubtful = true;
  EXPECT_EQ(ReadText(VehicleFileText({}, {}, stabilised)).image_lag_sigma, 0) << "as from a converted video";
  stabilised.estimate->is_doubtful = false;
  stabilised.estimate->image_lag->scale_error = 0.3;
  EXPECT_EQ(ReadText(VehicleFileText({}, {}, stabilised)).image_lag_sigma, 0) << "something else may look like it";
  EXPECT_NEAR(ReadText(VehicleFileText(next, {}, {})).image_lag, -0.08, 1e-6) << "a drive without a turn hands it on";
  EXPECT_NE(Refused("image_lag: 0.1\nimage_lag_sigma: -1\n").find("image_lag_sigma"), std::string::npos);
}

TEST(VehicleFile, ReadsWhatSimulateWrites) {
  const VehicleOptions vehicle = ReadText(
      "yaw_deg: 2\npitch_deg: -3\nroll_deg: 0.5\nlever_arm: 1.4\nlateral_offset: 0.2\nheight: 1.3\nside_slip: 0.005\n");
  EXPECT_EQ(vehicle.lever_arm, 1.4);
  EXPECT_EQ(vehicle.LeverArmSigma(), kTapeSigma);
  EXPECT_EQ(vehicle.side_slip_sigma, kUsualSideSlipSigma);
  EXPECT_EQ(vehicle.camera_height, 1.3);
}

TEST(VehicleFile, AStatedSigmaOfAShortLeverArmIsKept) {
  EXPECT_EQ(ReadText("lever_arm: 0.05\nlever_arm_sigma: 0.03\n").LeverArmSigma(), 0.03);
  EXPECT_EQ(ReadText("lever_arm: 0.05\n").LeverArmSigma(), 0.025) << "measured with a tape";
}

TEST(VehicleFile, SenselessValuesAreRefused) {
  EXPECT_NE(Refused("height: -1\n").find("height"), std::string::npos);
  EXPECT_NE(Refused("lever_arm: 0\n").find("lever_arm"), std::string::npos);
  EXPECT_NE(Refused("height: 1\nheight_sigma: -0.1\n").find("height_sigma"), std::string::npos);
  EXPECT_NE(Refused("yaw_deg: 270\npitch_deg: 0\nroll_deg: 0\n").find("yaw_deg"), std::string::npos);
  EXPECT_NE(Refused("side_slip: 2\n").find("car.yaml:1: side_slip: is 2; it has to be in 0...1"), std::string::npos);
  EXPECT_NE(Refused("lever_arm: 145\n")
                .find("car.yaml:1: lever_arm: is 145; it has to be the distance from the rear axle forward"),
            std::string::npos);
  EXPECT_NE(Refused("height: 150\n").find("car.yaml:1: height: has to be"), std::string::npos)
      << Refused("height: 150\n");
  EXPECT_NE(Refused("height: 1\nheight_sigma: 1\n").find("height_sigma: has to be below"), std::string::npos);
  EXPECT_NE(Refused("hight: 1\n").find("height"), std::string::npos) << "the nearest known key";
  EXPECT_NE(Refused("wheelbase_m: 2.7\n").find("wheelbase_m: unknown key; remove it"), std::string::npos);
  for (const char* settings : {"vehicle:\n  lever_arm: 1\n", "scale:\n  huber: 2\n"})
    EXPECT_NE(Refused(settings).find(
                  "is of a file of settings, which --settings takes; give a car's file here, such as car.yaml"),
              std::string::npos)
        << Refused(settings);
  for (const char* camera : {"image_width: 640\ncamera_matrix: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n", "Camera.fx: 200\n",
                             "P0: 1 0 0 0 0 1 0 0 0 0 1 0\n", "cam0:\n  camera_model: pinhole\n"})
    EXPECT_NE(Refused(camera).find("is of a camera's file, which --camera takes; give a car's file here"),
              std::string::npos)
        << Refused(camera);
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/run/settings.h"

#include <cmath>
#include <fstream>
#include <sstream>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

std::string Write(const std::string& text) {
  const std::string path = ScratchPath("settings_test.yaml");
  std::ofstream(path) << text;
  return path;
}

Settings SettingsFrom(const std::string& text) { return ReadSettings(Write(text)); }

template <class Action>
std::string ComplaintOf(const Action& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string SettingsComplaint(const std::string& text) {
  return ComplaintOf([&] { SettingsFrom(text); });
}

TEST(Settings, WrittenDefaultsReadBackToTheSameBits) {
  const OdometryOptions defaults;
  const Settings settings = SettingsFrom(SettingsText(Settings()));
  EXPECT_EQ(SettingsText(settings), SettingsText(Settings()));
  const OdometryOptions& read = settings.odometry;
  EXPECT_EQ(read.scale.estimator.segments.turns.min_step_angle, defaults.scale.estimator.segments.turns.min_step_angle);
  EXPECT_EQ(read.scale.estimator.segments.turns.min_region_angle,
            defaults.scale.estimator.segments.turns.min_region_angle);
  EXPECT_EQ(read.scale.estimator.evidence.line.sigma_theta, defaults.scale.estimator.evidence.line.sigma_theta);
  EXPECT_EQ(read.vehicle.side_slip, defaults.vehicle.side_slip);
  EXPECT_EQ(read.vehicle.vehicle_from_camera.coeffs(), defaults.vehicle.vehicle_from_camera.coeffs());
  EXPECT_FALSE(read.vehicle.lever_arm.has_value());
}

TEST(Settings, ChangedValuesSurvive) {
  Settings settings;
  settings.images.max_width = 1920;
  settings.self_calibration.windows = 5;
  OdometryOptions& options = settings.odometry;
  options.corners.target = 700;
  options.vehicle.lever_arm = 1.45;
  options.vehicle.side_slip = 0.0041;
  options.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.02, -0.03, 0.01});
  options.scale.estimator.segments.turns.min_step_angle = 3.0 / kDegreesPerRadian;
  options.scale.method = ScaleMethod::kPaper;
  options.scale.estimator.evidence.turn_sigma = 0.023;
  options.scale.estimator.drift.per_100m = 0.017;
  options.scale.estimator.test.min_probability = 0.002;
  options.vehicle.lever_arm_sigma = 0.02;
  options.steps.angle = 2.0 / kDegreesPerRadian;
  const Settings read_back = SettingsFrom(SettingsText(settings));
  EXPECT_EQ(SettingsText(read_back), SettingsText(settings));
  EXPECT_EQ(read_back.images.max_width, 1920);
  EXPECT_EQ(read_back.self_calibration.windows, 5);
  const OdometryOptions& read = read_back.odometry;
  EXPECT_EQ(read.corners.target, 700);
  EXPECT_EQ(read.vehicle.lever_arm, 1.45);
  EXPECT_EQ(read.vehicle.side_slip, 0.0041);
  EXPECT_LT(read.vehicle.vehicle_from_camera.angularDistance(options.vehicle.vehicle_from_camera), 1e-12);
  EXPECT_EQ(read.scale.estimator.segments.turns.min_step_angle, options.scale.estimator.segments.turns.min_step_angle);
  EXPECT_EQ(read.scale.method, ScaleMethod::kPaper);
  EXPECT_EQ(read.scale.estimator.evidence.turn_sigma, 0.023);
  EXPECT_EQ(read.scale.estimator.drift.per_100m, 0.017);
  EXPECT_EQ(read.scale.estimator.test.min_probability, 0.002);
  EXPECT_EQ(read.vehicle.lever_arm_sigma, 0.02);
  EXPECT_EQ(read.steps.angle, options.steps.angle);
}

TEST(Settings, WhatIsLeftOutKeepsItsDefault) {
  const OdometryOptions read = SettingsFrom("vehicle:\n  lever_arm: 1.2\n").odometry;
  EXPECT_EQ(read.vehicle.lever_arm, 1.2);
  EXPECT_EQ(read.vehicle.side_slip, OdometryOptions().vehicle.side_slip);
  EXPECT_EQ(read.corners.target, OdometryOptions().corners.target);
}

TEST(Settings, ASettingThatEarlierVersionsWroteForNothingIsPassedOver) {
  const std::string old = "scale:\n  recovery:\n    pixel_sigma_inflation: 3\n    max_iterations: 17\n";
  EXPECT_EQ(SettingsFrom(old).odometry.scale.recovery.max_iterations, 17);
  const std::string written = SettingsText(SettingsFrom(old));
  EXPECT_EQ(written.find("pixel_sigma_inflation", written.find("recovery:")), std::string::npos);
  const std::string near = SettingsComplaint("scale:\n  recovery:\n    pixel_sigma_inflatoin: 3\n");
  EXPECT_NE(near.find("unknown key"), std::string::npos) << near;
  EXPECT_EQ(near.find("'scale.recovery.pixel_sigma_inflation'"), std::string::npos) << near;
}

TEST(Settings, FilesOfOtherKindsAreNamed) {
  for (const char* car : {"yaw_deg: 1\npitch_deg: 0\nroll_deg: 0\n", "side_slip: 0.0045\nside_slip_sigma: 0.002\n"})
    EXPECT_NE(SettingsComplaint(car).find("is the file of a car, which --vehicle takes; give --settings"),
              std::string::npos)
        << SettingsComplaint(car);
  const std::string camera = "image_width: 640\ncamera_matrix: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
  EXPECT_NE(SettingsComplaint(camera).find("is of a camera's file, which --camera takes; give a file of settings"),
            std::string::npos)
      << SettingsComplaint(camera);
}

TEST(Settings, ComplaintsNameLineKeyAndNearestKey) {
  EXPECT_NE(SettingsComplaint("vehicle:\n  leverarm: 1\n")
                .find("settings_test.yaml:2: vehicle.leverarm: unknown key; did you mean 'vehicle.lever_arm'?"),
            std::string::npos);
  EXPECT_NE(SettingsComplaint("vehicel:\n  lever_arm: 1\n").find(":1: vehicel: unknown key; did you mean 'vehicle'?"),
            std::string::npos);
  EXPECT_NE(SettingsComplaint("corners:\n  target: two\n").find(":2: corners.target: is 'two'; give a finite number"),
            std::string::npos);
  EXPECT_NE(SettingsComplaint("corners:\n  target: 1.5\n").find("give a whole number"), std::string::npos);
  EXPECT_NE(SettingsComplaint("vehicle: 3\n").find("vehicle: is not a map"), std::string::npos);
  EXPECT_NE(SettingsComplaint("vehicle:\n  side_slip: [1]\n").find("vehicle.side_slip: is not a scalar"),
            std::string::npos);
  EXPECT_NE(SettingsComplaint("vehicle:\n  lever_arm: [1]\n").find("is not a scalar; give a number or none"),
            std::string::npos);
  EXPECT_EQ(SettingsFrom("vehicle:\n  lever_arm: null\n").odometry.vehicle.lever_arm, std::nullopt);
  EXPECT_NE(SettingsComplaint("scale:\n  method: magic\n").find("is 'magic'; give smoothed or turns or paper"),
            std::string::npos);
}

TEST(Settings, AMisplacedKeyIsShownItsPlace) {
  EXPECT_NE(SettingsComplaint("drift:\n  per_100m: 0.02\n").find(":1: drift: unknown key; it belongs below 'scale'"),
            std::string::npos);
  EXPECT_NE(SettingsComplaint("vehicle:\n  per_100m: 0.02\n")
                .find(":2: vehicle.per_100m: unknown key; it belongs below 'scale.drift'"),
            std::string::npos);
  EXPECT_NE(
      SettingsComplaint("scale.drift.per_100m: 2\n")
          .find(":1: scale.drift.per_100m: unknown key; write 'scale:', 'drift:' and 'per_100m:' on separate lines"),
      std::string::npos);
  EXPECT_NE(SettingsComplaint("vehicle:\n  camera_yaw: 2\n").find("did you mean 'vehicle.camera_yaw_deg'?"),
            std::string::npos);
}

TEST(Settings, AValueOutOfRangeIsNamedWithItsLine) {
  EXPECT_NE(SettingsComplaint("scale:\n  drift:\n    per_100m: 2.0\n")
                .find("settings_test.yaml:3: scale.drift.per_100m: is 2.0; it has to be from 0 to below 1"),
            std::string::npos);
  EXPECT_NE(SettingsComplaint("vehicle:\n  lever_arm: 1\n  lever_arm_sigma: 2\n")
                .find("settings_test.yaml:3: vehicle.lever_arm_sigma: 2 has to be below the lever arm"),
            std::string::npos);
  EXPECT_NE(SettingsComplaint("initialization:\n  min_landmarks: 8\n")
                .find("settings_test.yaml: initialization.fewest_landmarks: has to be"),
            std::string::npos)
      << "the file does not have the key";
}

/// The settings with -1e9 in one line, and the dotted key of that line; empty where its value is no number.
std::pair<std::string, std::string> WithSenselessLine(const std::vector<std::string>& lines, size_t changed) {
  std::vector<std::string> groups;
  std::pair<std::string, std::string> result;
  for (size_t i = 0; i < lines.size(); ++i) {
    const size_t depth = lines[i].find_first_not_of(' ') / 2;
    const std::string key = lines[i].substr(2 * depth, lines[i].find(':') - 2 * depth);
    const std::string value = lines[i].substr(lines[i].find(':') + 1);
    groups.resize(depth);
    const bool number = value == " none" || value.find_first_of("0123456789") != std::string::npos;
    if (i == changed && number) {
      for (const std::string& group : groups) result.second += group + ".";
      result.second += key;
    }
    result.first += i == changed && number ? std::string(2 * depth, ' ') + key + ": -1000000000\n" : lines[i] + "\n";
    groups.push_back(key);
  }
  return result;
}

TEST(Settings, ComplaintsNameTheKeyThatMakesNoSense) {
  std::vector<std::string> lines;
  std::istringstream text(SettingsText({}));
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  int refused = 0;
  for (size_t i = 0; i < lines.size(); ++i) {
    const auto [settings, key] = WithSenselessLine(lines, i);
    if (key.empty()) continue;
    const std::string complaint = SettingsComplaint(settings);
    if (complaint == "no error") continue;
    ++refused;
    const std::string place = "settings_test.yaml:" + std::to_string(i + 1) + ": " + key + ": ";
    EXPECT_NE(complaint.find(place), std::string::npos) << place << "\n" << complaint;
  }
  EXPECT_GT(refused, 150);
}

TEST(Settings, AnglesAreRefusedInTheUnitOfTheKey) {
  EXPECT_NE(
      SettingsComplaint("steps:\n  angle_deg: 30\n").find("steps.angle_deg: is 30; it has to be from 0 to below 28.6"),
      std::string::npos);
  EXPECT_NE(SettingsComplaint("vehicle:\n  yaw_sigma_deg: 60\n")
                .find("vehicle.yaw_sigma_deg: is 60; it has to be above 0 and below 57.3"),
            std::string::npos);
}

TEST(Settings, LengthsInAWrongUnitAreRefused) {
  EXPECT_NE(SettingsComplaint("vehicle:\n  lever_arm: 145\n")
                .find("vehicle.lever_arm: is 145; it has to be the distance from the "
                      "rear axle forward to the camera in metres, above 0 "
                      "and up to 20"),
            std::string::npos);
  EXPECT_NE(SettingsComplaint("vehicle:\n  camera_height: 150\n").find("above 0 and up to 10"), std::string::npos);
}

TEST(CameraRotation, FromAnglesOrFile) {
  const auto expect = [](const Eigen::Quaterniond& rotation) {
    const YawPitchRoll angles = YawPitchRollFromRotation(rotation);
    EXPECT_NEAR(angles.yaw * kDegreesPerRadian, -1.5, 1e-12);
    EXPECT_NEAR(angles.pitch * kDegreesPerRadian, 2, 1e-12);
    EXPECT_NEAR(angles.roll * kDegreesPerRadian, 0.25, 1e-12);
  };
  expect(ReadCameraRotation("-1.5,2,0.25"));
  expect(ReadCameraRotation(" -1.5, 2 , +0.25"));
  expect(ReadCameraRotation(Write("yaw_deg: -1.5\npitch_deg: 2\nroll_deg: 0.25\n")));
  expect(
      ReadCameraRotation(Write("lever_arm: 1.5\nlateral_offset: 0\nheight: 1.4\nside_slip: 0.005\nyaw_deg: -1.5\n"
                               "pitch_deg: 2\nroll_deg: 0.25\n")));
}

TEST(CameraRotation, ComplaintsSayWhatToGive) {
  for (const char* text : {"1,2", "1,2,3,4", "a,b,c", "", "1,,3", "nowhere.yaml"}) {
    EXPECT_NE(ComplaintOf([&] { ReadCameraRotation(text); }).find("give yaw,pitch,roll in degrees"), std::string::npos)
        << text;
  }
  EXPECT_NE(ComplaintOf([] { ReadCameraRotation("nan,0,0"); }).find("between -180 and 180"), std::string::npos);
  EXPECT_NE(SettingsComplaint("vehicle:\n  camera_yaw_deg: 400\n").find("from -180 to 180"), std::string::npos);
  EXPECT_NE(ComplaintOf([] { ReadCameraRotation("200,0,0"); }).find("between -180 and 180"), std::string::npos);
  EXPECT_NE(ComplaintOf([] { ReadCameraRotation(Write("yaw: 1\n")); }).find("did you mean 'yaw_deg'?"),
            std::string::npos);
  const std::string loop = ScratchPath("loop");
  std::filesystem::create_symlink(loop, loop);
  EXPECT_EQ(ComplaintOf([&] { ReadCameraRotation(loop); }),
            loop + ": cannot be read: Too many levels of symbolic links");
}

}  // namespace
}  // namespace turnscale

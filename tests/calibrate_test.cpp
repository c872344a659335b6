// SPDX-License-Identifier: MIT
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "command_line.h"
#include "turnscale/base/scratch_path.h"
#include "turnscale/calibration/test_drive.h"
#include "turnscale/io/settings.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

const Eigen::Quaterniond kTilted = RotationFromYawPitchRoll({5 * kDeg, 15 * kDeg, -10 * kDeg});

class CalibrateTest : public ::testing::Test {
 protected:
  CalibrateTest() : folder_(ScratchPath("calibrate")) { fs::create_directories(folder_); }
  ~CalibrateTest() override { fs::remove_all(folder_); }

  fs::path Text(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  fs::path Tum(const Trajectory& path) const {
    std::string text;
    for (const StampedPose& pose : path) text += TumLine(pose);
    return Text("drive.tum", text);
  }

  CommandResult Run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "calibrate");
    arguments.insert(arguments.end(), {"--out", Out().string()});
    return RunCommand(arguments, folder_);
  }

  fs::path Out() const { return folder_ / "calibration.yaml"; }

  fs::path folder_;
  Trajectory drive_ = TestPath(TestRoute({1, -1}), {1.45, 0}, kTilted, 0.05 * kDeg);
};

TEST_F(CalibrateTest, WritesWhatRunReads) {
  const CommandResult result =
      Run({"--trajectory", Tum(drive_).string(), "--history", (folder_ / "history.csv").string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LT(DegreesBetween(ReadCameraRotation(Out().string()), kTilted), 0.2);
  EXPECT_NE(result.out.find("2 turns of"), std::string::npos) << result.out;
  EXPECT_TRUE(fs::exists(folder_ / "history.csv"));
  EXPECT_TRUE(fs::exists(folder_ / "history.svg"));
}

TEST_F(CalibrateTest, SpeedsGiveTheLeverArm) {
  Trajectory drive = drive_;
  for (StampedPose& pose : drive) pose.world_from_camera.translation *= 0.05;
  const fs::path speeds = Text("speed.csv", "time,speed\n0,8\n1000,8\n");
  const CommandResult result =
      Run({"--trajectory", Tum(drive).string(), "--speed", speeds.string(), "--side-slip", "0"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("lever arm      1.4"), std::string::npos) << result.out;
}

TEST_F(CalibrateTest, FindsVehicleAxes) {
  Eigen::Matrix3d camera_from_vehicle;
  camera_from_vehicle << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  Trajectory drive = drive_;
  for (StampedPose& pose : drive) {
    pose.world_from_camera.rotation = pose.world_from_camera.rotation * Eigen::Quaterniond(camera_from_vehicle);
  }
  const CommandResult result = Run({"--trajectory", Tum(drive).string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("x forward, y left, z up"), std::string::npos) << result.out;
  EXPECT_LT(DegreesBetween(ReadCameraRotation(Out().string()), kTilted), 0.2);
}

TEST_F(CalibrateTest, SaysWhatTheDriveLacks) {
  const Trajectory straight = TestPath(TestRoute({}), {1.45, 0}, kTilted);
  Trajectory still = straight;
  Trajectory turning = straight;
  for (size_t i = 0; i < straight.size(); ++i) {
    still[i].world_from_camera = RigidTransform{};
    turning[i].world_from_camera = {RotationFromVector({0, 0.02 * static_cast<double>(i), 0}), {0, 0, 0}};
  }
  ExpectComplaint(Run({"--trajectory", Tum(straight).string()}), 2,
                  {"no turn yet: roll and yaw offset not observable"});
  ExpectComplaint(Run({"--trajectory", Tum(still).string()}), 2, {"drive.tum: too little motion"});
  ExpectComplaint(Run({"--trajectory", Tum(turning).string()}), 2, {"drive.tum: too little motion"});
  ExpectComplaint(Run({"--trajectory", Tum({straight[0], straight[1]}).string()}), 2, {"too little motion"});
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(CalibrateTest, RefusesWhatIsNoDrive) {
  ExpectComplaint(Run({}), 2, {"give a drive's images, or --trajectory"});
  ExpectComplaint(Run({"--trajectory", Text("a.tum", "0 0 0 0 0 0 0 1\n1 nan 0 0 0 0 0 1\n").string()}), 2,
                  {"a.tum:2"});
  ExpectComplaint(Run({"--trajectory", Text("b.tum", "1 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n").string()}), 2,
                  {"b.tum:2", "does not come after"});
  const std::string drive = Tum(drive_).string();
  ExpectComplaint(Run({"--trajectory", drive, "--distance", "-1"}), 2, {"--distance -1"});
  ExpectComplaint(Run({"--trajectory", drive, "--speed", Text("late.csv", "900 1\n901 1\n").string()}), 2,
                  {"late.csv", "cover none of the drive's"});
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "command_line.h"
#include "turnscale/base/test_files.h"
#include "turnscale/calibration/test_drive.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/run/settings.h"

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

  // A number of the file.
  double Value(const std::string& key) const {
    std::ifstream stream(Out());
    for (std::string line; std::getline(stream, line);) {
      if (line.starts_with(key + ": ")) return std::stod(line.substr(key.size() + 2));
    }
    ADD_FAILURE() << "no " << key << " in " << Out();
    return 0;
  }

  static Trajectory Exact(const LeverArm& lever_arm, double unit) {
    Trajectory path = TestPath(TestRoute({1, -1}), lever_arm, kTilted);
    for (StampedPose& pose : path) pose.world_from_camera.translation *= unit;
    return path;
  }

  fs::path Out() const { return folder_ / "calibration.yaml"; }

  fs::path folder_;
  Trajectory drive_ = TestPath(TestRoute({1, -1}), {1.45, 0}, kTilted, 0.05 * kDeg);
};

TEST_F(CalibrateTest, WritesWhatRunReads) {
  const CommandResult result =
      Run({"--trajectory", Tum(drive_).string(), "--history", (folder_ / "history.csv").string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_LT(DegreesBetween(ReadCameraRotation(Out().string()), kTilted), 0.04);
  EXPECT_NE(result.out.find("2 turns of"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("lever arm   not estimated: the file has the rotation only"), std::string::npos);
  EXPECT_NE(result.out.find("singular values; at least 2.6 is needed)"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder_ / "history.csv"));
  EXPECT_TRUE(fs::exists(folder_ / "history.svg"));
}

TEST_F(CalibrateTest, TakesTheFolderOfARun) {
  fs::create_directories(folder_ / "run");
  fs::rename(Tum(drive_), folder_ / "run/trajectory.tum");
  ASSERT_EQ(Run({"--trajectory", (folder_ / "run").string()}).exit_code, 0);
  EXPECT_LT(DegreesBetween(ReadCameraRotation(Out().string()), kTilted), 0.04);
  Text("run/summary.json", R"({"pose_frame": "vehicle", "scale": {"state": "held"}})");
  ExpectComplaint(Run({"--trajectory", (folder_ / "run").string()}), 2, {"trajectory.tum: the poses", "rear axle"});
  fs::create_directories(folder_ / "empty");
  ExpectComplaint(Run({"--trajectory", (folder_ / "empty").string()}), 2, {"without the trajectory.tum of a run"});
}

TEST_F(CalibrateTest, AnInterruptWhileFilesAreWrittenDoesNotSayThatThereAreNone) {
  const fs::path history = folder_ / "history.csv";
  for (const fs::path& pipe : {history, Out()}) ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  Command command(
      {"calibrate", "--trajectory", Tum(drive_).string(), "--history", history.string(), "--out", Out().string()},
      folder_);
  // The history is written, and the calibration waits for a reader.
  EXPECT_NE(TextOf(history), "");
  command.Signal(SIGTERM);
  const CommandResult result = command.Wait();
  EXPECT_EQ(result.exit_code, -1) << "ended by the signal";
  EXPECT_EQ(result.err, "");
}

TEST_F(CalibrateTest, SpeedsGiveTheLeverArm) {
  const std::string drive = Tum(Exact({1.45, 0}, 0.05)).string();
  // The times before and after the drive do not matter; the standing at its end tells nothing.
  const fs::path speeds = Text("speed.csv", "time,speed\n0,8\n1000,8\n");
  ASSERT_EQ(Run({"--trajectory", drive, "--speed", speeds.string(), "--side-slip", "0"}).exit_code, 0);
  EXPECT_NEAR(Value("lever_arm"), 1.45, 5e-4);
  EXPECT_EQ(Value("side_slip"), 0);
  ExpectComplaint(
      Run({"--trajectory", drive, "--speed", Text("still.csv", "0 0\n1000 0\n").string(), "--side-slip", "0"}), 2,
      {"still.csv", "stands", "calibration.yaml"});
}

TEST_F(CalibrateTest, SpeedsGiveTheLeverArmOfASlippingCar) {
  const fs::path speeds = Text("speed.csv", "0 8\n1000 8\n");
  ASSERT_EQ(Run({"--trajectory", Tum(Exact({1.45, 0.0045}, 0.05)).string(), "--speed", speeds.string()}).exit_code, 0);
  EXPECT_NEAR(Value("lever_arm"), 1.45, 5e-4);
  EXPECT_EQ(Value("side_slip"), 0.0045);
  EXPECT_EQ(Value("side_slip_sigma"), 0.002);
  EXPECT_NEAR(Value("lever_arm_sigma"), 0.002 * 64, 0.01);
  EXPECT_GT(Value("lever_arm_slip_correlation"), 0.9);
}

TEST_F(CalibrateTest, MetresGiveTheLeverArm) {
  const Trajectory drive = Exact({1.45, 0}, 1);
  ASSERT_EQ(Run({"--trajectory", Tum(drive).string(), "--metric", "--side-slip", "0"}).exit_code, 0);
  EXPECT_NEAR(Value("lever_arm"), 1.45, 5e-4);
  // 0.8 m a frame.
  const std::string metres = std::to_string(0.8 * static_cast<double>(drive.size() - 1));
  const std::string units = Tum(Exact({1.45, 0}, 0.031)).string();
  ASSERT_EQ(Run({"--trajectory", units, "--distance", metres, "--side-slip", "0"}).exit_code, 0);
  EXPECT_NEAR(Value("lever_arm"), 1.45, 5e-4);
}

TEST_F(CalibrateTest, ALeverArmThatRunWouldRefuseIsNotWritten) {
  const std::string units = Tum(Exact({1.45, 0}, 1)).string();
  const std::string drive = units + ": lever arm not estimated: the estimated lever arm is ";
  const CommandResult far = Run({"--trajectory", units, "--distance", "90000", "--side-slip", "0"});
  ExpectComplaint(far, 2, {drive, " m, above the 20 m that a car can have; check --distance 90000"});
  const std::string speeds = Text("kmh.csv", "time,speed_mps\n0,500\n1000,500\n").string();
  ExpectComplaint(Run({"--trajectory", units, "--speed", speeds, "--side-slip", "0"}), 2,
                  {drive, "check --speed " + speeds});
  ExpectComplaint(Run({"--trajectory", Tum(Exact({1.45, 0}, 50)).string(), "--metric", "--side-slip", "0"}), 2,
                  {drive, "check --metric"});
  EXPECT_EQ(TextOf(Out()).find("lever_arm"), std::string::npos);
}

TEST_F(CalibrateTest, FindsTheSideSlipAtTwoSpeeds) {
  std::vector<DriveSegment> route = TestRoute({1, -1});
  for (DriveSegment segment : TestRoute({-1, 1})) {
    segment.camera_distance = 0.4;
    route.push_back(segment);
  }
  const Trajectory drive = TestPath(route, {1.45, 0.005}, kTilted);
  const CommandResult result = Run({"--trajectory", Tum(drive).string(), "--metric", "--fit-side-slip"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NEAR(Value("lever_arm"), 1.45, 6e-4);
  EXPECT_NEAR(Value("side_slip"), 0.005, 1e-5);
  // At one speed the rotation is still written, and the line says which drive it was.
  ExpectComplaint(Run({"--trajectory", Tum(Exact({1.45, 0.005}, 1)).string(), "--metric", "--fit-side-slip"}), 2,
                  {"drive.tum: lever arm not estimated", "same speed", "calibration.yaml"});
  EXPECT_LT(DegreesBetween(ReadCameraRotation(Out().string()), kTilted), 1e-4);
}

TEST_F(CalibrateTest, KittiPosesGetTheirTimes) {
  std::string text;
  for (const StampedPose& pose : Exact({1.45, 0.0045}, 1)) text += KittiLine(pose.world_from_camera, 12);
  const std::string drive = Text("poses.kitti", text).string();
  // The same motion in half of the time: twice the speed, four times the slip.
  ASSERT_EQ(Run({"--trajectory", drive, "--metric", "--fps", "20"}).exit_code, 0);
  EXPECT_NEAR(Value("lever_arm"), 1.45 - 0.0045 * 64 + 0.0045 * 64 * 4, 1e-3);
  // Three times the speed: the lever arm is hardly more than the slip that is assumed.
  ExpectComplaint(Run({"--trajectory", drive, "--metric", "--fps", "30"}), 2,
                  {"too uncertain", "slower street corners"});
  ASSERT_EQ(Run({"--trajectory", drive, "--metric", "--fps", "10"}).exit_code, 0);
  EXPECT_NEAR(Value("lever_arm"), 1.45, 5e-4);
  // Without times there is no speed, and no slip.
  const CommandResult result = Run({"--trajectory", drive, "--metric"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("no times"), std::string::npos) << result.out;
  EXPECT_EQ(Value("side_slip"), 0);
  EXPECT_NEAR(Value("lever_arm"), 1.45 - 0.0045 * 64, 5e-4);
  const std::string speeds = Text("speed.csv", "0 8\n1000 8\n").string();
  ExpectComplaint(Run({"--trajectory", drive, "--speed", speeds}), 2, {"--speed", "no times"});
  ExpectComplaint(Run({"--trajectory", drive, "--metric", "--fit-side-slip"}), 2, {"--fit-side-slip", "no times"});
  ExpectComplaint(Run({"--trajectory", drive, "--metric", "--side-slip", "0.004"}), 2, {"--side-slip", "no times"});
}

TEST_F(CalibrateTest, AnUnbrokenDriveIsNeededToShareOutADistance) {
  Trajectory drive = Exact({1.45, 0}, 0.05);
  drive.erase(drive.begin() + 20, drive.begin() + 50);
  ExpectComplaint(
      Run({"--trajectory", Tum(drive).string(), "--distance", "150"}), 2,
      {"--distance", "drive.tum", "1.9 s", "(the camera-to-vehicle rotation is in " + Out().string() + ")"});
  EXPECT_NEAR(Value("yaw_deg"), 5, 0.5);
  EXPECT_EQ(Run({"--trajectory", Tum(drive).string()}).exit_code, 0);
}

TEST_F(CalibrateTest, FindsBodyAxes) {
  Eigen::Matrix3d camera_from_body;
  camera_from_body << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  Trajectory drive = drive_;
  for (StampedPose& pose : drive) {
    pose.world_from_camera.rotation = pose.world_from_camera.rotation * Eigen::Quaterniond(camera_from_body);
  }
  const CommandResult result = Run({"--trajectory", Tum(drive).string()});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("y left and z up assumed"), std::string::npos) << result.out;
  EXPECT_LT(DegreesBetween(ReadCameraRotation(Out().string()), kTilted), 0.04);
  ASSERT_EQ(Run({"--trajectory", Tum(drive).string(), "--axes", "frd"}).exit_code, 0);
  EXPECT_NEAR(Value("yaw_deg"), -5, 0.02);
  EXPECT_NEAR(Value("pitch_deg"), -15, 0.012);
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
  ExpectComplaint(Run({}), 2, {"give the images of a drive, or --trajectory"});
  ExpectComplaint(Run({"--trajectory", Text("a.tum", "0 0 0 0 0 0 0 1\n1 nan 0 0 0 0 0 1\n").string()}), 2,
                  {"a.tum:2"});
  ExpectComplaint(Run({"--trajectory", Text("b.tum", "1 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n").string()}), 2,
                  {"b.tum:2", "does not come after"});
  const std::string drive = Tum(drive_).string();
  ExpectComplaint(Run({"--trajectory", drive, "--distance", "-1"}), 2, {"--distance -1"});
  ExpectComplaint(Run({"--trajectory", drive, "--speed", Text("late.csv", "900 1\n901 1\n").string()}), 2,
                  {"late.csv", "do not overlap the drive's"});
  ExpectComplaint(Run({"--trajectory", drive, "--fps", "30"}), 2, {"drive.tum", "--fps"});
  ExpectComplaint(Run({"--trajectory", drive, "--history", "x.svg"}), 2, {"--history x.svg", "CSV"});
  ExpectComplaint(Run({"--trajectory", drive, "--fit-side-slip"}), 2, {"--fit-side-slip", "--metric"});
  ExpectComplaint(Run({"--trajectory", drive, "--side-slip", "0"}), 2, {"--side-slip", "--lever-arm"});
  for (const char* option : {"--camera", "--settings", "--max-frames"}) {
    ExpectComplaint(Run({"--trajectory", drive, option, "5"}), 2, {option, "--trajectory"});
  }
  ExpectComplaint(Run({folder_.string(), "--metric"}), 2, {"--metric", "--trajectory"});
  // Before any image is looked at.
  ExpectComplaint(Run({"no_such_drive", "--speed", (folder_ / "none.csv").string()}), 2, {"none.csv"});
}

}  // namespace
}  // namespace turnscale

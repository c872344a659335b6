// SPDX-License-Identifier: MIT
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <signal.h>

#include "command_line.h"
#include "turnscale/base/test_files.h"
#include "turnscale/config/yaml_map.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/frames/video_file.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

class SimulateTest : public ::testing::Test {
 protected:
  SimulateTest() : folder_(ScratchPath("simulate")) { fs::create_directories(folder_); }
  ~SimulateTest() override { fs::remove_all(folder_); }

  fs::path Out() const { return folder_ / "drive"; }
  fs::path Text(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  // A camera so small that a drive takes no time.
  std::string SmallRig() const {
    return Text("small.yaml", "camera:\n  width: 96\n  height: 72\n  fx: 60\n  fy: 60\n  cx: 47.5\n  cy: 35.5\n")
        .string();
  }
  std::vector<std::string> Arguments(std::vector<std::string> more) const {
    more.insert(more.begin(), "simulate");
    more.insert(more.end(), {"--out", Out().string()});
    return more;
  }
  CommandResult Simulate(const std::vector<std::string>& more) const { return RunCommand(Arguments(more), folder_); }
  CommandResult SimulateRig(const std::string& rig) const {
    return Simulate({"garage", "--rig", Text("rig.yaml", rig).string()});
  }

  fs::path folder_;
};

TEST_F(SimulateTest, ADriveThatTakesLongerThanAskedSaysSo) {
  const CommandResult longer = Simulate({"garage", "--rig", SmallRig(), "--seconds", "5"});
  EXPECT_EQ(longer.exit_code, 0) << longer.err;
  EXPECT_EQ(longer.out.find("--camera-height"), std::string::npos) << "its turns give the scale: " << longer.out;
  EXPECT_NE(longer.err.find("warning: --seconds 5: the shortest garage drive takes 15."), std::string::npos)
      << longer.err;
  const CommandResult cut = Simulate({"garage", "--rig", SmallRig(), "--seconds", "5", "--max-frames", "3", "--quiet"});
  EXPECT_EQ(cut.err, "");
}

TEST_F(SimulateTest, AFolderOfARunIsRefused) {
  fs::create_directories(Out());
  std::ofstream(Out() / "live.tum") << "";
  ExpectComplaint(Simulate({"garage", "--rig", SmallRig()}), 2, {"drive: has the results of a run"});
  EXPECT_FALSE(fs::exists(Out() / "drive.yaml"));
}

TEST_F(SimulateTest, DriveGoesStraightIntoRun) {
  // Large enough to be tracked.
  const std::string rig =
      Text("rig.yaml", "camera:\n  width: 320\n  height: 240\n  fx: 190\n  fy: 190\n  cx: 159.5\n  cy: 119.5\n")
          .string();
  const CommandResult made = Simulate({"garage", "--rig", rig, "--seconds", "5", "--max-frames", "20", "--seed", "2"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_NE(made.out.find("files   " + Out().string()), std::string::npos) << made.out;
  EXPECT_NE(made.err.find("frame 20/20"), std::string::npos) << made.err;
  EXPECT_EQ(FindDrive(Out()).images.size(), 20u);
  const YamlMap origin(Out() / "drive.yaml");
  EXPECT_EQ(origin.Text("world"), "garage");
  EXPECT_EQ(origin.Integer("seed"), 2);
  EXPECT_EQ(origin.Number("seconds"), 5);
  EXPECT_EQ(origin.Number("texture_contrast"), 1);
  EXPECT_TRUE(origin.Has("version"));
  EXPECT_FALSE(origin.Has("follow"));
  const CommandResult run = RunCommand({"run", Out().string(), "--camera-rotation", (Out() / "vehicle.yaml").string(),
                                        "--lever-arm", "1.5", "--out", (folder_ / "out").string(), "--quiet"},
                                       folder_);
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(SimulateTest, DashcamAndVideoAreVideos) {
  const CommandResult plain =
      Simulate({"garage", "--rig", SmallRig(), "--seconds", "5", "--max-frames", "3", "--video"});
  EXPECT_EQ(plain.exit_code, 0) << plain.err;
  const std::string next = "turnscale run " + (Out() / "video.mp4").string() + " --lever-arm 1.5 --camera-height 1.4\n";
  EXPECT_NE(plain.out.find(next), std::string::npos) << "without a turn: " << plain.out;
  EXPECT_EQ(FindDrive(Out()).videos.size(), 1u);
  const CommandResult made = Simulate({"garage", "--rig", "dashcam", "--seconds", "5", "--max-frames", "1", "--quiet"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(made.out + made.err, "");
  EXPECT_EQ(YamlMap(Out() / "rig.yaml").Text("preset"), "dashcam");
  VideoFile video(Out() / "video.mp4");
  ASSERT_TRUE(video.Advance());
  EXPECT_EQ(video.Gray().size(), cv::Size(1920, 1080));
  EXPECT_FALSE(video.Advance());
}

TEST_F(SimulateTest, StreetFollowsARecordedPath) {
  std::string tum;
  for (int i = 0; i < 40; ++i) tum += std::to_string(0.1 * i) + " 0 0 " + std::to_string(0.6 * i) + " 0 0 0 1\n";
  const CommandResult made = Simulate(
      {"street", "--follow", Text("path.tum", tum).string(), "--rig", SmallRig(), "--max-frames", "8", "--quiet"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(made.out + made.err, "");
  const Trajectory poses = ReadTrajectory(Out() / "poses.txt");
  ASSERT_EQ(poses.size(), 8u);
  EXPECT_NEAR(poses[7].world_from_camera.translation.z(), 7 * 0.6, 0.5);
  EXPECT_NEAR(poses[7].world_from_camera.translation.x(), 0, 0.2);
  const YamlMap origin(Out() / "drive.yaml");
  EXPECT_EQ(origin.Text("follow"), (folder_ / "path.tum").string());
  EXPECT_FALSE(origin.Has("seconds"));
}

TEST_F(SimulateTest, ComplaintsAboutAFollowedPathNameItsFileAndThePlace) {
  std::string fast;
  for (int i = 0; i < 10; ++i) fast += std::to_string(0.1 * i) + " 0 0 " + std::to_string(30 * i) + " 0 0 0 1\n";
  ExpectComplaint(Simulate({"street", "--follow", Text("fast.tum", fast).string(), "--rig", SmallRig(), "--quiet"}), 2,
                  {"fast.tum: leg.speeds: is ", " m/s after 0.0 m", "metres and seconds"});
  // Out, half round within 2 m, and back.
  std::string sharp;
  int count = 0;
  const auto add = [&](double x, double z) {
    sharp += std::to_string(0.1 * count++) + " " + std::to_string(x) + " 0 " + std::to_string(z) + " 0 0 0 1\n";
  };
  for (int i = 0; i < 30; ++i) add(0, 0.5 * i);
  for (int i = 0; i < 12; ++i) add(1 - std::cos(i * M_PI / 12), 15 + std::sin(i * M_PI / 12));
  for (int i = 0; i < 30; ++i) add(2, 15 - 0.5 * i);
  ExpectComplaint(Simulate({"street", "--follow", Text("sharp.tum", sharp).string(), "--rig", SmallRig(), "--quiet"}),
                  2, {"sharp.tum: legs: 1", " m along number 0", "too curved", "max_steering_deg"});
  const std::string poses = Text("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 5\n").string();
  const CommandResult times =
      Simulate({"street", "--follow", poses, "--times", Text("times.txt", "0\nnoon\n").string()});
  ExpectComplaint(times, 2, {"times.txt:2: "});
  EXPECT_EQ(times.err.find("poses.txt"), std::string::npos) << times.err;
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(SimulateTest, RecordingsAreNotReplacedByTheDriveThatFollowsThem) {
  fs::create_directories(Out());
  std::string poses;
  std::string times;
  for (int i = 0; i < 10; ++i) {
    poses += "1 0 0 0 0 1 0 0 0 0 1 " + std::to_string(i) + "\n";
    times += std::to_string(0.1 * i) + "\n";
  }
  Text("drive/poses.txt", poses);
  Text("drive/times.txt", times);
  ExpectComplaint(Simulate({"street", "--follow", (Out() / "poses.txt").string(), "--rig", SmallRig(), "--quiet"}), 2,
                  {"drive/times.txt: does not belong to a simulated drive", "--out"});
  EXPECT_EQ(ReadTrajectory(Out() / "poses.txt").size(), 10u);
  EXPECT_TRUE(fs::exists(Out() / "times.txt"));
  EXPECT_FALSE(fs::exists(Out() / "image_0"));
}

TEST_F(SimulateTest, InterruptedDriveSaysSo) {
  Command command(Arguments({"garage", "--rig", SmallRig()}), folder_);
  ASSERT_TRUE(command.WaitForError("lighting the scene"));
  command.Signal(SIGINT);
  const CommandResult result = command.Wait();
  EXPECT_EQ(result.exit_code, 130);
  ASSERT_EQ(result.Complaints().size(), 1u) << result.err;
  EXPECT_NE(result.Complaints()[0].find("drive is incomplete"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(Out() / "times.txt"));
}

TEST_F(SimulateTest, SenselessRigs) {
  ExpectComplaint(SimulateRig("mount:\n  lever_arn: 1\n"), 2,
                  {"rig.yaml:2: mount.lever_arn: unknown key; did you mean 'mount.lever_arm'?"});
  ExpectComplaint(SimulateRig("mount:\n  lever_arm: -1\n"), 2, {"rig.yaml:2: mount.lever_arm: is -1"});
  ExpectComplaint(SimulateRig("preset: lorry\n"), 2,
                  {"rig.yaml:1: preset: is 'lorry'; give paper or kitti or dashcam"});
  ExpectComplaint(SimulateRig("sensor:\n  read_noise: lots\n"), 2, {"rig.yaml:2: sensor.read_noise: is 'lots'"});
  ExpectComplaint(Simulate({"garage", "--rig", "nowhere.yaml"}), 2, {"nowhere.yaml: no such file"});
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(SimulateTest, SenselessOptions) {
  ExpectComplaint(Simulate({"moon"}), 2, {"moon"});
  ExpectComplaint(Simulate({}), 2, {"world"});
  ExpectComplaint(RunCommand({"simulate", "garage"}, folder_), 2, {"--out"});
  ExpectComplaint(Simulate({"garage", "--seed", "-1"}), 2, {"--seed"});
  ExpectComplaint(Simulate({"garage", "--seconds", "0"}), 2, {"--seconds 0"});
  ExpectComplaint(Simulate({"garage", "--texture-contrast", "nan"}), 2, {"--texture-contrast nan"});
  ExpectComplaint(Simulate({"garage", "--threads", "0"}), 2, {"--threads 0"});
  ExpectComplaint(Simulate({"garage", "--threads", "2000"}), 2, {"--threads 2000: give 1 to 1024"});
  ExpectComplaint(Simulate({"garage", "--max-frames", "0"}), 2, {"--max-frames"});
  const std::string poses = Text("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 5\n").string();
  ExpectComplaint(Simulate({"garage", "--follow", poses}), 2, {"--follow", "garage"});
  ExpectComplaint(Simulate({"street", "--follow", poses}), 2, {"poses.txt: has no timestamps", "--times"});
  ExpectComplaint(Simulate({"street", "--times", "t.txt"}), 2, {"--times", "--follow"});
  ExpectComplaint(Simulate({"street", "--follow", "nowhere.txt"}), 2, {"nowhere.txt: no such trajectory"});
  const std::string standing = Text("standing.tum", "0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n").string();
  ExpectComplaint(Simulate({"street", "--follow", standing}), 2, {"standing.tum"});
}

TEST_F(SimulateTest, PlacesThatCannotBeWritten) {
  Text("drive", "a file in the way");
  ExpectComplaint(Simulate({"garage", "--rig", SmallRig(), "--quiet"}), 2, {"drive: is a file"});
  ExpectComplaint(RunCommand({"simulate", "garage", "--quiet", "--out", "/proc/turnscale"}, folder_), 2,
                  {"/proc/turnscale: cannot be made"});
}

TEST_F(SimulateTest, PathIsDrawnOverTheFloorPlan) {
  std::string poses;
  for (int i = 0; i < 30; ++i) poses += "1 0 0 0 0 1 0 0 0 0 1 " + std::to_string(i) + "\n";
  const std::string path = Text("path.txt", poses).string();
  const std::string plan = Text("plan.csv", "outline,x_m,z_m\n0,1,0\n0,1,5\n0,3,5\n").string();
  const fs::path picture = folder_ / "path.svg";
  const CommandResult result =
      RunCommand({"evaluate", path, path, "--picture", picture.string(), "--floor-plan", plan}, folder_);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string svg = TextOf(picture);
  for (const char* part : {"<svg", "fill:#9aa0a8", ">true<", ">estimated<", " m</text>", "</svg>"}) {
    EXPECT_NE(svg.find(part), std::string::npos) << part;
  }
  ExpectComplaint(RunCommand({"evaluate", path, path, "--floor-plan", plan}, folder_), 2, {"--picture"});
  ExpectComplaint(RunCommand({"evaluate", path, path, "--picture", picture.string(), "--floor-plan", path}, folder_), 2,
                  {"path.txt: is not a floor plan"});
}

}  // namespace
}  // namespace turnscale

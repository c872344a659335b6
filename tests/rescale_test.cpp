// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "command_line.h"
#include "turnscale/base/test_files.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/rescale/test_drifting_drive.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

const LeverArm kCar{1.2, 0.004};
constexpr double kUnit = 21.0;
constexpr double kFps = 10;

double Length(const Trajectory& poses) {
  double length = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    length += (poses[i].world_from_camera.translation - poses[i - 1].world_from_camera.translation).norm();
  }
  return length;
}

class RescaleCommandTest : public ::testing::Test {
 protected:
  RescaleCommandTest() : folder_(ScratchPath("rescale")) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~RescaleCommandTest() override { fs::remove_all(folder_); }

  std::string Path(const std::string& name) const { return (folder_ / name).string(); }

  std::string Text(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return Path(name);
  }

  CommandResult Run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "rescale");
    arguments.insert(arguments.end(), {"--out", Path("metric.tum")});
    return RunCommand(arguments, folder_);
  }

  void ExpectMetres(const std::vector<std::string>& arguments, int poses) const {
    std::vector<std::string> all = arguments;
    all.insert(all.end(), {"--lever-arm", "1.2"});
    const CommandResult result = Run(all);
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    const Trajectory metric = ReadTrajectory(folder_ / "metric.tum");
    ASSERT_EQ(metric.size(), poses);
    EXPECT_NEAR(Length(metric) / (kUnit * Length(drive_.trajectory)), 1, 0.012);
  }

  std::string Tum() const {
    std::string text;
    for (const StampedPose& pose : drive_.trajectory) text += TumLine(pose);
    return Text("drive.tum", text);
  }

  fs::path folder_;
  ScaledDrive drive_ =
      MakeScaledDrive(CityRoute(6), kCar, Eigen::Quaterniond::Identity(), kUnit, {.position = 0.002}, 2);
  int poses_ = static_cast<int>(drive_.trajectory.size());
};

TEST_F(RescaleCommandTest, ReadsEveryFormat) {
  std::string kitti;
  std::string numbered;
  std::string euroc = "#timestamp,p_x,p_y,p_z,q_w,q_x,q_y,q_z\n";
  for (int i = 0; i < poses_; ++i) {
    const RigidTransform& pose = drive_.trajectory[i].world_from_camera;
    kitti += KittiLine(pose, 12);
    if (i % 2 == 0) numbered += std::to_string(i) + " " + KittiLine(pose, 12);
    const Eigen::Vector3d& t = pose.translation;
    const Eigen::Quaterniond& q = pose.rotation;
    euroc += fmt::format("{},{},{},{},{},{},{},{}\n", 1'400'000'000'000'000'000 + i * 100'000'000LL, t.x(), t.y(),
                         t.z(), q.w(), q.x(), q.y(), q.z());
  }
  ExpectMetres({Tum()}, poses_);
  ExpectMetres({Text("12.txt", kitti), "--fps", "10"}, poses_);
  ExpectMetres({Text("13.txt", numbered), "--fps", "10", "--drift", "none"}, (poses_ + 1) / 2);
  ExpectMetres({Text("euroc.csv", euroc)}, poses_);
  std::string times;
  for (int i = 0; i < poses_; ++i) times += fmt::format("{}\n", i / kFps);
  ExpectMetres({Path("12.txt"), "--timestamps", Text("stamps.txt", times)}, poses_);
  std::string stamps_in_milliseconds;
  for (int i = 0; i < poses_; ++i) stamps_in_milliseconds += fmt::format("{}\n", 1'400'000'000'000 + i * 100);
  ExpectMetres({Path("12.txt"), "--timestamps", Text("stamps.txt", stamps_in_milliseconds)}, poses_);
}

TEST_F(RescaleCommandTest, TakesHeightsWithAndWithoutALeverArm) {
  constexpr double kHeight = 1.4;
  std::string heights = "time,height,sigma\n";
  for (const StampedPose& pose : drive_.trajectory)
    heights += fmt::format("{},{},{}\n", pose.time, kHeight / kUnit, 0.02 * kHeight / kUnit);
  Text("heights.csv", heights);
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {Tum(), "--heights", Path("heights.csv"), "--report", Path("report")});
    return Run(arguments);
  };
  const CommandResult with = run({"--lever-arm", "1.2"});
  ASSERT_EQ(with.exit_code, 0) << with.err;
  EXPECT_NE(with.out.find("height        camera 1."), std::string::npos) << with.out;
  EXPECT_NE(with.out.find("\nfile          "), std::string::npos) << with.out;
  EXPECT_NE(with.out.find("\nreport        " + Path("report") + "/report.html\n"), std::string::npos) << with.out;
  const auto learned = nlohmann::json::parse(TextOf(folder_ / "report" / "summary.json"));
  EXPECT_NEAR(learned["camera_height_m"], kHeight, 0.015);

  const CommandResult alone = run({"--camera-height", "1.4"});
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  EXPECT_EQ(alone.err, "");
  EXPECT_NEAR(Length(ReadTrajectory(folder_ / "metric.tum")) / (kUnit * Length(drive_.trajectory)), 1, 0.005);
  EXPECT_NE(TextOf(folder_ / "report" / "report.html").find("Scale estimated from the heights above the road"),
            std::string::npos);

  const CommandResult wrong = run({"--lever-arm", "1.2", "--camera-height", "1.8"});
  ASSERT_EQ(wrong.exit_code, 0) << wrong.err;
  EXPECT_NE(wrong.err.find("lever arm and camera height disagree"), std::string::npos) << wrong.err;
}

TEST_F(RescaleCommandTest, RefusesHeightsThatDoNotFit) {
  Text("heights.csv", "time,height\n1000,0.1\n");
  EXPECT_NE(Run({Tum(), "--lever-arm", "1.2", "--heights", Path("heights.csv")})
                .err.find("heights.csv: no height is at a time of the trajectory, 0 to "),
            std::string::npos);
  EXPECT_NE(Run({Tum()}).err.find("--lever-arm: is missing; give it, or --camera-height with --heights"),
            std::string::npos);
  std::string kitti;
  for (const StampedPose& pose : drive_.trajectory) kitti += KittiLine(pose.world_from_camera);
  Text("frames.txt", kitti);
  const CommandResult quiet = Run({Path("frames.txt"), "--lever-arm", "1.2", "--quiet"});
  EXPECT_EQ(quiet.out, "");
  EXPECT_NE(quiet.err.find("frames.txt: no timestamps: side slip is unknown"), std::string::npos) << quiet.err;
  fs::remove(folder_ / "metric.tum");
  // The index of a pose is not its time.
  Text("seconds.csv", "time,height\n1,0.1\n2,0.1\n");
  for (const char* length : {"--lever-arm", "--camera-height"}) {
    ExpectComplaint(Run({Path("frames.txt"), length, "1.2", "--heights", Path("seconds.csv")}), 2,
                    {"frames.txt: no timestamps", "--heights", "give --fps or --timestamps"});
  }
  const CommandResult alone = Run({Tum(), "--camera-height", "1.4"});
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_NE(alone.err.find("--camera-height"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "metric.tum"));
}

TEST_F(RescaleCommandTest, TheRearAxleDoesNotSwingOut) {
  fs::rename(Tum(), Path("trajectory.tum"));
  Text("summary.json", R"({"scale": {"state": "observed"}, "pose_frame": "vehicle"})");
  ExpectComplaint(Run({folder_.string(), "--lever-arm", "1.2"}), 2,
                  {"the poses are those of the rear axle", "without --frame vehicle"});
}

TEST_F(RescaleCommandTest, DoesNotReplaceFilesOfARun) {
  fs::create_directories(folder_ / "drive");
  std::ofstream(folder_ / "drive" / "trajectory.csv") << "frame\n";
  const CommandResult result = Run({Tum(), "--lever-arm", "1.2", "--report", Path("drive")});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("drive: has the results of a run"), std::string::npos) << result.err;
  EXPECT_FALSE(fs::exists(folder_ / "drive" / "summary.json"));
}

TEST_F(RescaleCommandTest, ReplacesNoFileThatItHasNotWritten) {
  fs::create_directories(folder_ / "report");
  const std::string table = Text("report/turns.csv", "mine\n");
  const std::vector<std::string> arguments = {Tum(), "--lever-arm", "1.2", "--report", Path("report")};
  ExpectComplaint(Run(arguments), 2, {table + ": would be replaced, but is not of an earlier rescale"});
  EXPECT_EQ(TextOf(table), "mine\n");
  EXPECT_FALSE(fs::exists(folder_ / "report" / "summary.json"));
  fs::remove(table);
  ASSERT_EQ(Run(arguments).exit_code, 0);
  EXPECT_EQ(Run(arguments).exit_code, 0) << "its own files";
  // Killed while the files were written.
  fs::rename(Path("report/summary.json"), Path("report/summary.json.part"));
  EXPECT_EQ(Run(arguments).exit_code, 0);
  EXPECT_FALSE(fs::exists(folder_ / "report" / "summary.json.part"));
}

TEST_F(RescaleCommandTest, ReplacesNoFileThatItReads) {
  fs::create_directories(folder_ / "report");
  const std::string heights = Text("report/scale.csv", "time,height\n1,0.1\n");
  ExpectComplaint(Run({Tum(), "--lever-arm", "1.2", "--heights", heights, "--report", Path("report")}), 2,
                  {"--report " + heights + ": is also an input file"});
  EXPECT_TRUE(fs::exists(heights));
  const std::string rotation = Text("metric.tum", "yaw_deg: 1\npitch_deg: 2\nroll_deg: 3\n");
  ExpectComplaint(Run({Tum(), "--lever-arm", "1.2", "--camera-rotation", rotation}), 2,
                  {"--out " + rotation + ": is also an input file"});
  EXPECT_EQ(TextOf(rotation).find("yaw_deg"), 0u);
}

TEST_F(RescaleCommandTest, TheReportCanBeExported) {
  ASSERT_EQ(Run({Tum(), "--lever-arm", "1.2", "--report", Path("report")}).exit_code, 0);
  EXPECT_EQ(TextOf(folder_ / "report" / "rescaled.tum"), TextOf(Path("metric.tum")));
  const std::vector<std::string> arguments = {
      "export",   Path("report"), "--gpx",     "--geojson", "--interval",   "0",
      "--origin", "49,8",         "--heading", "90",        "--start-time", "2026-03-22T07:14:05+01:00"};
  const CommandResult result = RunCommand(arguments, folder_);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string gpx = TextOf(folder_ / "report" / "path.gpx");
  EXPECT_NE(gpx.find("<time>2026-03-22T06:14:0"), std::string::npos);
  const auto json = nlohmann::json::parse(TextOf(folder_ / "report" / "path.geojson"));
  EXPECT_EQ(json["features"][0]["geometry"]["coordinates"].size(), static_cast<size_t>(poses_));
  fs::remove(Path("report/rescaled.tum"));
  ExpectComplaint(RunCommand(arguments, folder_), 2, {"rescale again"});
}

TEST_F(RescaleCommandTest, PosesWithoutTimesAreNotExported) {
  std::string kitti;
  for (const StampedPose& pose : ReadTrajectory(Tum())) kitti += KittiLine(pose.world_from_camera, 9);
  ASSERT_EQ(Run({Text("frames.txt", kitti), "--lever-arm", "1.2", "--report", Path("report")}).exit_code, 0);
  ExpectComplaint(RunCommand({"export", Path("report"), "--gpx", "--origin", "49,8", "--heading", "90"}, folder_), 2,
                  {"the poses have no times; rescale again with --fps or --timestamps"});
}

TEST_F(RescaleCommandTest, WritesTheReport) {
  const CommandResult result = Run({Tum(), "--lever-arm", "1.2", "--report", Path("report")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("m per unit"), std::string::npos);
  const auto summary = nlohmann::json::parse(TextOf(folder_ / "report" / "summary.json"));
  EXPECT_EQ(summary["turns"]["found"], 6);
  EXPECT_NEAR(summary["metres_per_unit"]["min"], kUnit, 0.009 * kUnit);
  EXPECT_GT(summary["length_sigma"], 0.02);
  EXPECT_LT(summary["length_sigma"], 0.05);
  EXPECT_FALSE(summary["contradicted"]);
  EXPECT_EQ(summary["warnings"], nlohmann::json::array());
  EXPECT_NEAR(summary["roll_height_m"], 1.1, 0.35);
  EXPECT_LE(summary["roll_height_sigma_m"], 0.35);
  const auto lines = [&](const std::string& name) {
    const std::string text = TextOf(folder_ / "report" / name);
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(lines("scale.csv"), 1 + poses_);
  EXPECT_EQ(lines("turns.csv"), 1 + 6);
  const std::string picture = TextOf(folder_ / "report" / "rescale.svg");
  EXPECT_TRUE(picture.starts_with("<svg") && picture.ends_with("</svg>\n"));
  EXPECT_NE(picture.find("implied speed"), std::string::npos);
  EXPECT_EQ(picture.find("nan"), std::string::npos);
}

TEST_F(RescaleCommandTest, ThePageHasSpeedsAndDeviations) {
  ASSERT_EQ(Run({Tum(), "--lever-arm", "1.2", "--report", Path("report")}).exit_code, 0);
  const std::string page = TextOf(folder_ / "report" / "report.html");
  const std::string start = "<script type=\"application/json\" id=\"data\">";
  const std::size_t begin = page.find(start) + start.size();
  const auto data = nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
  const auto& speeds = data["path"]["speed"];
  ASSERT_GT(speeds.size(), 10u);
  EXPECT_TRUE(speeds[speeds.size() / 2].is_number());
  double largest = 0;
  for (const auto& turn : data["turns"]) largest = std::max(largest, std::abs(turn["deviation"].get<double>()));
  EXPECT_GT(largest, 0);
}

TEST_F(RescaleCommandTest, ThePageCountsFromTheFirstFrameOfTheRun) {
  fs::rename(Tum(), folder_ / "trajectory.tum");
  const auto origin = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {Path("trajectory.tum"), "--lever-arm", "1.2", "--report", Path("report")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CommandResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const std::string page = TextOf(folder_ / "report" / "report.html");
    const size_t begin = page.find("\"timeOrigin\":");
    return page.substr(begin, page.find(',', begin) - begin);
  };
  EXPECT_EQ(origin({}), "\"timeOrigin\":0");
  Text("summary.json", R"({"scale": {"state": "observed"}, "first_frame_s": -12.5})");
  EXPECT_EQ(origin({}), "\"timeOrigin\":-12.5");
}

TEST_F(RescaleCommandTest, DrawsTheDriveFromAbove) {
  const auto path = [&] {
    EXPECT_EQ(Run({Tum(), "--lever-arm", "1.2", "--report", Path("report")}).exit_code, 0);
    const std::string picture = TextOf(folder_ / "report" / "rescale.svg");
    const std::size_t begin = picture.find("<path stroke=\"#222\" stroke-width=\"2\"");
    return picture.substr(begin, picture.find('\n', begin) - begin);
  };
  const std::string seen = path();
  // The same drive in a world whose z axis points up.
  const Eigen::Quaterniond up_from_world = RotationFromVector({-std::numbers::pi / 2, 0, 0});
  for (StampedPose& pose : drive_.trajectory) {
    pose.world_from_camera = RigidTransform{up_from_world, {0, 0, 0}} * pose.world_from_camera;
  }
  const std::string turned = path();
  ASSERT_NEAR(static_cast<double>(turned.size()), static_cast<double>(seen.size()),
              0.01 * static_cast<double>(seen.size()));
  const auto start = [](const std::string& text) { return std::stod(text.substr(text.find(" d=\"M") + 5)); };
  EXPECT_NEAR(start(turned), start(seen), 0.3) << "pixels";
}

// A side slip that is given is known to an eighth, unless its sigma is given too.
TEST_F(RescaleCommandTest, SideSlipIsKeptAsFarAsItIsKnown) {
  const auto slip = [&](std::vector<std::string> extra) {
    extra.insert(extra.begin(), {Tum(), "--lever-arm", "1.2", "--report", Path("report")});
    EXPECT_EQ(Run(extra).exit_code, 0);
    const auto summary = nlohmann::json::parse(TextOf(folder_ / "report" / "summary.json"));
    return std::pair<double, double>(summary["side_slip_s2pm"], summary["side_slip_sigma_s2pm"]);
  };
  EXPECT_NEAR(slip({"--side-slip", "0.002", "--side-slip-sigma", "0"}).first, 0.002, 1e-8);
  EXPECT_EQ(slip({"--side-slip", "0.002", "--side-slip-sigma", "0"}).second, 0);
  EXPECT_NEAR(slip({"--side-slip", "0.004"}).first, 0.004, 0.00006);
  EXPECT_GT(slip({"--side-slip", "0.004"}).second, 0);
  EXPECT_LE(slip({"--side-slip", "0.004"}).second, 0.00048);
  EXPECT_GT(slip({"--side-slip", "0.002", "--side-slip-sigma", "0.0015"}).second, 0);
  // Zero is a guess.
  EXPECT_GT(slip({"--side-slip", "0"}).second, 0.0005);
  EXPECT_GT(slip({}).second, 0);
}

TEST_F(RescaleCommandTest, FindsTheCamerasRotationUnlessItIsGiven) {
  drive_ = MakeScaledDrive(CityRoute(6), kCar,
                           RotationFromYawPitchRoll({20 / kDegreesPerRadian, -9 / kDegreesPerRadian, 0}), kUnit);
  ExpectMetres({Tum()}, poses_);
  ExpectMetres({Tum(), "--camera-rotation", "auto"}, poses_);
  ExpectMetres({Tum(), "--camera-rotation", "20,-9,0"}, poses_);
  drive_ = MakeScaledDrive(CityRoute(6), kCar, RotationFromYawPitchRoll({90 / kDegreesPerRadian, 0, 0}), kUnit);
  ExpectComplaint(Run({Tum(), "--lever-arm", "1.2", "--camera-rotation", "identity"}), 2,
                  {"scale not observable", "sideways", "let the rotation be estimated"});
}

TEST_F(RescaleCommandTest, SameInputSameBytes) {
  Tum();
  ASSERT_EQ(Run({Path("drive.tum"), "--lever-arm", "1.2"}).exit_code, 0);
  const std::string first = TextOf(folder_ / "metric.tum");
  ASSERT_EQ(Run({Path("drive.tum"), "--lever-arm", "1.2"}).exit_code, 0);
  EXPECT_EQ(TextOf(folder_ / "metric.tum"), first);
}

TEST_F(RescaleCommandTest, NoTurnNoMetres) {
  std::string line;
  for (int i = 0; i < 200; ++i) line += fmt::format("{} 0 0 {} 0 0 0 1\n", 0.1 * i, 0.05 * i);
  const CommandResult result = Run({Text("line.tum", line), "--lever-arm", "1.2", "--report", Path("report")});
  ExpectComplaint(result, 2, {"line.tum: scale not observable: no turn", "is needed"});
  EXPECT_FALSE(fs::exists(folder_ / "metric.tum"));
  EXPECT_FALSE(fs::exists(folder_ / "report"));
}

TEST_F(RescaleCommandTest, WithoutTimesItWarns) {
  std::string kitti;
  for (const StampedPose& pose : drive_.trajectory) kitti += KittiLine(pose.world_from_camera);
  const CommandResult result = Run({Text("frames.txt", kitti), "--lever-arm", "1.2", "--report", Path("report")});
  EXPECT_EQ(result.exit_code, 0);
  std::string printed;
  const auto summary = nlohmann::json::parse(TextOf(folder_ / "report" / "summary.json"));
  for (const auto& warning : summary["warnings"]) printed += "warning: " + warning.get<std::string>() + "\n";
  EXPECT_EQ(result.err, printed);
  EXPECT_NE(result.err.find("warning: "), std::string::npos);
  EXPECT_NE(result.err.find("give --fps or --timestamps"), std::string::npos);
}

TEST_F(RescaleCommandTest, TimesThatAreNumbersOfFramesAreNamed) {
  std::string numbered;
  for (int i = 0; i < poses_; ++i) {
    StampedPose pose = drive_.trajectory[i];
    pose.time = i;
    numbered += TumLine(pose);
  }
  Text("numbered.tum", numbered);
  const CommandResult result = Run({Path("numbered.tum"), "--lever-arm", "1.2"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("as slowly as hardly any car does: check the times of the poses, and give --fps if they "
                            "are numbers of frames"),
            std::string::npos)
      << result.err;
  ExpectMetres({Path("numbered.tum"), "--fps", "10"}, poses_);
  // A pose a second, at the speed of a car: too few for the turns, which may be another matter.
  std::string rare;
  for (int second = 0; 10 * second < poses_; ++second) {
    StampedPose pose = drive_.trajectory[10 * second];
    pose.time = second;
    rare += TumLine(pose);
  }
  const CommandResult refused = Run({Text("rare.tum", rare), "--lever-arm", "1.2"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("the times are whole numbers: if they are numbers of frames, give --fps"),
            std::string::npos)
      << refused.err;
}

TEST_F(RescaleCommandTest, NamesAJump) {
  for (int i = 200; i < poses_; ++i) drive_.trajectory[i].world_from_camera.translation.x() += 4;
  const CommandResult result = Run({Tum(), "--lever-arm", "1.2"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("the trajectory jumps by 8"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("m between poses 195 and 201,"), std::string::npos) << result.err;
}

TEST_F(RescaleCommandTest, ComplaintsSayWhatToDo) {
  const std::string tum = Tum();
  ExpectComplaint(Run({tum}), 2, {"--lever-arm"});
  ExpectComplaint(Run({tum, "--lever-arm", "-1"}), 2, {"--lever-arm -1", "above 0"});
  ExpectComplaint(Run({tum, "--lever-arm", "105"}), 2, {"--lever-arm 105", "up to 20"});
  ExpectComplaint(Run({tum, "--lever-arm", "1", "--side-slip", "2"}), 2, {"--side-slip 2", "s^2/m"});
  ExpectComplaint(Run({tum, "--lever-arm", "1", "--lever-arm-sigma", "3"}), 2, {"--lever-arm-sigma 3", "metres"});
  ExpectComplaint(Run({tum, "--lever-arm", "0.5", "--lever-arm-sigma", "0.5"}), 2,
                  {"--lever-arm-sigma 0.5: has to be below the lever arm, 0.5 m"});
  EXPECT_EQ(Run({tum, "--lever-arm", "0.02"}).err.find("sigma"), std::string::npos)
      << "the default sigma is no reason to refuse a short lever arm";
  ExpectComplaint(Run({tum, "--lever-arm", "1", "--side-slip-sigma", "-1"}), 2, {"--side-slip-sigma -1", "s^2/m"});
  ExpectComplaint(Run({tum, "--lever-arm", "1", "--fps", "10"}), 2, {"has timestamps", "leave out --fps"});
  ExpectComplaint(Run({tum, "--lever-arm", "1", "--drift", "some"}), 2, {"--drift"});
  ExpectComplaint(Run({tum, "--lever-arm", "1", "--camera-rotation", "nowhere.yaml"}), 2, {"--camera-rotation"});
  ExpectComplaint(Run({Path("missing.tum"), "--lever-arm", "1"}), 2, {"missing.tum: no such trajectory file"});
  fs::create_symlink("loop", folder_ / "loop");
  ExpectComplaint(Run({Path("loop/a.tum"), "--lever-arm", "1"}), 2, {"loop/a.tum: cannot be read: Too many levels"});
  ExpectComplaint(Run({Text("one.tum", "0 0 0 0 0 0 0 1\n"), "--lever-arm", "1"}), 2,
                  {"one.tum: has fewer than two poses"});
}

}  // namespace
}  // namespace turnscale

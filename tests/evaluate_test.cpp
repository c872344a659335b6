// SPDX-License-Identifier: MIT
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "command_line.h"
#include "turnscale/base/test_files.h"
#include "turnscale/evaluation/test_drive.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr int kPoses = 300;
constexpr double kScale = 1.07;

class EvaluateTest : public ::testing::Test {
 protected:
  EvaluateTest() : folder_(ScratchPath("evaluate")) {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "estimate");
    fs::create_directories(folder_ / "truth");
    for (const auto& [name, poses] : {std::pair("estimate", estimate_), std::pair("truth", truth_)}) {
      std::string tum;
      std::string kitti;
      std::string euroc;
      std::string times;
      for (const StampedPose& pose : poses) {
        tum += TumLine(pose);
        kitti += KittiLine(pose.world_from_camera);
        const Eigen::Vector3d& t = pose.world_from_camera.translation;
        const Eigen::Quaterniond& q = pose.world_from_camera.rotation;
        euroc += fmt::format("{:.0f},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}\n", 1e9 * pose.time, t.x(), t.y(),
                             t.z(), q.w(), q.x(), q.y(), q.z());
        times += std::to_string(pose.time) + "\n";
      }
      Text(fs::path(name) / "drive.tum", tum);
      Text(fs::path(name) / "drive.csv", euroc);
      Text(fs::path(name) / "07.txt", kitti);
      Text(fs::path(name) / "times.txt", times);
    }
  }
  ~EvaluateTest() override { fs::remove_all(folder_); }

  std::string Text(const fs::path& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }

  // The first `lines` of a file of ours, each begun with its number where that is asked for.
  std::string Head(const fs::path& name, int lines, bool numbered = false, int every = 1) const {
    std::ifstream stream(folder_ / name);
    std::string head;
    std::string line;
    for (int i = 0; i < lines && std::getline(stream, line); ++i)
      if (i % every == 0) head += (numbered ? std::to_string(i) + " " : "") + line + "\n";
    return head;
  }

  CommandResult Run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "evaluate");
    for (std::string& argument : arguments)
      if (std::error_code none; fs::exists(folder_ / argument, none)) argument = (folder_ / argument).string();
    return RunCommand(arguments, folder_);
  }

  Json Scored(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--json", "-"});
    const CommandResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.exit_code == 0 ? Json::parse(result.out) : Json();
  }

  void ExpectComplaint(const std::vector<std::string>& arguments, const std::string& part) const {
    const CommandResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_EQ(result.out, "");
    ASSERT_EQ(result.Complaints().size(), 1U) << result.err;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
  }

  // A table of every tenth pose, of which those after 15 s turn.
  static std::string Keyframes() {
    std::string table = "frame,time,keyframe,turning\n";
    for (int i = 0; i < kPoses; i += 10)
      table += std::to_string(i) + "," + std::to_string(0.1 * i) + ",1," + (i > 150 ? "1" : "0") + "\n";
    return table;
  }

  fs::path folder_;
  Trajectory truth_ = WindingDrive(kPoses);
  Trajectory estimate_ = Scaled(truth_, kScale);
};

TEST_F(EvaluateTest, EveryPairingOfFormatsGivesTheSameNumbers) {
  const Json wanted = Scored({"estimate/drive.tum", "truth/drive.tum"});
  EXPECT_EQ(wanted["paired_by"], "time");
  for (const char* estimate : {"estimate/drive.tum", "estimate/drive.csv", "estimate/07.txt"})
    for (const char* truth : {"truth/drive.tum", "truth/drive.csv", "truth/07.txt"}) {
      const Json score = Scored({estimate, truth});
      const bool timed = !std::string(estimate).ends_with("txt") || !std::string(truth).ends_with("txt");
      EXPECT_EQ(score["paired_by"], timed ? "time" : "frame");
      EXPECT_EQ(score["poses"]["paired"], kPoses) << estimate << truth;
      for (const char* name :
           {"/true_path_length_m", "/as_given/path_length_error_percent", "/as_given/kitti/translation_percent",
            "/as_given/scale_error_ratio/turning/rmse_percent", "/position_error/se3/rmse_m",
            "/position_error/sim3/scale"}) {
        const Json::json_pointer place(name);
        EXPECT_NEAR(score[place].get<double>(), wanted[place].get<double>(), 1e-5) << estimate << truth << name;
      }
    }
}

TEST_F(EvaluateTest, AScaleErrorOf7PerCentIsShown) {
  const CommandResult table = Run({"estimate/drive.tum", "truth/drive.tum"});
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_NE(table.out.find("scaled by 0.93458\n"), std::string::npos) << table.out;
  for (const char* row :
       {"path length error                          %       7.000             0.000\n",
        "scale error ratio, RMSE                    %       7.000             0.000\n",
        "  turning steps, median                    %       7.000             0.000\n",
        "paired        300 of 300 poses with 300 of ground truth, by time; ground-truth path length 299.0 m\n"})
    EXPECT_NE(table.out.find(row), std::string::npos) << table.out << row;

  const Json json = Scored({"estimate/drive.tum", "truth/drive.tum"});
  EXPECT_NEAR(json["as_given"]["path_length_error_percent"].get<double>(), 7, 1e-5);
  EXPECT_NEAR(json["as_given"]["scale_error_ratio"]["all"]["rmse_percent"].get<double>(), 7, 1e-5);
  EXPECT_NEAR(json["as_given"]["scale_error_ratio"]["turning"]["median_percent"].get<double>(), 7, 1e-5);
  EXPECT_NEAR(json["rescaled"]["scale"].get<double>(), 1 / kScale, 1e-7);
  EXPECT_NEAR(json["rescaled"]["kitti"]["translation_percent"].get<double>(), 0, 1e-4);
  EXPECT_NEAR(json["turning_angle"]["turning"]["rmse_deg"].get<double>(), 0, 1e-4);
  EXPECT_TRUE(json["alignment_problem"].is_null());
}

TEST_F(EvaluateTest, TheLengthThatARunStatesIsNamedWhereItDiffers) {
  fs::create_directories(folder_ / "run");
  fs::copy_file(folder_ / "estimate/drive.tum", folder_ / "run/trajectory.tum");
  const auto table = [&](const std::string& length) {
    Text("run/summary.json", R"({"distance_m": )" + length + "}");
    return Run({"run/trajectory.tum", "truth/drive.tum"}).out;
  };
  EXPECT_NE(table("315.04").find("path length   estimate 319.9 m from pose to pose; the run states 315.0 m for its"),
            std::string::npos)
      << table("315.04");
  EXPECT_NE(table("319.93").find("path length   estimate 319.9 m from pose to pose\n"), std::string::npos);
  EXPECT_NEAR(Scored({"run/trajectory.tum", "truth/drive.tum"})["path_length_of_run"].get<double>(), 319.93, 1e-9);
}

TEST_F(EvaluateTest, JsonGoesToAFileBesideTheTable) {
  const CommandResult result = Run({"estimate/drive.tum", "truth/drive.tum", "--json", (folder_ / "s.json").string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(result.out.starts_with("estimate ")) << result.out;
  std::ifstream stream(folder_ / "s.json");
  EXPECT_EQ(Json::parse(stream)["poses"]["true"], kPoses);
}

TEST_F(EvaluateTest, TimesComeFromTheOptionOrFromWhereTheBenchmarkKeepsThem) {
  fs::create_directories(folder_ / "kitti/poses");
  fs::create_directories(folder_ / "kitti/sequences/07");
  fs::rename(folder_ / "truth/07.txt", folder_ / "kitti/poses/07.txt");
  // Fewer poses than the truth has: without times they could not be paired.
  Text("part.tum", Head("estimate/drive.tum", 200));
  ExpectComplaint({"part.tum", "kitti/poses/07.txt"}, "07.txt has no timestamps, and 200 estimated poses");
  ExpectComplaint({"part.tum", "kitti/poses/07.txt"}, "--timestamps");
  EXPECT_EQ(Scored({"part.tum", "kitti/poses/07.txt", "--timestamps", "truth/times.txt"})["poses"]["paired"], 200);
  fs::rename(folder_ / "truth/times.txt", folder_ / "kitti/sequences/07/times.txt");
  EXPECT_EQ(Scored({"part.tum", "kitti/poses/07.txt"})["poses"]["paired"], 200);
}

TEST_F(EvaluateTest, PosesWithoutTimesArePairedOneByOne) {
  fs::remove(folder_ / "truth/times.txt");
  const Json score = Scored({"estimate/drive.tum", "truth/07.txt"});
  EXPECT_EQ(score["paired_by"], "frame");
  EXPECT_NEAR(score["as_given"]["path_length_error_percent"].get<double>(), 7, 1e-5);
  Text("part.txt", Head("estimate/07.txt", 200));
  ExpectComplaint({"part.txt", "truth/07.txt"}, "the estimate has 200 poses and the ground truth 300");
}

TEST_F(EvaluateTest, StepsAreThoseOfTheTableBesideTheEstimate) {
  const std::string metres = "of 1 m of ground-truth path length";
  EXPECT_EQ(Scored({"estimate/drive.tum", "truth/drive.tum"})["steps"], metres);
  const std::string table = Text("estimate/trajectory.csv", Keyframes());
  const Json score = Scored({"estimate/drive.tum", "truth/drive.tum"});
  EXPECT_EQ(score["steps"], "between the keyframes of " + table);
  EXPECT_EQ(score["as_given"]["scale_error_ratio"]["all"]["count"], 29);
  EXPECT_EQ(score["as_given"]["scale_error_ratio"]["turning"]["count"], 14);

  Text("estimate/trajectory.csv", "frame,time\n");
  EXPECT_EQ(Scored({"estimate/drive.tum", "truth/drive.tum"})["steps"], metres) << "a table of something else";
  ExpectComplaint({"estimate/drive.tum", "truth/drive.tum", "--keyframes", "estimate/trajectory.csv"},
                  "trajectory.csv: has no column 'keyframe'");
  Text("late.csv", "frame,time,keyframe,turning\n900,90,1,0\n910,91,1,0\n");
  ExpectComplaint({"estimate/drive.tum", "truth/drive.tum", "--keyframes", "late.csv"}, "fewer than two");
  ExpectComplaint({"estimate/drive.tum", "truth/drive.tum", "--keyframes", "nowhere.csv"}, "nowhere.csv");
}

TEST_F(EvaluateTest, KeyframesFindTheirFramesInNumberedFiles) {
  Text("keys.csv", Keyframes());
  // Every fifth pose, with its frame's number: the keyframes' frames are not their places in the file.
  Text("numbered.txt", Head("estimate/07.txt", kPoses, true, 5));
  fs::remove(folder_ / "estimate/times.txt");
  fs::remove(folder_ / "truth/times.txt");
  Text("sparse/numbered.txt", Head("truth/07.txt", kPoses, true, 5));
  for (const auto& [estimate, truth] :
       {std::pair("numbered.txt", "truth/07.txt"), std::pair("estimate/07.txt", "truth/07.txt"),
        std::pair("numbered.txt", "sparse/numbered.txt"), std::pair("estimate/drive.tum", "truth/07.txt"),
        std::pair("estimate/07.txt", "truth/drive.tum")}) {
    const Json score = Scored({estimate, truth, "--keyframes", "keys.csv"});
    EXPECT_EQ(score["paired_by"], "frame") << estimate << " " << truth;
    EXPECT_EQ(score["as_given"]["scale_error_ratio"]["all"]["count"], 29) << estimate << " " << truth;
    EXPECT_EQ(score["as_given"]["scale_error_ratio"]["turning"]["count"], 14) << estimate << " " << truth;
  }
}

TEST_F(EvaluateTest, TheFolderOfARunStandsForItsTrajectory) {
  ExpectComplaint({"estimate", "truth/drive.tum"}, "estimate: is a folder without the trajectory.tum of a run");
  fs::rename(folder_ / "estimate/drive.tum", folder_ / "estimate/trajectory.tum");
  Text("estimate/trajectory.csv", Keyframes());
  const Json score = Scored({"estimate", "truth/drive.tum"});
  EXPECT_EQ(score["estimate"], (folder_ / "estimate/trajectory.tum").string());
  EXPECT_EQ(score["poses"]["paired"], kPoses);
  EXPECT_EQ(score["steps"], "between the keyframes of " + (folder_ / "estimate/trajectory.csv").string());
}

TEST_F(EvaluateTest, RunsThatAreUpToScaleAndRunsAsTruthAreNamed) {
  fs::rename(folder_ / "estimate/drive.tum", folder_ / "estimate/trajectory.tum");
  Text("estimate/summary.json", R"({"scale": {"state": "observed"}})");
  EXPECT_EQ(Run({"estimate", "truth/drive.tum"}).err, "");
  Text("estimate/summary.json", R"({"scale": {"state": "pending"}})");
  const CommandResult pending = Run({"estimate", "truth/drive.tum"});
  EXPECT_EQ(pending.exit_code, 0);
  EXPECT_NE(pending.err.find("trajectory.tum: is up to scale"), std::string::npos) << pending.err;
  const std::string page = (folder_ / "page.html").string();
  ASSERT_EQ(Run({"estimate", "truth/drive.tum", "--report", page}).exit_code, 0);
  EXPECT_NE(TextOf(page).find("is up to scale (pending)"), std::string::npos);
  EXPECT_NE(TextOf(page).find(R"("unit":"units")"), std::string::npos);
  EXPECT_NE(TextOf(page).find("Metres per unit"), std::string::npos);
  Text("estimate/summary.json", R"({"scale": {"state": "observed"}, "pose_frame": "vehicle"})");
  const std::string of_axle = Run({"estimate", "truth/drive.tum"}).err;
  EXPECT_NE(of_axle.find("trajectory.tum: has the poses of the rear axle"), std::string::npos) << of_axle;
  const CommandResult swapped = Run({"truth/drive.tum", "estimate"});
  EXPECT_NE(swapped.err.find("trajectory.tum: is the result of a run, not ground truth"), std::string::npos)
      << swapped.err;
}

TEST_F(EvaluateTest, ThePageCountsFromTheFirstFrameOfTheRun) {
  fs::rename(folder_ / "estimate/drive.tum", folder_ / "estimate/trajectory.tum");
  Text("estimate/summary.json", R"({"scale": {"state": "observed"}, "first_frame_s": -12.5})");
  const std::string page = (folder_ / "page.html").string();
  const CommandResult result = Run({"estimate", "truth/drive.tum", "--report", page});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(TextOf(page).find(R"("timeOrigin":-12.5)"), std::string::npos);
}

TEST_F(EvaluateTest, AnOnlineTrajectoryIsInMetresFromSomeTimeOn) {
  fs::rename(folder_ / "estimate/drive.tum", folder_ / "estimate/live.tum");
  const double begin = estimate_.front().time;
  const auto err = [&](const std::string& scale) {
    Text("estimate/summary.json",
         R"({"first_frame_s": )" + std::to_string(begin - 2) + R"(, "scale": {"state": "observed")" + scale + "}}");
    return Run({"estimate/live.tum", "truth/drive.tum"}).err;
  };
  const auto expect = [&](const std::string& scale, const std::string& warning) {
    EXPECT_NE(err(scale).find("live.tum: " + warning), std::string::npos) << err(scale);
  };
  EXPECT_EQ(err(R"(, "live_metres_from_s": )" + std::to_string(begin)), "");
  expect(R"(, "live_metres_from_s": )" + std::to_string(begin + 1.5), "poses before 3.5 s are");
  expect(R"(, "live_metres_from_s": null)", "is up to scale, as the scale was not known before the end");
  expect("", "poses from before the scale was known, if any,");  // an older version's
}

TEST_F(EvaluateTest, NoFileThatIsReadAndNoResultOfARunIsReplaced) {
  const auto refuses = [&](std::vector<std::string> arguments, const fs::path& file, const std::string& why) {
    const std::string text = TextOf(file);
    arguments.push_back(file.string());
    ExpectComplaint(arguments, file.string() + ": " + why);
    EXPECT_EQ(TextOf(file), text);
  };
  const std::string read = "is also an input file";
  const std::string rotation = Text("car.yaml", "yaw_deg: 1\npitch_deg: 2\nroll_deg: 3\n");
  refuses({"estimate/drive.tum", "truth/drive.tum", "--camera-rotation", rotation, "--json"}, rotation, read);
  refuses({"estimate/07.txt", "truth/drive.tum", "--json"}, folder_ / "estimate/times.txt", read);
  refuses({"estimate/drive.tum", "truth/07.txt", "--picture"}, folder_ / "truth/times.txt", read);
  Text("estimate/trajectory.csv", Keyframes());
  refuses({"estimate/drive.tum", "truth/drive.tum", "--report"}, folder_ / "estimate/trajectory.csv", read);
  const std::string result = "is a file of the results of a run";
  fs::rename(folder_ / "estimate/drive.tum", folder_ / "estimate/live.tum");
  for (const char* name : {"summary.json", "map.ply", "report.html"})
    refuses({"truth/drive.tum", "truth/drive.csv", "--json"}, Text(fs::path("estimate") / name, "old"), result);
  Text("truth/summary.json", "of an evaluation");
  EXPECT_EQ(Run({"truth/drive.tum", "truth/drive.csv", "--json", "truth/summary.json"}).exit_code, 0) << "of no run";
}

TEST_F(EvaluateTest, TimesThatAreOfNoUseAreRefused) {
  ExpectComplaint({"estimate/drive.tum", "truth/drive.tum", "--timestamps", "truth/times.txt"},
                  "both files have timestamps");
  ExpectComplaint({"estimate/07.txt", "truth/07.txt", "--timestamps", "truth/times.txt"}, "associated by frame number");
  ExpectComplaint({"estimate/07.txt", "truth/07.txt", "--time-tolerance", "7"}, "associated by frame number");
}

TEST_F(EvaluateTest, ClocksThatDifferAreDoubted) {
  EXPECT_TRUE(Scored({"estimate/drive.tum", "truth/drive.tum"})["warnings"].empty());
  // A truth of fewer poses, at the same times.
  Text("sparse.tum", Head("truth/drive.tum", kPoses, false, 10));
  EXPECT_EQ(Run({"estimate/drive.tum", "sparse.tum"}).err, "");
  // The estimate's clock is slow: its poses meet those of the truth now and then.
  std::string tum;
  for (StampedPose pose : estimate_) {
    pose.time *= 0.97;
    tum += TumLine(pose);
  }
  Text("slow.tum", tum);
  const CommandResult slow = Run({"slow.tum", "truth/drive.tum"});
  EXPECT_EQ(slow.exit_code, 0);
  EXPECT_NE(slow.err.find("slow.tum: only "), std::string::npos) << slow.err;
  EXPECT_NE(slow.err.find("300 (estimate) and 291 (ground truth)"), std::string::npos) << slow.err;
  const Json warnings = Scored({"slow.tum", "truth/drive.tum"})["warnings"];
  ASSERT_EQ(warnings.size(), 1);
  EXPECT_NE(warnings[0].get<std::string>().find("slow.tum: only "), std::string::npos) << warnings;
}

TEST_F(EvaluateTest, PosesOfOneDriveWithOtherTimesCanBePairedByFrame) {
  fs::create_directories(folder_ / "run");
  fs::create_directories(folder_ / "kitti");
  std::string times;
  std::string tum;
  std::string kitti;
  for (StampedPose pose : estimate_) {
    times += fmt::format("{}\n", pose.time);
    pose.time *= 0.97;
    tum += TumLine(pose);
    kitti += KittiLine(pose.world_from_camera);
  }
  Text("run/trajectory.tum", tum);
  Text("run/trajectory.kitti.txt", kitti);
  Text("kitti/poses.txt", kitti);
  Text("kitti/times.txt", times);
  const std::string twin = (folder_ / "run/trajectory.kitti.txt").string();
  const CommandResult by_time = Run({"run", "kitti/poses.txt"});
  EXPECT_EQ(by_time.exit_code, 0);
  EXPECT_NE(by_time.err.find("poses are paired by time, though both files have 300"), std::string::npos) << by_time.err;
  EXPECT_NE(by_time.err.find("give turnscale evaluate " + twin + " instead"), std::string::npos) << by_time.err;
  EXPECT_EQ(by_time.err.find("--time-tolerance"), std::string::npos);
  EXPECT_EQ(Run({twin, "kitti/poses.txt"}).err, "");
}

TEST_F(EvaluateTest, OtherBodyAxesAreTurnedAndNamed) {
  // As a vehicle's inertial unit gives them, in a world whose z axis is up.
  Eigen::Matrix3d body_from_camera;
  body_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  const Eigen::Quaterniond body(body_from_camera);
  const auto in_body_axes = [&](Trajectory path) {
    std::string tum;
    for (StampedPose& pose : path) {
      pose.world_from_camera = {body * pose.world_from_camera.rotation * body.conjugate(),
                                body * pose.world_from_camera.translation};
      tum += TumLine(pose);
    }
    return tum;
  };
  Text("truth/body.tum", in_body_axes(truth_));
  Text("estimate/body.tum", in_body_axes(estimate_));
  const std::string estimate = (folder_ / "estimate/body.tum").string();
  const std::string truth = (folder_ / "truth/body.tum").string();
  Json wanted = Scored({"estimate/drive.tum", "truth/drive.tum"});
  EXPECT_GT(wanted["turning_angle"]["turning"]["count"].get<int>(), 30);
  const auto expect_same = [&](const std::string& a, const std::string& b, const std::string& warning) {
    const Json score = Scored({a, b});
    for (const char* name : {"/as_given/kitti/translation_percent", "/as_given/kitti/rotation_deg_per_100m",
                             "/rescaled/kitti/translation_percent", "/turning_angle/turning/count",
                             "/turning_angle/turning/rmse_deg", "/position_error/first_poses_equal/rmse_m"}) {
      const Json::json_pointer place(name);
      EXPECT_NEAR(score[place].get<double>(), wanted[place].get<double>(), 1e-4) << a << b << name;
    }
    ASSERT_EQ(score["warnings"].size(), warning.empty() ? 0U : 1U) << score["warnings"];
    if (!warning.empty()) EXPECT_EQ(score["warnings"][0].get<std::string>().find(warning), 0U) << score["warnings"];
  };
  const std::string axes = ": the axes of its poses (x forward, y left, z up) are not those of the ";
  expect_same("estimate/drive.tum", truth, truth + axes + "estimate");
  expect_same(estimate, "truth/drive.tum", estimate + axes + "ground truth");
  expect_same(estimate, truth, "");
}

TEST_F(EvaluateTest, MotionsThatDoNotFitInAnyAxesAreDoubted) {
  std::string tum;
  for (StampedPose pose : Moved(truth_, {RotationFromVector({0, 0.8, 0}), {100, 0, 50}})) {
    pose.world_from_camera = pose.world_from_camera.inverse();
    tum += TumLine(pose);
  }
  const std::string inverse = Text("truth/inverse.tum", tum);
  const CommandResult result = Run({"estimate/drive.tum", inverse});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("inverse.tum: its poses are camera_from_world, and rotation"), std::string::npos)
      << result.err;
}

TEST_F(EvaluateTest, InversePosesAreNamed) {
  // Round three blocks: straights in different directions tell which of the two poses are inverse.
  Trajectory blocks;
  RigidTransform pose;
  for (int i = 0; i < kPoses; ++i) {
    blocks.push_back({0.1 * i, pose});
    pose = pose * RigidTransform{RotationFromVector({0, i % 30 < 10 ? 0.05 * M_PI : 0, 0}), {0, 0, 1}};
  }
  std::string given;
  std::string inverse;
  for (const StampedPose& stamped : blocks) {
    given += TumLine(stamped);
    inverse += TumLine({stamped.time, stamped.world_from_camera.inverse()});
  }
  Text("blocks.tum", given);
  Text("inverse.tum", inverse);
  for (const auto& [estimate, truth] :
       {std::pair("inverse.tum", "blocks.tum"), std::pair("blocks.tum", "inverse.tum")}) {
    const Json warnings = Scored({estimate, truth})["warnings"];
    ASSERT_EQ(warnings.size(), 1U) << warnings;
    const std::string warning = warnings[0].get<std::string>();
    EXPECT_NE(warning.find("inverse.tum: its poses are camera_from_world"), std::string::npos) << warning;
    EXPECT_NE(warning.find("give the inverse poses"), std::string::npos) << warning;
  }
  EXPECT_TRUE(Scored({"blocks.tum", "blocks.tum"})["warnings"].empty());
}

TEST_F(EvaluateTest, TheCamerasMountingTurnsTheTurningAngle) {
  const auto all = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"tilted.tum", "truth/drive.tum"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Scored(arguments)["turning_angle"]["all"]["rmse_deg"].get<double>();
  };
  // The estimate rolls by a hundredth of a radian from pose to pose: seen from a camera that looks to the side, yaw.
  std::string tum;
  for (size_t i = 0; i < estimate_.size(); ++i) {
    StampedPose pose = estimate_[i];
    pose.world_from_camera.rotation =
        pose.world_from_camera.rotation * RotationFromVector({0, 0, 0.01 * static_cast<double>(i)});
    tum += TumLine(pose);
  }
  Text("tilted.tum", tum);
  EXPECT_GT(std::abs(all({"--camera-rotation", "0,60,0"}) - all({})), 0.2);
  ExpectComplaint({"tilted.tum", "truth/drive.tum", "--camera-rotation", "1,2"}, "--camera-rotation '1,2'");
}

TEST_F(EvaluateTest, NumbersThatCannotBeWrittenAreAnError) {
  const std::string estimate = (folder_ / "estimate/drive.tum").string();
  const std::string truth = (folder_ / "truth/drive.tum").string();
  for (const auto& more : std::vector<std::vector<std::string>>{{}, {"--json", "-"}}) {
    std::vector<std::string> arguments = {"evaluate", estimate, truth};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CommandResult result = RunCommand(arguments, folder_, "/dev/full");
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_EQ(result.err, "turnscale: standard output: cannot be written: No space left on device\n");
  }
  const std::string nowhere = (folder_ / "nowhere/score.json").string();
  ExpectComplaint({"estimate/drive.tum", "truth/drive.tum", "--json", nowhere},
                  nowhere + ": cannot be written: No such file or directory; choose another place\n");
}

TEST_F(EvaluateTest, NamesThatAreNoUtf8) {
  fs::rename(folder_ / "estimate/drive.tum", folder_ / "caf\xe9.tum");
  EXPECT_TRUE(
      Scored({"caf\xe9.tum", "truth/drive.tum"})["estimate"].get<std::string>().ends_with("caf\xef\xbf\xbd.tum"));
}

TEST_F(EvaluateTest, BadInputEndsWithCode2) {
  ExpectComplaint({"nowhere.tum", "truth/drive.tum"}, "nowhere.tum: no such trajectory file");
  ExpectComplaint({"estimate/drive.tum", "nowhere.tum"}, "nowhere.tum: no such trajectory file");
  fs::create_symlink("loop", folder_ / "loop");
  const std::string looped = (folder_ / "loop/a.tum").string();
  ExpectComplaint({looped, "truth/drive.tum"}, looped + ": cannot be read: Too many levels of symbolic links");
  ExpectComplaint({"estimate/drive.tum", "truth/drive.tum", "--keyframes", "nowhere.csv"},
                  "nowhere.csv: no such table of keyframes");
  ExpectComplaint({"estimate/drive.tum"}, "GROUND_TRUTH");
  const std::string estimate = (folder_ / "estimate/drive.tum").string();
  for (const char* option : {"--json", "--picture"})
    ExpectComplaint({estimate, "truth/drive.tum", option, estimate}, estimate + ": is also an input file");
  EXPECT_TRUE(Head("estimate/drive.tum", 1).starts_with("0.0")) << "untouched";
  for (const char* tolerance : {"-1", "nan"})
    ExpectComplaint({"estimate/drive.tum", "truth/drive.tum", "--time-tolerance", tolerance}, "--time-tolerance");
  ExpectComplaint({"estimate/drive.tum", Text("later.tum", "1000 0 0 0 0 0 0 1\n1001 0 0 1 0 0 0 1\n")},
                  "no pose of the estimate");
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/run/run_writer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/run/run_summary.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

// Of a camera that looks along the car.
const Eigen::Quaterniond kAhead = Eigen::Quaterniond::Identity();

FrameResult Frame(int number, double scale = 1, bool posed = true) {
  FrameResult frame;
  frame.frame = number;
  frame.time = 0.1 * number;
  if (!posed) return frame;
  frame.state = TrackingState::kTracked;
  frame.world_from_camera = RigidTransform{RotationFromVector({0, 0.1 * number, 0}), {0, 0, scale * number}};
  return frame;
}

std::vector<FrameResult> Frames(int count, double scale) {
  std::vector<FrameResult> frames;
  for (int i = 0; i < count; ++i) frames.push_back(Frame(i, scale));
  return frames;
}

class RunWriterTest : public ::testing::Test {
 protected:
  RunWriterTest() : folder_(ScratchPath("folder")) { fs::remove_all(folder_); }
  ~RunWriterTest() override { fs::remove_all(folder_); }

  Trajectory Tum() const { return ReadTrajectory(folder_ / "trajectory.tum"); }

  fs::path folder_;
};

TEST_F(RunWriterTest, LiveGrowsAndTheTrajectoryIsWrittenAsAWhole) {
  RunWriter writer({folder_ / "deep"});
  folder_ /= "deep";
  for (int i = 0; i < 3; ++i) writer.Add(Frame(i, 1, false), kAhead);
  EXPECT_EQ(TextOf(folder_ / "live.tum.part"), "") << "no pose yet";
  for (int i = 3; i < 5; ++i) writer.Add(Frame(i), kAhead);
  EXPECT_EQ(ReadTrajectory(folder_ / "live.tum.part").size(), 2u) << "on disk at once";
  EXPECT_FALSE(fs::exists(folder_ / "trajectory.tum"));

  writer.WriteTrajectory(Frames(6, 3), kAhead, ScaleState::kObserved);
  const Trajectory refined = Tum();
  ASSERT_EQ(refined.size(), 6u);
  EXPECT_NEAR(refined[2].world_from_camera.translation.z(), 6, 1e-9);
  EXPECT_EQ(ReadTrajectory(folder_ / "trajectory.kitti.txt").size(), 6u);
  EXPECT_FALSE(fs::exists(folder_ / "live.tum")) << "still grows";
  writer.EndLive();
  EXPECT_NEAR(ReadTrajectory(folder_ / "live.tum")[0].world_from_camera.translation.z(), 3, 1e-9) << "causal";
  for (const auto& entry : fs::directory_iterator(folder_)) EXPECT_NE(entry.path().extension(), ".part");
}

TEST_F(RunWriterTest, VehiclePosesFollowTheRearAxle) {
  EXPECT_THROW(RunWriter({folder_, PoseFrame::kVehicle}), InputError) << "no lever arm";
  const RunWriter writer({folder_, PoseFrame::kVehicle, 1.5});
  const Eigen::Quaterniond rotation = RotationFromYawPitchRoll({0.1, -0.05, 0.02});
  const RigidTransform vehicle_from_camera{rotation, {0, 0, 1.5}};
  // The car turns on the spot about its rear axle: the camera swings, the axle stays.
  const RigidTransform turned{RotationFromVector({0, 0.7, 0}), Eigen::Vector3d::Zero()};
  const RigidTransform world_from_camera = vehicle_from_camera.inverse() * turned * vehicle_from_camera;
  FrameResult frame;
  frame.world_from_camera = world_from_camera;
  frame.vehicle_from_camera = rotation;
  const RigidTransform shown = writer.Shown(frame, rotation, ScaleState::kHeld);
  EXPECT_GT(world_from_camera.translation.norm(), 0.5);
  EXPECT_LT(shown.translation.norm(), 1e-12);
  EXPECT_LT(shown.rotation.angularDistance(turned.rotation), 1e-12);
  // Without the metre the camera's own path, seen along the car's axes.
  EXPECT_NEAR(writer.Shown(frame, rotation, ScaleState::kPending).translation.norm(),
              world_from_camera.translation.norm(), 1e-12);
  frame.world_from_camera = RigidTransform{};
  EXPECT_LT(writer.Shown(frame, rotation, ScaleState::kHeld).translation.norm(), 1e-12);
}

TEST_F(RunWriterTest, ACameraThatIsMovedMovesNoAxle) {
  const RunWriter writer({folder_, PoseFrame::kVehicle, 1.5});
  const Eigen::Quaterniond rotation = RotationFromYawPitchRoll({0.1, -0.05, 0.02});
  FrameResult moved;
  moved.vehicle_from_camera = RotationFromYawPitchRoll({-0.2, 0.1, 0});
  // The car stands, and the camera is turned where it is.
  moved.world_from_camera = RigidTransform{rotation.conjugate() * moved.vehicle_from_camera, {0, 0, 0}};
  const RigidTransform axle = writer.Shown(moved, rotation, ScaleState::kHeld);
  EXPECT_LT(axle.translation.norm(), 1e-12);
  EXPECT_LT(axle.rotation.angularDistance(Eigen::Quaterniond::Identity()), 1e-12);
}

TEST_F(RunWriterTest, PlacesThatCannotBeWritten) {
  std::ofstream(folder_) << "a file in the way";
  EXPECT_THROW(RunWriter({folder_}), InputError);
  EXPECT_THROW(RunWriter({folder_ / "below"}), InputError);
  EXPECT_THROW(RunWriter({"/proc/turnscale"}), InputError);
}

TEST_F(RunWriterTest, TheCheckOfTheFolderLeavesNothingBehind) {
  CheckRunOutput({folder_ / "deep" / "deeper"});
  EXPECT_FALSE(fs::exists(folder_));
  fs::create_directories(folder_);
  CheckRunOutput({folder_});
  CheckRunOutput({folder_ / "deep" / ""});
  EXPECT_TRUE(fs::is_empty(folder_));
  EXPECT_THROW(CheckRunOutput({"/proc/turnscale"}), InputError);
  EXPECT_THROW(CheckRunOutput({"/proc"}), InputError) << "it is there, but no file can be made in it";
  std::ofstream(folder_ / "file") << "in the way";
  EXPECT_THROW(CheckRunOutput({folder_ / "file"}), InputError);
  EXPECT_THROW(CheckRunOutput({folder_ / "file" / "below"}), InputError);
  EXPECT_THROW(CheckRunOutput({folder_, PoseFrame::kVehicle, {}}), InputError) << "no lever arm";
}

TEST_F(RunWriterTest, FullDiskIsNoticedAtTheFirstFrame) {
  fs::create_directories(folder_);
  fs::create_symlink("/dev/full", folder_ / "live.tum");
  RunWriter writer({folder_});
  EXPECT_THROW(writer.Add(Frame(0), kAhead), OutputError);
}

TEST_F(RunWriterTest, FullDiskIsNoticedInEveryFile) {
  for (const char* name :
       {"trajectory.tum", "trajectory.kitti.txt", "trajectory.csv", "turns.csv", "map.ply", "any.txt"}) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    fs::create_symlink("/dev/full", folder_ / name);
    const auto write_all = [&] {
      RunWriter writer({folder_});
      writer.WriteTrajectory(Frames(2, 1), kAhead, ScaleState::kPending);
      writer.WriteTurns({});
      writer.WriteMap({}, kAhead, ScaleState::kPending);
      writer.WriteText("any.txt", "text");
    };
    EXPECT_THROW(write_all(), OutputError) << name;
  }
}

TEST_F(RunWriterTest, OneFileThatCannotBeWrittenKeepsNoOther) {
  fs::create_directories(folder_);
  fs::create_symlink("/dev/full", folder_ / "trajectory.tum");
  RunWriter writer({folder_});
  EXPECT_THROW(writer.WriteTrajectory(Frames(3, 1), kAhead, ScaleState::kPending), OutputError);
  EXPECT_EQ(ReadTrajectory(folder_ / "trajectory.kitti.txt").size(), 3u);
  EXPECT_FALSE(TextOf(folder_ / "trajectory.csv").empty());
}

TEST_F(RunWriterTest, AFolderThatVanishesIsNoFaultOfTheUsers) {
  RunWriter writer({folder_});
  writer.Add(Frame(0), kAhead);
  fs::remove_all(folder_);
  EXPECT_THROW(writer.WriteTrajectory(Frames(2, 1), kAhead, ScaleState::kPending), OutputError);
  EXPECT_THROW(writer.EndLive(), OutputError);
}

TEST_F(RunWriterTest, EarlierResultsAreTakenAway) {
  fs::create_directories(folder_);
  for (const char* name : {"summary.json", "settings.yaml", "live.tum", "trajectory.tum", "trajectory.kitti.txt",
                           "trajectory.csv", "turns.csv", "map.ply", "map.ply.part"}) {
    std::ofstream(folder_ / name) << "old";
  }
  std::ofstream(folder_ / "notes.txt") << "not ours";
  RunWriter writer({folder_});
  writer.EndLive();
  for (const auto& entry : fs::directory_iterator(folder_)) EXPECT_EQ(entry.path().filename(), "notes.txt");
  EXPECT_TRUE(fs::exists(folder_ / "notes.txt"));
}

TEST_F(RunWriterTest, FilesOfNoRunAreRefusedAndStay) {
  fs::create_directories(folder_);
  for (const char* name : {"camera.yaml", "mask.png", "map.ply", "turns.csv", "report.html", "settings.yaml",
                           "trajectory.csv", "summary.json"}) {
    const std::string text = std::string(name) == "summary.json" ? R"({"frames": 3})" : "time,x,y\n";
    std::ofstream(folder_ / name) << text;
    const auto refuses = [&](const auto& make) {
      try {
        make();
      } catch (const InputError& error) {
        return std::string(error.what()) == (folder_ / name).string() +
                                                ": would be replaced, but is not of an earlier run; choose another "
                                                "--out";
      }
      return false;
    };
    EXPECT_TRUE(refuses([&] { CheckRunOutput({folder_}); })) << name;
    EXPECT_TRUE(refuses([&] { RunWriter{{folder_}}; })) << name;
    EXPECT_EQ(TextOf(folder_ / name), text);
    fs::remove(folder_ / name);
    EXPECT_TRUE(fs::is_empty(folder_)) << name;
  }
}

TEST_F(RunWriterTest, AFolderOfARunStaysOneWheneverTheRunIsKilled) {
  const auto write_all = [&](int files) {
    RunWriter writer({folder_});
    if (files > 0) writer.WriteText("settings.yaml", "");
    if (files > 1) writer.WriteText("camera.yaml", "");
    if (files > 2) writer.Add(Frame(0), kAhead);
    if (files > 3) writer.EndLive();
    if (files > 4) writer.WriteTrajectory(Frames(2, 1), kAhead, ScaleState::kPending);
  };
  for (int files = 0; files <= 5; ++files) {
    EXPECT_NO_THROW(write_all(files)) << files;
    EXPECT_NO_THROW(CheckRunOutput({folder_})) << files;
  }
  // Killed while its files were taken away, of which live.tum is the last.
  for (const char* name : {"trajectory.tum", "trajectory.kitti.txt", "trajectory.csv"}) fs::remove(folder_ / name);
  EXPECT_NO_THROW(CheckRunOutput({folder_}));
  // A run without a pose has neither trajectory.
  fs::remove(folder_ / "live.tum");
  EXPECT_THROW(CheckRunOutput({folder_}), InputError);
  std::ofstream(folder_ / "summary.json") << SummaryJson({});
  EXPECT_NO_THROW(CheckRunOutput({folder_}));
}

TEST_F(RunWriterTest, TwoRunsDoNotWriteToOneFolder) {
  const auto refused = [&](const auto& make) {
    try {
      make();
    } catch (const InputError& error) {
      return std::string(error.what()) == folder_.string() + ": another run is writing there; choose another --out";
    }
    return false;
  };
  {
    RunWriter writer({folder_});
    writer.Add(Frame(0), kAhead);
    EXPECT_TRUE(refused([&] { CheckRunOutput({folder_}); }));
    EXPECT_TRUE(refused([&] { RunWriter{{folder_}}; }));
    EXPECT_EQ(ReadTrajectory(folder_ / "live.tum.part").size(), 1u) << "nothing is taken away";
  }
  EXPECT_NO_THROW(CheckRunOutput({folder_}));
  EXPECT_NO_THROW(RunWriter{{folder_}});
}

TEST_F(RunWriterTest, WithoutAPoseThereIsNoLiveTrajectory) {
  RunWriter writer({folder_});
  EXPECT_TRUE(fs::exists(folder_ / "live.tum.part"));
  EXPECT_FALSE(HasPosesOfRun(folder_));
  writer.EndLive();
  writer.EndLive();
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(RunWriterTest, MapHoldsLandmarksAndCameras) {
  RunWriter writer({folder_});
  writer.WriteMap({{{1, 2, 3}, {4, 5, 6}}, {{7, 8, 9}}}, kAhead, ScaleState::kHeld);
  const std::string text = TextOf(folder_ / "map.ply");
  EXPECT_NE(text.find("element vertex 3\n"), std::string::npos);
  const size_t begin = text.find("end_header\n") + 11;
  ASSERT_EQ(text.size() - begin, 3u * 15u);
  float camera[3];
  std::memcpy(camera, text.data() + begin + 30, sizeof(camera));
  EXPECT_EQ(camera[0], 7);
  EXPECT_EQ(camera[2], 9);
}

TEST(RunTables, FrameLineHasACellPerColumn) {
  const auto cells = [](const std::string& line) { return std::count(line.begin(), line.end(), ',') + 1; };
  FrameResult frame = Frame(3);
  EXPECT_EQ(cells(FrameTableLine(frame, frame.world_from_camera)), cells(FrameTableHeader()));
  EXPECT_EQ(cells(FrameTableLine(frame, std::nullopt)), cells(FrameTableHeader()));
  EXPECT_EQ(FrameTableLine(Frame(2, 1, false), std::nullopt), "2,0.200000,initializing,,,,,,,,pending,inf,0,0,0,,,0\n");
  frame.keyframe = true;
  frame.psi = 0.1;
  EXPECT_NE(FrameTableLine(frame, std::nullopt).find(",1,5.729578,,0\n"), std::string::npos);
}

TEST(RunTables, TurnsSayWhyTheyWereNotUsed) {
  TurnResult turn;
  turn.first_frame = 7;
  turn.angle = -1.5;
  turn.reason = "too slow, \"far\" too slow";
  EXPECT_NE(TurnTable({turn}).find("\n7,0,1,-85.9437,,,,,,,,0,\"too slow, \"\"far\"\" too slow\",\n"),
            std::string::npos)
      << TurnTable({turn});
  TurnResult used;
  used.used = true;
  used.unadjusted = "astray";
  EXPECT_TRUE(TurnTable({used}).ends_with(",1,,\"astray\"\n")) << TurnTable({used});
}

TEST(RunTables, TurnsHaveACellPerColumn) {
  TurnResult turn;
  turn.used = true;
  turn.first_keyframe = 4;
  turn.last_keyframe = 12;
  turn.speed = 6.5;
  turn.own = 3.25;
  turn.own_sigma = 0.125;
  turn.smoothed = 3.5;
  turn.smoothed_sigma = 0.0625;
  turn.deviation = -0.5;
  turn.effective_lever_arm = 1.25;
  EXPECT_TRUE(TurnTable({turn}).ends_with("\n0,0,9,0.0000,6.5,3.25,0.125,3.5,0.0625,-0.500,1.25,1,,\n"))
      << TurnTable({turn});
  const std::string table = TurnTable({turn});
  const auto end = table.begin() + static_cast<std::ptrdiff_t>(table.find('\n'));
  EXPECT_EQ(std::count(table.begin(), end, ','), std::count(end, table.end(), ','));
}

TEST(RunTables, SpeedsHaveTimesAndSigmas) {
  EXPECT_EQ(SpeedTable({{0.5, 12.25, 0.1}, {0.6, -0.00001, 0.125}}),
            "time,speed_mps,sigma_mps\n0.500000,12.2500,0.1000\n0.600000,-0.0000,0.1250\n");
}

TEST(RunTables, RotationsAreGivenInDegrees) {
  RotationRecord assumed;
  RotationRecord found{12, 1.2, {}};
  found.mount.found = true;
  found.mount.vehicle_from_camera = RotationFromYawPitchRoll({0.1, 0, 0});
  found.mount.sigma = {0.01, 0.02, 0.03};
  EXPECT_EQ(RotationTable({assumed, found}),
            "frame,time,yaw_deg,pitch_deg,roll_deg,yaw_sigma_deg,pitch_sigma_deg,roll_sigma_deg,estimated\n"
            "0,0.000000,0.000000,0.000000,0.000000,,,,0\n"
            "12,1.200000,5.729578,0.000000,0.000000,0.572958,1.145916,1.718873,1\n");
  EXPECT_TRUE(assumed.Differs(found.mount));
  EXPECT_FALSE(found.Differs(found.mount));
  Mount surer = found.mount;
  surer.sigma.pitch = 0.01;
  EXPECT_TRUE(found.Differs(surer));
}

TEST(RunSummary, CountsAndMeasures) {
  RunSummary summary;
  summary.scale_state = ScaleState::kHeld;
  std::vector<FrameResult> frames = Frames(5, 2);
  frames[1].state = TrackingState::kBridged;
  frames[2].state = TrackingState::kRepeated;
  frames[4].keyframe = true;
  frames[4].scale_sigma = 0.02;
  TurnResult used;
  used.used = true;
  RefinedScale scale;
  scale.turns = {used, {}};
  Summarize(frames, scale, summary);
  summary.unreadable.push_back({2, "x.png: is truncated"});
  const auto json = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_EQ(json["frames"]["total"], 5);
  EXPECT_EQ(json["frames"]["tracked"], 3);
  EXPECT_EQ(json["frames"]["repeated"], 1);
  EXPECT_EQ(json["frames"]["bridged"], 1);
  EXPECT_EQ(json["frames"]["keyframes"], 1);
  EXPECT_EQ(json["frames"]["unreadable"], 1);
  EXPECT_EQ(json["unreadable"][0]["problem"], "x.png: is truncated");
  EXPECT_NEAR(json["distance_m"].get<double>(), 8, 1e-12);
  EXPECT_TRUE(json["distance_units"].is_null());
  EXPECT_EQ(json["turns"]["found"], 2);
  EXPECT_EQ(json["turns"]["used"], 1);
  EXPECT_EQ(json["scale"]["state"], "held");
  EXPECT_TRUE(json["lens"].is_null()) << "not looked for";
  summary.lens = {-0.015, 0.002};
  const auto with_lens = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_EQ(with_lens["lens"]["correction"], -0.015);
  EXPECT_EQ(with_lens["lens"]["sigma"], 0.002);
  EXPECT_TRUE(json["by_all_turns"].is_null());
  summary.car = {0.002, 0.001, 0.0041, 0.0003, false};
  summary.car_evidence.emplace();
  const auto with_car = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_EQ(with_car["by_all_turns"]["side_slip_s2_per_m"], 0.0041);
  EXPECT_NE(
      SummaryText(summary).find("side slip 0.0041 +-0.0003 s^2/m, refined from the default 0.0045 +-0.0020 s^2/m\n"),
      std::string::npos);
  EXPECT_NE(SummaryText(summary).find("; the scale estimate corrects the yaw to +"), std::string::npos);
  EXPECT_NE(SummaryText(summary).find(" +-0.06 deg (by +0.11)\n"), std::string::npos);
  summary.car = {0.002, 0.001, 0, 1e-9, true};
  EXPECT_NE(SummaryText(summary).find("side slip 0, since the estimate would be negative"), std::string::npos);
  EXPECT_TRUE(json["complete"].get<bool>());
  EXPECT_NE(SummaryText(summary).find("8.00 m in "), std::string::npos);
}

TEST(RunSummary, HasWhatTheDriveTellsOfTheCar) {
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  scale.estimate->car_evidence.prior.covariance.setIdentity();
  scale.estimate->car_evidence.posterior.mean[1] = 0.005;
  scale.estimate->car_evidence.posterior.covariance(1, 3) = -0.25;
  RunSummary summary;
  Summarize(Frames(3, 1), scale, summary);
  const auto told = nlohmann::json::parse(SummaryJson(summary))["car_evidence"];
  EXPECT_EQ(told["unknowns"][1], "side_slip_s2_per_m");
  EXPECT_EQ(told["posterior"]["mean"][1], 0.005);
  EXPECT_EQ(told["posterior"]["covariance"][1][3], -0.25);
  EXPECT_EQ(told["prior"]["covariance"][2][2], 1);
  EXPECT_EQ(told["inflation"], 1);
  scale.estimate->uses_single_turns = true;
  RunSummary without;
  Summarize(Frames(3, 1), scale, without);
  EXPECT_TRUE(nlohmann::json::parse(SummaryJson(without))["car_evidence"].is_null());
}

TEST(RunSummary, UpToScaleSaysSo) {
  RunSummary summary;
  Summarize(Frames(3, 1), {}, summary);
  EXPECT_NE(
      SummaryText(summary).find("without --lever-arm, --camera-height or --vehicle the trajectory is up to scale"),
      std::string::npos);
  const auto json = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_TRUE(json["distance_m"].is_null());
  EXPECT_EQ(json["scale"]["known"], false);
  EXPECT_TRUE(json["scale"]["worst_relative_sigma"].is_null());
  EXPECT_TRUE(json["path_sigma"].is_null());
  EXPECT_TRUE(json["warnings"].empty());
}

TEST(RunSummary, SaysHowWellTheLengthIsKnownAndWhereLeast) {
  std::vector<FrameResult> frames = Frames(5, 1);
  for (FrameResult& frame : frames) frame.scale_sigma = 0.02;
  frames[3].scale_sigma = 0.09;
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  scale.estimate->length_sigma = 0.034;
  RunSummary summary;
  summary.scale_state = ScaleState::kHeld;
  Summarize(frames, scale, summary);
  const auto json = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_EQ(json["path_sigma"], 0.034);
  EXPECT_EQ(json["scale"]["worst_relative_sigma"], 0.09);
  EXPECT_NEAR(json["scale"]["worst_at_s"].get<double>(), 0.3, 1e-12);
  EXPECT_TRUE(json["warnings"].empty());
  EXPECT_NE(SummaryText(summary).find("path length +-3.4 % (1 sigma), along the drive at most +-9.0 % (at 0.3 s)"),
            std::string::npos)
      << SummaryText(summary);
}

TEST(RunSummary, WarnsOfACameraTooLowOrTooHighForACar) {
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  const auto warnings = [&](double height, std::optional<double> given = {}) {
    scale.estimate->car.camera_height = height;
    scale.estimate->car.camera_height_sigma = 0.1;
    RunSummary summary;
    summary.vehicle.camera_height = given;
    Summarize(Frames(5, 1), scale, summary);
    return summary.warnings;
  };
  for (const double usual : {0.75, 1.3, 2.5}) EXPECT_TRUE(warnings(usual).empty()) << usual;
  for (const double unusual : {0.65, 2.8}) ASSERT_EQ(warnings(unusual).size(), 1u) << unusual;
  EXPECT_NE(warnings(2.8)[0].find("a camera 2.80 +-0.10 m above the road, which is unusual for a car"),
            std::string::npos);
  EXPECT_EQ(warnings(2.8)[0].find("stabilised"), std::string::npos);
  EXPECT_NE(warnings(0.65)[0].find("check --lever-arm, the calibration and whether the video is stabilised"),
            std::string::npos);
  EXPECT_TRUE(warnings(2.8, 2.8).empty()) << "a lorry's";
}

TEST(RunSummary, WarnsOfStabilisedImages) {
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  RunSummary summary;
  Summarize(Frames(5, 1), scale, summary);
  EXPECT_TRUE(summary.warnings.empty());
  scale.estimate->image_lag = ImageLag{.found = 0.1, .found_sigma = 0.02};
  RunSummary found;
  Summarize(Frames(5, 1), scale, found);
  ASSERT_EQ(found.warnings.size(), 1u);
  EXPECT_TRUE(found.warnings[0].starts_with("the images seem to be stabilised: in turns their orientation lags"));
  RunSummary known;
  known.vehicle.image_lag = 0.12;
  known.vehicle.image_lag_sigma = 0.03;
  Summarize(Frames(5, 1), scale, known);
  ASSERT_EQ(known.warnings.size(), 1u);
  EXPECT_EQ(
      known.warnings[0],
      "the images are taken to be stabilised, with a lag of +0.12 +-0.03 s before and +0.10 +-0.02 s after this "
      "drive: without stabilisation, remove image_lag and image_lag_sigma from the file of the car or the settings");
}

TEST(RunSummary, NamesAYawOfAnEarlierDriveThatIsNotUsed) {
  const auto warnings = [](double found_deg, bool known, int moves) {
    RunSummary summary;
    summary.vehicle.camera_known = known;
    summary.vehicle.yaw_sigma = 0.15 / kDegreesPerRadian;
    summary.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({3.5 / kDegreesPerRadian, 0, 0});
    summary.mount = MountSummary{{found_deg / kDegreesPerRadian, 0, 0}, {0.2 / kDegreesPerRadian, 0, 0}, true, moves};
    Summarize(Frames(5, 1), {}, summary);
    return summary.warnings;
  };
  ASSERT_EQ(warnings(0.4, true, 0).size(), 1u);
  EXPECT_NE(warnings(0.4, true, 0)[0].find("a camera yaw of +0.4 +-0.2 deg, not +3.5 deg as in the file of the car"),
            std::string::npos);
  EXPECT_TRUE(warnings(3.3, true, 0).empty());
  EXPECT_TRUE(warnings(0.4, false, 0).empty()) << "assumed";
  EXPECT_TRUE(warnings(0.4, true, 1).empty()) << "the camera was moved";
}

TEST(RunSummary, NamesTheTurnThatContradicts) {
  RefinedScale scale;
  for (const int first : {10, 50, 90, 130}) {
    TurnResult turn;
    turn.used = first != 50;
    turn.first_frame = first;
    turn.last_frame = first + 20;
    scale.turns.push_back(turn);
  }
  scale.estimate.emplace().converged = true;
  scale.estimate->uses_single_turns = true;
  scale.estimate->test.contradicted = true;
  scale.estimate->test.worst_turn = 2;
  scale.estimate->test.disagreement = 0.17;
  RunSummary summary;
  Summarize(Frames(5, 1), scale, summary);
  ASSERT_EQ(summary.warnings.size(), 1u);
  EXPECT_NE(summary.warnings[0].find("on the scale by 17 %"), std::string::npos) << summary.warnings[0];
  EXPECT_NE(summary.warnings[0].find("frames 90-110"), std::string::npos) << summary.warnings[0];
  EXPECT_NE(summary.warnings[0].find("check the camera's calibration"), std::string::npos) << summary.warnings[0];
  const auto json = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_EQ(json["warnings"][0], summary.warnings[0]);
}

TEST(RunSummary, WhatAWrongCalibrationDoesIsSaidOnce) {
  RefinedScale scale;
  scale.estimate.emplace();
  scale.estimate->converged = true;
  scale.estimate->length_sigma = 1.16;
  scale.contradicted_calibration = {{IntrinsicsParameter::kFocalLength, 500, 600, 10},
                                    {IntrinsicsParameter::kCentreX, 320, 350, 5},
                                    {IntrinsicsParameter::kDistortion, 0, 0.1, 0.01}};
  RunSummary summary;
  Summarize(Frames(5, 1), scale, summary);
  ASSERT_EQ(summary.warnings.size(), 3u);
  for (const std::string& warning : summary.warnings)
    EXPECT_EQ(warning.find("the scale may be off by 116 % or more") != std::string::npos,
              &warning == &summary.warnings.back())
        << warning;
}

TEST(RunSummary, TheHeightIsAsUncertainAsTheScale) {
  RefinedScale scale;
  scale.estimate.emplace();
  scale.estimate->car.camera_height = 1.5;
  scale.estimate->car.camera_height_sigma = 0.03;
  const auto sigma = [&] {
    RunSummary summary;
    Summarize(Frames(5, 1), scale, summary);
    return summary.car->camera_height_sigma;
  };
  EXPECT_EQ(sigma(), 0.03);
  scale.calibration_sigma = 0.2;
  EXPECT_NEAR(sigma(), std::hypot(0.03, 0.3), 1e-12) << "a wrong calibration";
  scale.calibration_sigma = 0;
  scale.estimate->height_conflict = HeightConflict{1.4, 0.014, 1.26, 0.02, false};
  EXPECT_NEAR(sigma(), std::hypot(0.03, 1.5 * 0.5 * std::log(1.4 / 1.26)), 1e-12) << "between two lengths";
  scale.estimate->height_conflict.reset();
  scale.estimate->slip_conflict.emplace();
  scale.estimate->test.disagreement = 0.1;
  EXPECT_NEAR(sigma(), std::hypot(0.03, 0.15), 1e-12) << "an unusual slip";
}

TEST(RunSummary, APathAcrossAGapIsNotMeasuredThere) {
  std::vector<FrameResult> frames = Frames(4, 1);
  // A minute that is not recorded.
  for (FrameResult& frame : frames) frame.time += frame.frame >= 2 ? 60 : 0;
  frames[2].world_from_camera->translation.z() += 100;
  frames[3].world_from_camera->translation.z() += 100;
  RunSummary summary;
  summary.scale_state = ScaleState::kHeld;
  Summarize(frames, {}, summary);
  EXPECT_DOUBLE_EQ(summary.distance, 103);
  EXPECT_DOUBLE_EQ(summary.missing_distance, 101);
  EXPECT_NE(SummaryText(summary).find(
                "path    103.00 m in 60.3 s (6 km/h on average), 4 frames, 0 keyframes; 101.00 m of it not measured\n"),
            std::string::npos)
      << SummaryText(summary);
  EXPECT_EQ(nlohmann::json::parse(SummaryJson(summary))["missing"]["distance_m"], 101);
}

TEST(RunSummary, TheNoiseOfAStandingCarIsNoPath) {
  std::vector<FrameResult> frames = Frames(104, 1);
  for (FrameResult& frame : frames) {
    const bool stands = frame.frame >= 2 && frame.frame < 102;
    const double noise = frame.frame % 2 == 0 ? 0.002 : -0.002;
    frame.world_from_camera->translation.z() = stands ? 2 + noise : frame.frame < 2 ? frame.frame : frame.frame - 99;
    frame.keyframe = frame.frame < 3 || frame.frame >= 102;
  }
  RunSummary summary;
  Summarize(frames, {}, summary);
  EXPECT_NEAR(summary.distance, 4, 0.01);
}

TEST(RunSummary, ACarThatTurnsBackBetweenKeyframesHasDrivenBothWays) {
  std::vector<FrameResult> frames = Frames(11, 1);
  for (FrameResult& frame : frames) {
    // 6 m forward and 4 m back.
    frame.world_from_camera->translation.z() = frame.frame <= 6 ? frame.frame : 12 - frame.frame;
    frame.keyframe = frame.frame == 0 || frame.frame == 10;
  }
  RunSummary summary;
  Summarize(frames, {}, summary);
  EXPECT_NEAR(summary.distance, 10, 1e-9);
}

TEST(RunSummary, WarnsOfClipsThatDoNotFollowOneAnother) {
  std::vector<FrameResult> frames = Frames(8, 1);
  frames[4].state = TrackingState::kBridged;
  const auto warnings = [&](double start, double gap) {
    RunSummary summary;
    summary.clips = {{"card/a.mp4", 0, start, 4, 0}, {"card/b.mp4", start, 8, 4, gap}};
    Summarize(frames, {}, summary);
    return summary.warnings;
  };
  const double seam = frames[4].time;
  ASSERT_EQ(warnings(seam, 0).size(), 1u);
  EXPECT_NE(warnings(seam, 0)[0].find("where a.mp4 ends and b.mp4 begins"), std::string::npos);
  EXPECT_TRUE(warnings(seam, 2).empty()) << "the gap is named already";
  EXPECT_TRUE(warnings(frames[6].time, 0).empty()) << "lost elsewhere";
}

TEST(RunSummary, SaysWhichCameraRotationIsUsed) {
  RunSummary summary;
  summary.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({3 / kDegreesPerRadian, 0, 0});
  EXPECT_NE(SummaryText(summary).find("camera  yaw +3.00, pitch +0.00, roll +0.00 deg, as given\n"), std::string::npos);
  summary.mount = MountSummary{};
  EXPECT_NE(SummaryText(summary).find("camera  yaw +0.00, pitch +0.00, roll +0.00 deg, assumed; no turn"),
            std::string::npos);
}

TEST(RunSummary, WithoutATurnNothingIsSaidToBeFromTurns) {
  RunSummary summary;
  summary.car = CarRefinement{};
  summary.car->camera_height = 1.3;
  summary.car->yaw_error = 0.01;
  summary.car_evidence.emplace();
  EXPECT_EQ(SummaryText(summary).find("corrects the yaw"), std::string::npos);
  EXPECT_EQ(SummaryText(summary).find("side slip"), std::string::npos);
  EXPECT_NE(SummaryText(summary).find("height  camera 1.300"), std::string::npos);
  summary.turns_used = 1;
  EXPECT_NE(SummaryText(summary).find("corrects the yaw"), std::string::npos);
  EXPECT_NE(SummaryText(summary).find("side slip"), std::string::npos);
}

}  // namespace
}  // namespace turnscale

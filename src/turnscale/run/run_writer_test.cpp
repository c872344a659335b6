// SPDX-License-Identifier: MIT
#include "turnscale/run/run_writer.h"

#include <algorithm>
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
#include "turnscale/run/test_path.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

// Of a camera that looks along the car.
const Eigen::Quaterniond kAhead = Eigen::Quaterniond::Identity();

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
  for (int i = 0; i < 3; ++i) writer.Add(PathFrame(i, 1, false), kAhead);
  EXPECT_EQ(TextOf(folder_ / "live.tum.part"), "") << "no pose yet";
  for (int i = 3; i < 5; ++i) writer.Add(PathFrame(i), kAhead);
  EXPECT_EQ(ReadTrajectory(folder_ / "live.tum.part").size(), 2u) << "on disk at once";
  EXPECT_FALSE(fs::exists(folder_ / "trajectory.tum"));

  writer.WriteTrajectory(PathFrames(6, 3), kAhead, ScaleState::kObserved);
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
  EXPECT_THROW(writer.Add(PathFrame(0), kAhead), OutputError);
}

TEST_F(RunWriterTest, FullDiskIsNoticedInEveryFile) {
  for (const char* name :
       {"trajectory.tum", "trajectory.kitti.txt", "trajectory.csv", "turns.csv", "map.ply", "any.txt"}) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    fs::create_symlink("/dev/full", folder_ / name);
    const auto write_all = [&] {
      RunWriter writer({folder_});
      writer.WriteTrajectory(PathFrames(2, 1), kAhead, ScaleState::kPending);
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
  EXPECT_THROW(writer.WriteTrajectory(PathFrames(3, 1), kAhead, ScaleState::kPending), OutputError);
  EXPECT_EQ(ReadTrajectory(folder_ / "trajectory.kitti.txt").size(), 3u);
  EXPECT_FALSE(TextOf(folder_ / "trajectory.csv").empty());
}

TEST_F(RunWriterTest, AFolderThatVanishesIsNoFaultOfTheUsers) {
  RunWriter writer({folder_});
  writer.Add(PathFrame(0), kAhead);
  fs::remove_all(folder_);
  EXPECT_THROW(writer.WriteTrajectory(PathFrames(2, 1), kAhead, ScaleState::kPending), OutputError);
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
    if (files > 2) writer.Add(PathFrame(0), kAhead);
    if (files > 3) writer.EndLive();
    if (files > 4) writer.WriteTrajectory(PathFrames(2, 1), kAhead, ScaleState::kPending);
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
  std::ofstream(folder_ / "summary.json") << SummaryJson(RunSummary());
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
    writer.Add(PathFrame(0), kAhead);
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
  FrameResult frame = PathFrame(3);
  EXPECT_EQ(cells(FrameTableLine(frame, frame.world_from_camera)), cells(FrameTableHeader()));
  EXPECT_EQ(cells(FrameTableLine(frame, std::nullopt)), cells(FrameTableHeader()));
  EXPECT_EQ(FrameTableLine(PathFrame(2, 1, false), std::nullopt),
            "2,0.200000,initializing,,,,,,,,pending,inf,0,0,0,,,0\n");
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

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/run/result_folder.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/run/run_summary.h"
#include "turnscale/run/run_writer.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

class ResultFolderTest : public ::testing::Test {
 protected:
  ResultFolderTest() : folder_(ScratchPath("results")) {}
  ~ResultFolderTest() override { fs::remove_all(folder_); }

  std::string Refusal() const {
    try {
      ReadResultFolder(folder_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(ResultFolderTest, ReadsWhatARunHasWritten) {
  std::vector<FrameResult> frames(3);
  for (int i = 0; i < 3; ++i) {
    frames[i].frame = i;
    frames[i].time = 0.1 * i;
    if (i == 0) continue;
    frames[i].state = i == 1 ? TrackingState::kTracked : TrackingState::kBridged;
    frames[i].world_from_camera = RigidTransform{RotationFromVector({0, 0.3 * i, 0}), {1.0 * i, 2, 3}};
    frames[i].scale_state = i == 1 ? ScaleState::kObserved : ScaleState::kHeld;
    frames[i].scale_sigma = 0.01 * i;
    frames[i].keyframe = i == 1;
  }
  TurnResult turn;
  turn.first_frame = 1;
  turn.last_frame = 2;
  turn.angle = 1.5;
  turn.own = 0.25;
  turn.reason = "too fast, \"by far\"";
  RunSummary summary;
  summary.drive.given.recorded_from = "2023-05-01T12:00:00";
  summary.drive.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({0.1, 0.05, -0.02});
  RunWriter writer({folder_});
  writer.WriteTrajectory(frames, Eigen::Quaterniond::Identity(), ScaleState::kHeld);
  writer.WriteTurns({turn});
  writer.WriteSpeeds({{0.1, 5, 0.25}, {0.2, 5.5, 0.5}});
  writer.WriteRotations({{0, 0, {}}});
  writer.WriteMap({{{1, 2, 3}, {4, 5, -6}}, {{7, 8, 9}}}, Eigen::Quaterniond::Identity(), ScaleState::kHeld);
  writer.WriteText("summary.json", SummaryJson(summary));
  writer.WriteText("settings.yaml", "a: 1\n");

  const ResultFolder read = ReadResultFolder(folder_);
  ASSERT_EQ(read.frames.size(), 3u);
  EXPECT_FALSE(read.frames[0].world_from_camera);
  EXPECT_EQ(read.frames[2].state, TrackingState::kBridged);
  EXPECT_EQ(read.frames[1].scale_state, ScaleState::kObserved);
  EXPECT_EQ(read.frames[2].scale_sigma, 0.02);
  EXPECT_TRUE(read.frames[1].keyframe);
  ASSERT_EQ(read.Poses().size(), 2u);
  EXPECT_LT((read.Poses()[1].world_from_camera.translation - Eigen::Vector3d(2, 2, 3)).norm(), 1e-9);
  ASSERT_EQ(read.turns.size(), 1u);
  EXPECT_NEAR(read.turns[0].angle, 1.5, 1e-6);
  EXPECT_EQ(read.turns[0].smoothed, 0);
  EXPECT_EQ(read.turns[0].reason, turn.reason);
  ASSERT_EQ(read.speeds.size(), 2u);
  EXPECT_EQ(read.speeds[1].speed, 5.5);
  EXPECT_TRUE(read.scale.empty());
  ASSERT_EQ(read.rotations.size(), 1u);
  EXPECT_FALSE(read.rotations[0].sigma);
  ASSERT_EQ(read.landmarks.size(), 2u);
  EXPECT_EQ(read.landmarks[1], Eigen::Vector3f(4, 5, -6));
  EXPECT_EQ(read.recorded_from, "2023-05-01T12:00:00");
  EXPECT_EQ(read.settings, "a: 1\n");
  EXPECT_LT(read.vehicle_from_body.angularDistance(summary.drive.vehicle.vehicle_from_camera), 1e-9);
}

TEST_F(ResultFolderTest, ColumnsAreFoundByTheirNames) {
  RunWriter writer({folder_});
  writer.WriteText("summary.json", SummaryJson({}));
  writer.WriteText("trajectory.csv",
                   "turning,keyframe,tracked,inliers,scale_sigma,scale_state,qw,qz,qy,qx,z,y,x,state,time,frame\n"
                   "1,0,30,20,0.25,observed,0,0,0,1,3,2,1,tracked,0.5,7\n");
  writer.WriteText("camera_rotation.csv",
                   "roll_sigma_deg,pitch_sigma_deg,yaw_sigma_deg,roll_deg,pitch_deg,yaw_deg,time,frame\n"
                   "0.3,0.2,0.1,3,2,1,0.5,7\n");
  const ResultFolder read = ReadResultFolder(folder_);
  ASSERT_EQ(read.frames.size(), 1u);
  EXPECT_EQ(read.frames[0].frame, 7);
  EXPECT_EQ(read.frames[0].inliers, 20);
  EXPECT_EQ(read.frames[0].scale_sigma, 0.25);
  EXPECT_TRUE(read.frames[0].turning);
  ASSERT_TRUE(read.frames[0].world_from_camera);
  EXPECT_EQ(read.frames[0].world_from_camera->translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(read.frames[0].world_from_camera->rotation.x(), 1);
  ASSERT_EQ(read.rotations.size(), 1u);
  EXPECT_NEAR(read.rotations[0].angles.roll, 3 / kDegreesPerRadian, 1e-12);
  ASSERT_TRUE(read.rotations[0].sigma);
  EXPECT_NEAR(read.rotations[0].sigma->yaw, 0.1 / kDegreesPerRadian, 1e-12);
}

TEST_F(ResultFolderTest, SaysWhatATableLacks) {
  RunWriter writer({folder_});
  writer.WriteText("summary.json", SummaryJson({}));
  writer.WriteText("trajectory.csv", "frame,time\n0,0\n");
  EXPECT_NE(Refusal().find("trajectory.csv: has no column 'state'"), std::string::npos) << Refusal();
  const std::string heading = FrameTableHeader();
  writer.WriteText("trajectory.csv", heading + "0,0,tracked,1,2,3,0,0,0,0,held,0.01,20,30,1,,,0\n");
  EXPECT_NE(Refusal().find("trajectory.csv:2: quaternion has norm 0, not 1; expected 'qx,qy,qz,qw'"), std::string::npos)
      << Refusal();
  writer.WriteText("trajectory.csv", heading);
  writer.WriteText("camera_rotation.csv", "frame,time,yaw_deg\n0,0,1\n");
  EXPECT_NE(Refusal().find("camera_rotation.csv: has no column 'pitch_deg'"), std::string::npos) << Refusal();
}

TEST_F(ResultFolderTest, SaysWhatIsNoResult) {
  EXPECT_NE(Refusal().find("is not a folder with results of a run"), std::string::npos);
  fs::create_directories(folder_);
  EXPECT_NE(Refusal().find("summary.json: no such file; give the --out folder"), std::string::npos);
  std::ofstream(folder_ / "summary.json") << "{}";
  EXPECT_NE(Refusal().find("trajectory.csv: no such file"), std::string::npos);
  std::ofstream(folder_ / "trajectory.csv") << "frame,time\n";
  for (const char* text : {"{}", "no JSON", "[1, 2]", R"({"camera_yaw_pitch_roll_deg": [1, "2", 3]})"}) {
    std::ofstream(folder_ / "summary.json") << text;
    EXPECT_NE(Refusal().find("summary.json: is not a summary of a run"), std::string::npos) << text;
  }
  std::ofstream(folder_ / "summary.json") << R"({"camera_yaw_pitch_roll_deg": [1, 2, 3]})";
  EXPECT_EQ(Refusal(), "");
  fs::create_directory(folder_ / "turns.csv");
  EXPECT_NE(Refusal().find("turns.csv: cannot be read"), std::string::npos);
}

}  // namespace
}  // namespace turnscale

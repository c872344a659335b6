// SPDX-License-Identifier: MIT
#include "turnscale/simulation/drive_recorder.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/features/corners.h"
#include "turnscale/features/optical_flow.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/frames/frame_reader.h"
#include "turnscale/frames/video_file.h"
#include "turnscale/frames/video_writer.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/floor_plan_file.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/run/settings.h"
#include "turnscale/simulation/burnt_clock.h"
#include "turnscale/simulation/captured_frames.h"
#include "turnscale/simulation/drive.h"
#include "turnscale/simulation/test_world.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

Rig SmallRig(int width = 320, int height = 240) {
  Rig rig = MakeRig(RigPreset::kPaper);
  rig.camera.width = width;
  rig.camera.height = height;
  rig.camera.pinhole = {0.6 * width, 0.6 * width, (width - 1) / 2.0, (height - 1) / 2.0};
  rig.mount.yaw_deg = 5;
  rig.mount.pitch_deg = -2;
  rig.mount.lateral_offset = 0.3;
  return rig;
}

// Columns of numbers by name.
std::vector<double> Column(const fs::path& table, const std::string& name) {
  std::ifstream stream(table);
  std::string line;
  std::getline(stream, line);
  std::istringstream header(line);
  int wanted = 0;
  for (std::string cell; std::getline(header, cell, ',') && cell != name;) ++wanted;
  std::vector<double> values;
  while (std::getline(stream, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (int i = 0; i <= wanted; ++i) std::getline(cells, cell, ',');
    values.push_back(std::stod(cell));
  }
  return values;
}

bool GoOn(int /*done*/, int /*frames*/) { return true; }

class DriveRecorderTest : public ::testing::Test {
 protected:
  DriveRecorderTest() : folder_(ScratchPath("drive")) { fs::remove_all(folder_); }
  ~DriveRecorderTest() override { fs::remove_all(folder_); }

  Recording Record(const Rig& rig, int frames, int threads = 2) const {
    return RecordDrive(MakeTestWorld(1), rig, 3, {folder_, frames, threads}, GoOn);
  }
  cv::Mat Image(int frame) const { return ReadGrayImage(FindDrive(folder_).images.at(frame)).gray; }

  fs::path folder_;
};

// Centre of the glowing board that is expected near a pixel.
Eigen::Vector2d CentreOfLight(const cv::Mat& image, const Eigen::Vector2d& near) {
  constexpr int kReach = 6;
  constexpr int kDark = 20;
  double sum = 0;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  const Eigen::Vector2i first = near.array().round().cast<int>() - kReach;
  for (int y = first.y(); y <= first.y() + 2 * kReach; ++y) {
    for (int x = first.x(); x <= first.x() + 2 * kReach; ++x) {
      const double weight = std::max(0, image.at<uchar>(y, x) - kDark);
      sum += weight;
      centre += weight * Eigen::Vector2d(x, y);
    }
  }
  return centre / sum;
}

TEST_F(DriveRecorderTest, ImagesShowTheWorldOfTheirOwnPoseAndTime) {
  constexpr int kFrames = 8;
  // Before, the car hardly turns.
  constexpr int kFirst = 4;
  Rig rig = SmallRig(640, 480);
  // So dark that the boards do not saturate and everything else is black.
  rig.sensor.min_gain = rig.sensor.max_gain = 0.9 / kTestGlow;
  rig.sensor.vignetting = 0;
  rig.sensor.response = 1;
  Record(rig, kFrames);
  const CameraModel camera = ReadCameraFile(folder_ / "camera.yaml");
  const Trajectory poses = ReadTrajectory(folder_ / "poses.txt", ReadFrameTimes(folder_ / "times.txt").times);
  ASSERT_EQ(poses.size(), kFrames);
  const RigidTransform first_from_world = CameraDrive(MakeTestWorld(1), rig, 3).At(0).world_from_camera.inverse();
  const auto pixel = [&](int pose, const Eigen::Vector3d& x_in_world) {
    return camera.Project(poses[pose].world_from_camera.inverse() * (first_from_world * x_in_world)).value();
  };
  for (int i = kFirst; i < kFrames; ++i) {
    const cv::Mat image = Image(i);
    for (const bool moving : {false, true}) {
      const auto place = [&](int frame) -> Eigen::Vector3d {
        return moving ? TestCar(poses[frame].time) * kTestCarBoard : kTestBoard;
      };
      const Eigen::Vector2d expected = pixel(i, place(i));
      EXPECT_LT((CentreOfLight(image, expected) - expected).norm(), 0.1) << "frame " << i << " moving " << moving;
      // A lag of one frame, of the poses or of the world, would show.
      for (const int other : {i - 1, i + 1}) {
        if (other == kFrames) continue;
        EXPECT_GT((pixel(other, place(i)) - expected).norm(), 3);
        if (moving) {
          EXPECT_GT((pixel(i, place(other)) - expected).norm(), 3);
        }
      }
    }
  }
}

TEST_F(DriveRecorderTest, TrackedCornersKeepToTheEpipolarLinesOfTheTrueMotion) {
  constexpr int kFrames = 6;
  const Rig rig = SmallRig(640, 480);
  Record(rig, kFrames);
  const Trajectory poses = ReadTrajectory(folder_ / "poses.txt");
  const Pinhole& pinhole = rig.camera.pinhole;
  const FlowOptions flow;
  std::vector<double> errors;
  FlowImage last = BuildFlowImage(flow, Image(0));
  for (int i = 1; i < kFrames; ++i) {
    const FlowImage next = BuildFlowImage(flow, Image(i));
    const std::vector<cv::Point2f> corners = DetectCorners({}, last.gray, {});
    FlowResult tracked = TrackPoints(flow, last, next, corners, corners);
    CheckReturn(flow, last, next, corners, tracked);
    const RigidTransform next_from_last = poses[i].world_from_camera.inverse() * poses[i - 1].world_from_camera;
    for (size_t k = 0; k < corners.size(); ++k) {
      if (tracked.found[k] == 0) continue;
      const Eigen::Vector3d ray = next_from_last.rotation * pinhole.Ray({corners[k].x, corners[k].y});
      const Eigen::Vector3d normal = next_from_last.translation.cross(ray);
      const Eigen::Vector3d seen = pinhole.Ray({tracked.points[k].x, tracked.points[k].y});
      errors.push_back(std::abs(normal.dot(seen)) * pinhole.fx / normal.head<2>().norm());
    }
    last = next;
  }
  ASSERT_GT(errors.size(), 1500u);
  std::nth_element(errors.begin(), errors.begin() + errors.size() / 2, errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.15);
}

TEST_F(DriveRecorderTest, FolderHoldsTheWholeDrive) {
  Rig rig = SmallRig(64, 48);
  const Recording recording = RecordDrive(MakeTestWorld(1), rig, 3, {folder_, {}, 2}, GoOn);
  EXPECT_TRUE(recording.complete);
  EXPECT_GE(recording.frames, 10);
  EXPECT_NEAR(recording.metres, 5 * recording.seconds, 0.3 * recording.seconds);
  const DriveInput drive = FindDrive(folder_);
  EXPECT_EQ(static_cast<int>(drive.images.size()), recording.frames);
  EXPECT_EQ(drive.images[0].filename(), "000000.png");
  EXPECT_EQ(drive.camera_file, folder_ / "calib.txt");
  EXPECT_EQ(ReadCameraFile(folder_ / "calib.txt").pinhole.fx, rig.camera.pinhole.fx);
  EXPECT_EQ(ReadCameraFile(folder_ / "camera.yaml").width, 64);
  EXPECT_EQ(RigText(ReadRig(folder_ / "rig.yaml")), RigText(rig));
  EXPECT_LT(
      ReadCameraRotation((folder_ / "vehicle.yaml").string()).angularDistance(rig.mount.VehicleFromCamera().rotation),
      1e-12);
  EXPECT_NE(TextOf(folder_ / "vehicle.yaml").find("lever_arm: 1.5 "), std::string::npos);
  const std::vector<double> times = ReadFrameTimes(folder_ / "times.txt").times;
  ASSERT_EQ(static_cast<int>(times.size()), recording.frames);
  for (int i = 0; i < recording.frames; ++i) EXPECT_EQ(times[i], i / 10.0);

  const Trajectory poses = ReadTrajectory(folder_ / "poses.txt");
  EXPECT_EQ(poses[0].world_from_camera.translation, Eigen::Vector3d::Zero());
  const std::vector<double> steps = Column(folder_ / "truth.csv", "camera_step_m");
  const std::vector<double> heading = Column(folder_ / "truth.csv", "heading_deg");
  const std::vector<double> yaw_rate = Column(folder_ / "truth.csv", "yaw_rate_degps");
  ASSERT_EQ(static_cast<int>(steps.size()), recording.frames);
  EXPECT_NEAR(heading[0], -rig.mount.yaw_deg, 0.1) << "the camera looks to the right of the car";
  for (int i = 1; i < recording.frames; ++i) {
    EXPECT_NEAR(steps[i], (poses[i].world_from_camera.translation - poses[i - 1].world_from_camera.translation).norm(),
                1e-6);
    EXPECT_NEAR(heading[i] - heading[i - 1], 0.05 * (yaw_rate[i] + yaw_rate[i - 1]), 0.2);
  }
  const FloorPlan plan = ReadFloorPlan(folder_ / "floor_plan.csv");
  const World world = MakeTestWorld(1);
  ASSERT_EQ(plan.size(), world.floor_plan.size());
  EXPECT_NEAR((plan[0][1] - plan[0][0]).norm(), 3, 0.02);
}

TEST_F(DriveRecorderTest, SameBitsOnAnyNumberOfThreadsAndAnotherDriveWithAnotherSeed) {
  const Rig rig = SmallRig(96, 64);
  Record(rig, 3, 1);
  std::string one;
  for (const char* name : {"image_0/000000.png", "image_0/000002.png", "poses.txt", "truth.csv"}) {
    one += TextOf(folder_ / name);
  }
  Record(rig, 3, 3);
  std::string three;
  for (const char* name : {"image_0/000000.png", "image_0/000002.png", "poses.txt", "truth.csv"}) {
    three += TextOf(folder_ / name);
  }
  EXPECT_EQ(one == three, true);
  const std::string image = TextOf(folder_ / "image_0/000000.png");
  RecordDrive(MakeTestWorld(1), rig, 4, {folder_, 1, 2}, GoOn);
  EXPECT_EQ(image == TextOf(folder_ / "image_0/000000.png"), false);
}

TEST_F(DriveRecorderTest, DistortedLensHasNoCalibTxt) {
  Rig rig = SmallRig(64, 48);
  Record(rig, 1);
  rig.camera.lens = LensModel::kRadialTangential;
  rig.camera.distortion = {-0.1, 0.01, 0, 0, 0};
  Record(rig, 1);
  EXPECT_FALSE(fs::exists(folder_ / "calib.txt"));
  EXPECT_EQ(FindDrive(folder_).camera_file, folder_ / "camera.yaml");
  EXPECT_EQ(ReadCameraFile(folder_ / "camera.yaml").distortion, rig.camera.distortion);
}

TEST_F(DriveRecorderTest, VideoHoldsTheImagesAndTheirStamps) {
  Rig rig = SmallRig(128, 96);
  rig.windscreen.dashboard = 0.2;
  Record(rig, 6);
  std::vector<cv::Mat> images;
  for (int i = 0; i < 6; ++i) images.push_back(Image(i));
  rig.recorder.video = true;
  Record(rig, 6);
  EXPECT_FALSE(fs::exists(folder_ / "image_0")) << "of the earlier drive";
  const DriveInput drive = FindDrive(folder_);
  ASSERT_EQ(drive.videos, std::vector<fs::path>{folder_ / "video.mp4"});
  EXPECT_EQ(drive.camera_file, folder_ / "calib.txt");
  VideoFile video(drive.videos[0]);
  for (int i = 0; i < 6; ++i) {
    ASSERT_TRUE(video.Advance()) << i;
    EXPECT_NEAR(video.Stamp().value_or(-1), i / 10.0, 1e-9);
    EXPECT_LT(cv::norm(video.Gray(), images[i], cv::NORM_L1) / static_cast<double>(images[i].total()), 2.5) << i;
  }
  EXPECT_FALSE(video.Advance());
  // And back.
  rig.recorder.video = false;
  Record(rig, 2);
  EXPECT_FALSE(fs::exists(folder_ / "video.mp4"));
  EXPECT_EQ(FindDrive(folder_).images.size(), 2u);
}

TEST_F(DriveRecorderTest, LostFramesAreMissingFromAllFiles) {
  Rig rig = SmallRig(64, 48);
  rig.recorder = {.video = true, .stalls_per_minute = 200, .stalled_frames = 2, .stamp_jitter_ms = 4};
  const Recording recording = RecordDrive(MakeTestWorld(3), rig, 3, {folder_, {}, 2}, GoOn);
  const std::vector<CapturedFrame> captured = CapturedFrames(rig.recorder, 31, rig.rate_hz, 3);
  ASSERT_LT(captured.size(), 30u);
  ASSERT_GE(recording.frames, static_cast<int>(captured.size()));
  const std::vector<double> times = ReadFrameTimes(folder_ / "times.txt").times;
  const std::vector<FrameStamp> stamps = VideoFile::ReadStamps(folder_ / "video.mp4");
  ASSERT_EQ(static_cast<int>(times.size()), recording.frames);
  ASSERT_EQ(static_cast<int>(stamps.size()), recording.frames);
  EXPECT_EQ(static_cast<int>(ReadTrajectory(folder_ / "poses.txt").size()), recording.frames);
  const CameraDrive drive(MakeTestWorld(3), rig, 3);
  const std::vector<double> steps = Column(folder_ / "truth.csv", "camera_step_m");
  for (size_t i = 0; i < captured.size(); ++i) {
    EXPECT_EQ(times[i], captured[i].number / rig.rate_hz);
    EXPECT_NEAR(stamps[i].seconds, captured[i].stamp, 0.51 / kVideoTicksPerSecond);
    if (i == 0) continue;
    const auto place = [&](size_t k) { return drive.At(captured[k].number).world_from_camera.translation; };
    EXPECT_NEAR(steps[i], (place(i) - place(i - 1)).norm(), 1e-6);
  }
}

TEST_F(DriveRecorderTest, ClockShowsTheStampsTime) {
  Rig rig = SmallRig(480, 270);
  Record(rig, 11);
  const cv::Mat first = Image(0);
  const cv::Mat last = Image(10);
  rig.recorder.clock = true;
  Record(rig, 11);
  for (const auto& [frame, plain] : {std::pair(0, first), std::pair(10, last)}) {
    cv::Mat expected = plain.clone();
    BurnClock(0.1 * frame, expected);
    EXPECT_EQ(cv::norm(Image(frame), expected, cv::NORM_INF), 0) << frame;
  }
}

TEST_F(DriveRecorderTest, InterruptedDriveIsToldByItsMissingTimes) {
  const Rig rig = SmallRig(64, 48);
  Record(rig, 5);
  const std::string parts[] = {"image_0/000007.png.part", "poses.txt.part"};
  for (const std::string& part : parts) std::ofstream(folder_ / part) << "of a recording that was killed";
  const Recording recording =
      RecordDrive(MakeTestWorld(1), rig, 3, {folder_, 5, 2}, [](int done, int /*frames*/) { return done < 2; });
  for (const std::string& part : parts) EXPECT_FALSE(fs::exists(folder_ / part)) << part;
  EXPECT_FALSE(recording.complete);
  EXPECT_EQ(recording.frames, 2);
  EXPECT_THROW(FindDrive(folder_), InputError) << "a run of half a drive would pass for one of the whole";
  EXPECT_EQ(FindDrive(folder_ / "image_0").images.size(), 2u) << "nothing of the earlier drive is left";
  EXPECT_FALSE(fs::exists(folder_ / "times.txt"));
  EXPECT_FALSE(fs::exists(folder_ / "poses.txt"));
}

TEST_F(DriveRecorderTest, DriveThatIsStoppedBeforeItsSceneIsLitHasNoImages) {
  int asked = 0;
  const Recording recording = RecordDrive(MakeTestWorld(1), SmallRig(64, 48), 3, {folder_, 5, 2}, [&](int done, int) {
    EXPECT_EQ(done, 0);
    ++asked;
    return false;
  });
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(recording.frames, 0);
  EXPECT_FALSE(recording.complete);
  EXPECT_TRUE(fs::is_empty(folder_ / "image_0"));
}

TEST_F(DriveRecorderTest, FilesOfAnotherOriginAreNotTouched) {
  for (const char* name : {"image_0/000000.png", "times.txt", "poses.txt", "truth.csv", "floor_plan.csv", "calib.txt",
                           "video.mp4", "camera.yaml", "vehicle.yaml", "rig.yaml", "drive.yaml"}) {
    fs::remove_all(folder_);
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << "dear";
    EXPECT_THROW(Record(SmallRig(64, 48), 1), InputError) << name;
    EXPECT_EQ(TextOf(folder_ / name), "dear");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << name;
  }
  fs::remove_all(folder_);
  std::ofstream(folder_) << "a file in the way";
  EXPECT_THROW(Record(SmallRig(64, 48), 1), InputError);
}

TEST_F(DriveRecorderTest, WhatStandsBesideADriveIsKept) {
  fs::create_directories(folder_ / "image_0");
  std::ofstream(folder_ / "notes.txt") << "dear";
  Record(SmallRig(64, 48), 2);
  std::ofstream(folder_ / "image_0" / "best.png") << "dear";
  Record(SmallRig(64, 48), 1);
  EXPECT_EQ(TextOf(folder_ / "notes.txt"), "dear");
  EXPECT_EQ(TextOf(folder_ / "image_0" / "best.png"), "dear");
  EXPECT_FALSE(fs::exists(folder_ / "image_0" / "000001.png"));
}

TEST_F(DriveRecorderTest, WhatCannotBeRecordedLeavesTheEarlierDrive) {
  Record(SmallRig(64, 48), 2);
  EXPECT_THROW(Record(SmallRig(64, 48), 1, 2000), InputError);
  Rig rig = SmallRig(64, 48);
  rig.vehicle.max_steering_deg = 5;
  RecordOptions options = {folder_, 1, 2};
  options.origin.follow = "path.tum";
  try {
    RecordDrive(MakeTestWorld(2), rig, 3, options, GoOn);
    ADD_FAILURE() << "the bend is too sharp for the car";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find("path.tum: legs: "), 0u) << error.what();
  }
  EXPECT_EQ(FindDrive(folder_).images.size(), 2u);
  EXPECT_TRUE(fs::exists(folder_ / "times.txt"));
}

}  // namespace
}  // namespace turnscale

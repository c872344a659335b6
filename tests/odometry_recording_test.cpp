// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include <gtest/gtest.h>

#include "odometry_run.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/frames/image_source.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

fs::path DataFolder() {
  const char* folder = std::getenv("TURNSCALE_DATA");
  return folder != nullptr ? fs::path(folder) : fs::path(TURNSCALE_SOURCE_FOLDER) / "../shared/data";
}

// A residential street of KITTI with one right turn, 60 frames. Lever arm and side slip are those of the car, found on
// other trajectories.
TEST(OdometryRecording, Kitti05ShowsItsTurnAndItsMetres) {
  const fs::path folder = DataFolder() / "kitti_05_f100-159";
  if (!fs::exists(folder / "calib.txt")) GTEST_SKIP() << "no drive in " << folder << " (TURNSCALE_DATA names another)";
  const DriveInput input = FindDrive(folder);
  std::vector<cv::Mat> images;
  std::vector<double> times;
  ImageSource source(input, {.timestamps = input.times_file});
  while (const std::optional<SourceFrame> frame = source.Next()) {
    images.push_back(frame->gray);
    times.push_back(frame->time);
  }
  std::vector<RigidTransform> truth;
  for (const StampedPose& pose : ReadTrajectory(folder / "poses.txt")) truth.push_back(pose.world_from_camera);
  ASSERT_EQ(images.size(), truth.size());

  OdometryOptions options;
  options.vehicle.lever_arm = 0.945;
  options.vehicle.side_slip = 0.0041;
  const OdometryRun run = RunOdometry(options, ReadCameraFile(folder / "calib.txt"), images, times);
  ASSERT_EQ(run.turns.size(), 1U);
  EXPECT_TRUE(run.turns[0].used) << run.turns[0].reason;
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), static_cast<int>(images.size()));
  ASSERT_TRUE(AllPosed(run.refined));
  const RunErrors errors = MeasureRun(run.refined, truth);
  EXPECT_LT(std::abs(errors.path_length), 0.046);
  EXPECT_LE(errors.psi_rms_deg, 0.06);
  EXPECT_LT(errors.shape, 0.2);
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "odometry_run.h"
#include "street_drive.h"
#include "turnscale/odometry/odometry.h"

namespace turnscale {
namespace {

// What a dashcam sees the street through: a textured dashboard over the lower rows, and a clock.
struct Dashboard {
  int first_row = 0;
  cv::Mat texture;

  explicit Dashboard(const cv::Size& size) : first_row(size.height * 3 / 4), texture(size, CV_8U) {
    cv::RNG random(5);
    random.fill(texture, cv::RNG::NORMAL, 90, 120);
    cv::GaussianBlur(texture, texture, {}, 1.5);
  }

  cv::Mat Before(const cv::Mat& scene, int frame) const {
    cv::Mat image = scene.clone();
    texture.rowRange(first_row, scene.rows).copyTo(image.rowRange(first_row, scene.rows));
    const std::string clock = std::to_string(10 + frame / 10) + " KM/H";
    cv::putText(image, clock, {290, 45}, cv::FONT_HERSHEY_SIMPLEX, 1.2, cv::Scalar(255), 3);
    return image;
  }
};

int LeftOut(const cv::Mat& mask, const cv::Rect& part) {
  return mask.empty() ? 0 : part.area() - cv::countNonZero(mask(part));
}

void ExpectDriveBehindDashboard(StreetDrive drive) {
  const Dashboard dashboard(drive.images.front().size());
  for (size_t i = 0; i < drive.images.size(); ++i)
    drive.images[i] = dashboard.Before(drive.images[i], static_cast<int>(i));
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ASSERT_TRUE(AllPosed(run.refined));
  const RunErrors errors = MeasureRun(run.refined, drive.world_from_camera);
  EXPECT_LT(std::abs(errors.path_length), 0.03);
  EXPECT_LT(errors.position, 0.9);
  EXPECT_EQ(Count(run.refined, TrackingState::kBridged), 0);

  const int width = drive.camera.width;
  const int border = OdometryOptions().corners.border;
  const cv::Rect covered(border, dashboard.first_row, width - 2 * border,
                         drive.camera.height - border - dashboard.first_row);
  EXPECT_GT(LeftOut(run.mask, covered), 0.5 * covered.area());
  const cv::Rect scene(0, 64, width, dashboard.first_row - 80);
  EXPECT_LT(LeftOut(run.mask, scene), 0.01 * scene.area());
}

TEST(OdometryMask, ADashboardIsLeftOut) { ExpectDriveBehindDashboard(PlainStreetDrive()); }

TEST(OdometryMask, ADashboardIsLeftOutThoughTheCarStandsFirst) {
  ExpectDriveBehindDashboard(RenderStreetDrive({.standing_at = 0, .standing_frames = 12}));
}

TEST(OdometryMask, ACarThatStandsBehindADashboardHasNeitherMapNorMask) {
  StreetDrive drive = RenderStreetDrive({.frames = 16, .standing_at = 0, .standing_frames = 15});
  const Dashboard dashboard(drive.images.front().size());
  for (cv::Mat& image : drive.images) image = dashboard.Before(image, 0);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  EXPECT_TRUE(run.map.keyframes.empty());
  EXPECT_TRUE(run.mask.empty());
}

TEST(OdometryMask, ASceneIsNotLeftOut) {
  const StreetDrive drive =
      RenderStreetDrive({.frames = 115, .standing_at = 72, .standing_frames = 15, .braking_frames = 8});
  EXPECT_TRUE(RunOdometry(StreetOptions(), drive).mask.empty());
}

TEST(OdometryMask, AGivenMaskIsUsedFromTheStart) {
  const StreetDrive drive = PlainStreetDrive(20);
  cv::Mat mask(drive.images.front().size(), CV_8U, cv::Scalar(1));
  mask.rowRange(140, mask.rows).setTo(0);
  Odometry odometry(StreetOptions(), drive.camera);
  odometry.SetMask(mask);
  for (size_t i = 0; i < drive.images.size(); ++i) odometry.Process(drive.images[i], drive.times[i]);
  ASSERT_GT(odometry.map().keyframes.size(), 3U);
  for (const Keyframe& keyframe : odometry.map().keyframes)
    for (const KeyframeObservation& seen : keyframe.observations) EXPECT_LT(seen.pixel.y(), 140);
  EXPECT_EQ(LeftOut(odometry.mask(), {0, 0, mask.cols, mask.rows}), (mask.rows - 140) * mask.cols);
}

}  // namespace
}  // namespace turnscale

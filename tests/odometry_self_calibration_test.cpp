// SPDX-License-Identifier: MIT
#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "odometry_run.h"
#include "street_drive.h"
#include "turnscale/odometry/self_calibration.h"

namespace turnscale {
namespace {

OpenDrive ImagesOf(const StreetDrive& drive) {
  return [&drive](std::optional<double> from) -> ImageStream {
    return [&drive, from, next = size_t{0}]() mutable -> std::optional<TimedImage> {
      while (from && next < drive.times.size() && drive.times[next] - drive.times.front() < *from) ++next;
      if (next == drive.images.size()) return std::nullopt;
      const size_t frame = next++;
      return TimedImage{drive.images[frame], drive.times[frame]};
    };
  };
}

std::optional<FoundCamera> Found(const StreetDrive& drive, double field_of_view_deg) {
  return CalibrateFromDrive(
      {}, StreetOptions(), {CameraOfView(field_of_view_deg, drive.camera.width, drive.camera.height)}, ImagesOf(drive));
}

TEST(OdometrySelfCalibration, FindsTheFocalLengthFromANarrowAndAWideStart) {
  const StreetDrive drive = PlainStreetDrive();
  for (const double start : {50.0, 105.0}) {
    const std::optional<FoundCamera> found = Found(drive, start);
    ASSERT_TRUE(found) << start;
    EXPECT_NEAR(found->camera.pinhole.fx / drive.camera.pinhole.fx, 1, 0.015) << start;
    EXPECT_NEAR(found->camera.pinhole.fx, drive.camera.pinhole.fx, 2 * found->camera.focal_sigma) << start;
    EXPECT_LT(found->camera.focal_sigma / found->camera.pinhole.fx, 0.02) << start;
    EXPECT_TRUE(found->converged) << start;
    EXPECT_NEAR(found->camera.pinhole.cx, drive.camera.pinhole.cx, 2 * found->centre_sigma) << start;
  }
}

TEST(OdometrySelfCalibration, StartsWithTheShapeOfThePixels) {
  EXPECT_EQ(CameraOfLongerView(90, 640, 360, 1.25), CameraOfView(90, 640, 360, 1.25));
  const CameraModel upright = CameraOfLongerView(90, 360, 640, 1.25);
  EXPECT_NEAR(upright.pinhole.fy, 320, 1e-9);
  EXPECT_NEAR(upright.pinhole.fx, 320 / 1.25, 1e-9);
  const CameraModel camera = CameraOfView(90, 640, 360, 1.25);
  EXPECT_NEAR(camera.pinhole.fx, 320, 1e-9);
  EXPECT_NEAR(camera.pinhole.fy, 400, 1e-9);
  EXPECT_EQ(camera.pinhole.cx, 319.5);
}

TEST(OdometrySelfCalibration, DoesNotDependOnWhenTheClockStarted) {
  StreetDrive drive = PlainStreetDrive();
  const std::optional<FoundCamera> at_zero = Found(drive, 70);
  // A power of two, so that the intervals keep their bits.
  for (double& time : drive.times) time += 128;
  const std::optional<FoundCamera> later = Found(drive, 70);
  ASSERT_TRUE(at_zero && later);
  EXPECT_NEAR(later->camera.pinhole.fx / at_zero->camera.pinhole.fx, 1, 1e-3);
  EXPECT_EQ(later->windows, at_zero->windows);
}

TEST(OdometrySelfCalibration, FindsADistortionToo) {
  const StreetDrive drive = RenderStreetDrive({.k1 = -0.12});
  const std::optional<FoundCamera> found = Found(drive, 70);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->camera.pinhole.fx / drive.camera.pinhole.fx, 1, 0.03);
  // At the middle of the left and right edges, where a pinhole with the right focal length is 3 degrees off.
  for (const double x : {0.0, drive.camera.width - 1.0}) {
    const Eigen::Vector2d pixel(x, drive.camera.pinhole.cy);
    const double angle = std::atan(found->camera.pinhole.Ray(*found->camera.Undistort(pixel)).x());
    const double truth = std::atan(drive.camera.pinhole.Ray(*drive.camera.Undistort(pixel)).x());
    EXPECT_NEAR(angle, truth, 0.02);
  }
}

TEST(OdometrySelfCalibration, TheSecondReadingBeginsWithTheDriveToo) {
  // The first one, with a camera that may be far off, can miss an early turn.
  const StreetDrive drive = PlainStreetDrive(kStreetFirstTurn + kStreetTurnFrames);
  const OpenDrive images = ImagesOf(drive);
  std::vector<std::optional<double>> begins;
  const OpenDrive noted = [&](std::optional<double> from) {
    begins.push_back(from);
    return images(from);
  };
  ASSERT_TRUE(
      CalibrateFromDrive({}, StreetOptions(), {CameraOfView(70, drive.camera.width, drive.camera.height)}, noted));
  ASSERT_GT(begins.size(), 1U);
  EXPECT_FALSE(begins[0]);
  EXPECT_FALSE(begins[1]);
}

TEST(OdometrySelfCalibration, LaterReadingsEndAfterTheTurns) {
  // The car stands still for twenty seconds after its only turn.
  StreetDrive drive = PlainStreetDrive(kStreetFirstTurn + kStreetTurnFrames + 5);
  for (int frame = 0; frame < 200; ++frame) {
    drive.images.push_back(drive.images.back());
    drive.times.push_back(drive.times.back() + kStreetInterval);
  }
  const OpenDrive images = ImagesOf(drive);
  std::vector<double> ends;
  const OpenDrive noted = [&](std::optional<double> from) -> ImageStream {
    ends.push_back(0);
    return [&ends, stream = images(from)] {
      const std::optional<TimedImage> image = stream();
      if (image) ends.back() = image->time;
      return image;
    };
  };
  ASSERT_TRUE(
      CalibrateFromDrive({}, StreetOptions(), {CameraOfView(70, drive.camera.width, drive.camera.height)}, noted));
  ASSERT_GT(ends.size(), 2U);
  EXPECT_EQ(ends[1], drive.times.back());
  for (size_t pass = 2; pass < ends.size(); ++pass) {
    EXPECT_GT(ends[pass], drive.times[kStreetFirstTurn + kStreetTurnFrames]) << pass;
    EXPECT_LT(ends[pass], drive.times.back() - 5) << pass;
  }
}

TEST(OdometrySelfCalibration, AStraightDoesNotTell) {
  const StreetDrive drive = PlainStreetDrive(kStreetFirstTurn);
  EXPECT_FALSE(Found(drive, 70));
}

TEST(OdometrySelfCalibration, ABendDoesNotReplaceACalibration) {
  // Fifteen degrees into the turn, which with half the focal length would look like thirty.
  const StreetDrive drive = PlainStreetDrive(kStreetFirstTurn + kStreetTurnFrames / 6);
  EXPECT_FALSE(CalibrateFromDrive({}, StreetOptions(), {drive.camera, false}, ImagesOf(drive)));
  EXPECT_FALSE(Found(drive, 110));
}

}  // namespace
}  // namespace turnscale

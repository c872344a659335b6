// SPDX-License-Identifier: MIT
#include "turnscale/odometry/feature_tracks.h"

#include <cmath>
#include <memory>
#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "turnscale/features/synthetic_texture.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

CameraModel Distorted() {
  CameraModel camera;
  camera.pinhole = {420, 430, 318, 162};
  camera.lens = LensModel::kRadialTangential;
  camera.distortion = {-0.15, 0.03, 0.001, -0.0005, 0};
  camera.width = 640;
  camera.height = 320;
  return camera;
}

CameraModel Undistorted() {
  CameraModel camera = Distorted();
  camera.lens = LensModel::kPinhole;
  camera.distortion = {};
  return camera;
}

const RigidTransform kReference{RotationFromVector({0.03, -0.2, 0.01}), {0.4, 0.1, -0.5}};
const RigidTransform kCurrent = RigidTransform{RotationFromVector({-0.01, 0.07, 0.05}), {0.2, -0.1, -1.6}} * kReference;

// One keyframe at kReference.
Map OneKeyframe(const CameraModel& camera) {
  Map map;
  map.camera = camera;
  map.keyframes.push_back({0, 0, kReference, {}, false});
  return map;
}

// A track of a new landmark that the reference keyframe sees at this pixel, as the image came.
FeatureTrack AddTrack(const CameraModel& camera, const Eigen::Vector2d& pixel, double depth, bool valid, Map& map) {
  const Eigen::Vector2d undistorted = camera.Undistort(pixel).value();
  const int landmark = static_cast<int>(map.landmarks.size());
  map.landmarks.push_back({kReference.inverse() * (depth * camera.pinhole.Ray(undistorted)).eval(), valid, {}});
  AddObservation(map, 0, landmark, undistorted);
  FeatureTrack track;
  track.landmark = landmark;
  track.pixel = {static_cast<float>(pixel.x()), static_cast<float>(pixel.y())};
  track.undistorted = undistorted;
  track.reference_pixel = track.pixel;
  return track;
}

TEST(FeatureTracks, CurrentFromReferenceIsHowPixelsMove) {
  const CameraModel camera = Distorted();
  Map map = OneKeyframe(camera);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> x(80, 560);
  std::uniform_real_distribution<double> y(60, 260);
  std::uniform_real_distribution<double> depth(5, 30);
  for (int i = 0; i < 50; ++i) {
    const double row = y(random);
    const Eigen::Vector2d pixel(x(random), row);
    const double z = depth(random);
    const FeatureTrack track = AddTrack(camera, pixel, z, true, map);
    // A pixel beside it in the reference, put on the plane that faces the reference, seen by the current camera.
    const auto moved = [&](const Eigen::Vector2d& reference) -> Eigen::Vector2d {
      const Eigen::Vector3d in_reference = z * camera.pinhole.Ray(camera.Undistort(reference).value());
      return camera.Project(kCurrent * (kReference.inverse() * in_reference)).value();
    };
    constexpr double kOffset = 0.5;
    Eigen::Matrix2d expected;
    for (const int axis : {0, 1}) {
      const Eigen::Vector2d offset = kOffset * Eigen::Vector2d::Unit(axis);
      expected.col(axis) = (moved(pixel + offset) - moved(pixel - offset)) / (2 * kOffset);
    }
    const auto actual = CurrentFromReference(map, track, kCurrent);
    ASSERT_TRUE(actual);
    EXPECT_LT((*actual - expected).norm(), 0.01) << pixel.transpose();
    EXPECT_GT((*actual - Eigen::Matrix2d::Identity()).norm(), 0.05);
  }
}

TEST(FeatureTracks, WhatACameraCanNotSeeHasNoCurrentFromReference) {
  const CameraModel camera = Distorted();
  Map map = OneKeyframe(camera);
  const FeatureTrack track = AddTrack(camera, {320, 160}, 10, true, map);
  const RigidTransform passed = RigidTransform{Eigen::Quaterniond::Identity(), {0, 0, -11}} * kReference;
  EXPECT_TRUE(CurrentFromReference(map, track, kReference));
  EXPECT_FALSE(CurrentFromReference(map, track, passed));
  EXPECT_FALSE(PixelOf(map, track.landmark, passed));
}

TEST(FeatureTracks, PredictionsProjectDepthsAndTurnTheRest) {
  const CameraModel camera = Distorted();
  Map map = OneKeyframe(camera);
  const std::vector<FeatureTrack> tracks = {AddTrack(camera, {200, 120}, 12, true, map),
                                            AddTrack(camera, {420, 220}, 12, false, map),
                                            AddTrack(camera, {300, 160}, 1, true, map)};
  const std::vector<cv::Point2f> guesses = PredictPixels(map, tracks, kReference, kCurrent);
  ASSERT_EQ(guesses.size(), 3U);
  const Eigen::Vector2d projected = camera.Project(kCurrent * map.landmarks[0].position).value();
  EXPECT_NEAR(guesses[0].x, projected.x(), 1e-3);
  EXPECT_NEAR(guesses[0].y, projected.y(), 1e-3);
  const Eigen::Matrix3d turn = (kCurrent * kReference.inverse()).rotation.toRotationMatrix();
  const Eigen::Vector2d turned = camera.Project(turn * camera.pinhole.Ray(tracks[1].undistorted)).value();
  EXPECT_NEAR(guesses[1].x, turned.x(), 1e-3);
  EXPECT_NEAR(guesses[1].y, turned.y(), 1e-3);
  EXPECT_EQ(guesses[2], tracks[2].pixel) << "the camera has passed it";
}

TEST(FeatureTracks, PixelOfEndsAtTheImageBorder) {
  const CameraModel camera = Undistorted();
  Map map = OneKeyframe(camera);
  const auto seen = [&](double x, double y) {
    const FeatureTrack track = AddTrack(camera, {x, y}, 10, true, map);
    return PixelOf(map, track.landmark, kReference);
  };
  ASSERT_TRUE(seen(0.5, 0.5));
  EXPECT_NEAR(seen(0.5, 318.5)->y, 318.5, 1e-3);
  EXPECT_TRUE(seen(638.5, 100));
  EXPECT_FALSE(seen(-0.5, 100));
  EXPECT_FALSE(seen(100, -0.5));
  EXPECT_FALSE(seen(639.5, 100));
  EXPECT_FALSE(seen(100, 319.5));
}

// A wall that faces the reference camera, as a camera sees it.
constexpr double kWall = 8;

cv::Mat ImageOfWall(const SyntheticTexture& texture, const CameraModel& camera, const RigidTransform& from_world) {
  const RigidTransform reference_from_camera = kReference * from_world.inverse();
  return MakeImage({camera.width, camera.height}, [&](const Eigen::Vector2d& pixel) {
    const Eigen::Vector3d ray = reference_from_camera.rotation * camera.pinhole.Ray(pixel);
    const double distance = (kWall - reference_from_camera.translation.z()) / ray.z();
    return texture.At(camera.pinhole.Project(reference_from_camera.translation + distance * ray));
  });
}

TEST(FeatureTracks, AlignmentFindsTheReferenceViewAgain) {
  const CameraModel camera = Undistorted();
  Map map = OneKeyframe(camera);
  const SyntheticTexture texture(2);
  const cv::Mat reference = ImageOfWall(texture, camera, kReference);
  const FlowImage current{.gray = ImageOfWall(texture, camera, kCurrent), .pyramid = {}};
  int found = 0;
  int tried = 0;
  for (double y = 60; y <= 260; y += 25)
    for (double x = 200; x <= 440; x += 25) {
      FeatureTrack track = AddTrack(camera, {x, y}, kWall, true, map);
      track.reference_image = std::make_shared<const cv::Mat>(reference);
      const std::optional<cv::Point2f> truth = PixelOf(map, track.landmark, kCurrent);
      if (!truth) continue;
      ++tried;
      if (!AlignTrack({}, map, {current, kCurrent}, *truth + cv::Point2f(0.8F, -0.6F), track)) continue;
      ++found;
      EXPECT_LT(std::hypot(track.pixel.x - truth->x, track.pixel.y - truth->y), 0.1) << x << ' ' << y;
      EXPECT_NEAR(track.undistorted.x(), track.pixel.x, 1e-3);
    }
  EXPECT_GT(tried, 50);
  EXPECT_GT(found, 0.85 * tried);
}

TEST(FeatureTracks, WhatLooksDifferentIsLeftAsItWas) {
  const CameraModel camera = Undistorted();
  Map map = OneKeyframe(camera);
  FeatureTrack track = AddTrack(camera, {300, 150}, kWall, true, map);
  track.reference_image = std::make_shared<const cv::Mat>(ImageOfWall(SyntheticTexture(3), camera, kReference));
  const FlowImage flat{.gray = cv::Mat(camera.height, camera.width, CV_8U, cv::Scalar(90)), .pyramid = {}};
  const FeatureTrack before = track;
  EXPECT_FALSE(AlignTrack({}, map, {flat, kReference}, {301, 151}, track));
  EXPECT_EQ(track.pixel, before.pixel);
  EXPECT_EQ(track.undistorted, before.undistorted);
}

TEST(FeatureTracks, AligningManyIsAligningEach) {
  const CameraModel camera = Undistorted();
  Map map = OneKeyframe(camera);
  const FlowImage image{.gray = ImageOfWall(SyntheticTexture(3), camera, kReference), .pyramid = {}};
  std::vector<FeatureTrack> tracks;
  std::vector<std::optional<cv::Point2f>> guesses;
  for (float x = 100; x <= 500; x += 10) {
    tracks.push_back(AddTrack(camera, {x, 150}, kWall, true, map));
    tracks.back().reference_image = std::make_shared<const cv::Mat>(image.gray);
    guesses.emplace_back(cv::Point2f(x + 1, 150.5F));
  }
  guesses[3].reset();
  std::vector<FeatureTrack> one_by_one = tracks;
  const std::vector<uchar> aligned = AlignTracks({}, map, {image, kReference}, guesses, tracks);
  ASSERT_EQ(aligned.size(), tracks.size());
  EXPECT_EQ(aligned[3], 0);
  for (size_t i = 0; i < tracks.size(); ++i) {
    const bool same = guesses[i] && AlignTrack({}, map, {image, kReference}, *guesses[i], one_by_one[i]);
    EXPECT_EQ(aligned[i] != 0, same);
    EXPECT_EQ(tracks[i].pixel, one_by_one[i].pixel);
  }
}

TEST(FeatureTracks, FollowingSortsFoundAndLost) {
  const CameraModel camera = Undistorted();
  Map map = OneKeyframe(camera);
  const SyntheticTexture texture(4, 8, 100);
  const FlowImage first = BuildFlowImage({}, ImageOfWall(texture, camera, kReference));
  const RigidTransform moved = RigidTransform{Eigen::Quaterniond::Identity(), {0.05, 0, 0}} * kReference;
  const FlowImage second = BuildFlowImage({}, ImageOfWall(texture, camera, moved));
  const double shift = camera.pinhole.fx * 0.05 / kWall;
  std::vector<FeatureTrack> tracks;
  for (double x = 100; x <= 500; x += 50) tracks.push_back(AddTrack(camera, {x, 150}, kWall, x < 300, map));
  tracks.push_back(AddTrack(camera, {638.5, 150}, kWall, false, map));
  const std::vector<cv::Point2f> guesses = PixelsOf(tracks);
  const FollowedTracks followed = FollowTracks({}, map, first, second, tracks, guesses);
  ASSERT_EQ(followed.found.size(), 9U);
  ASSERT_EQ(followed.lost.size(), 1U);
  for (size_t i = 0; i < followed.found.size(); ++i) {
    EXPECT_EQ(followed.found[i].landmark, tracks[i].landmark);
    EXPECT_NEAR(followed.found[i].pixel.x - tracks[i].pixel.x, shift, 0.05);
    EXPECT_NEAR(followed.found[i].undistorted.x() - tracks[i].undistorted.x(), shift, 0.05);
  }
  EXPECT_EQ(followed.lost[0].landmark, tracks.back().landmark);
  EXPECT_EQ(followed.lost[0].pixel, tracks.back().pixel) << "left as it was";
}

// The camera moves sideways along the wall; a row of landmarks without a depth.
struct WallDrive {
  WallDrive() {
    for (double x = 100; x <= 500; x += 50) tracks.push_back(AddTrack(camera, {x, 150}, kWall, false, map));
  }

  FollowedTracks Follow(double from, double to, const std::vector<FeatureTrack>& before) const {
    return FollowWithoutDepth({}, map, {Image(from), CameraFromWorld(from)}, {Image(to), CameraFromWorld(to)}, before);
  }

  static RigidTransform CameraFromWorld(double metres) {
    return RigidTransform{Eigen::Quaterniond::Identity(), {metres, 0, 0}} * kReference;
  }
  FlowImage Image(double metres) const {
    return BuildFlowImage({}, ImageOfWall(texture, camera, CameraFromWorld(metres)));
  }

  CameraModel camera = Undistorted();
  Map map = OneKeyframe(camera);
  SyntheticTexture texture{4, 8, 100};
  std::vector<FeatureTrack> tracks;
  double pixels_per_metre = camera.pinhole.fx / kWall;
};

TEST(FeatureTracks, WithoutDepthTheLastParallaxLeadsToThePixel) {
  WallDrive drive;
  std::vector<FeatureTrack>& tracks = drive.tracks;
  FollowedTracks followed = drive.Follow(0, 0.1, tracks);
  ASSERT_EQ(followed.found.size(), tracks.size());
  for (const FeatureTrack& track : followed.found) {
    ASSERT_TRUE(track.parallax);
    EXPECT_NEAR(track.parallax->x(), drive.pixels_per_metre, 1);
    EXPECT_NEAR(track.parallax->y(), 0, 1);
  }
  // Farther than without a prediction.
  constexpr double kFar = 1.1;
  const std::vector<FeatureTrack> before = followed.found;
  followed = drive.Follow(0.1, 0.1 + kFar, before);
  EXPECT_GE(followed.found.size(), before.size() - 2);
  for (const FeatureTrack& track : followed.found) {
    const double start = tracks[track.landmark].pixel.x;
    EXPECT_NEAR(track.pixel.x - start, (0.1 + kFar) * drive.pixels_per_metre, 0.2);
  }
}

TEST(FeatureTracks, AParallaxMeasuredAtStandstillLeadsNowhere) {
  WallDrive drive;
  std::vector<FeatureTrack>& tracks = drive.tracks;
  for (FeatureTrack& track : tracks) {
    // A third of a pixel of noise over a millimetre.
    track.parallax = Eigen::Vector2d(-330, 330);
    track.parallax_base = 0.001;
  }
  constexpr double kMotion = 0.1;
  const FollowedTracks followed = drive.Follow(0, kMotion, tracks);
  ASSERT_EQ(followed.found.size(), tracks.size());
  for (const FeatureTrack& track : followed.found) {
    EXPECT_NEAR(track.pixel.x - tracks[track.landmark].pixel.x, kMotion * drive.pixels_per_metre, 0.2);
    EXPECT_NEAR(track.parallax_base, kMotion, 1e-9);
  }
}

}  // namespace
}  // namespace turnscale

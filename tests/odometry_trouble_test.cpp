// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "odometry_run.h"
#include "street_drive.h"
#include "turnscale/base/error.h"
#include "turnscale/geometry/angle.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/odometry.h"
#include "turnscale/run/drive_recorder.h"

namespace turnscale {
namespace {

// Spoils `count` images from `first` on.
template <typename Spoil>
void SpoilImages(StreetDrive& drive, int first, int count, const Spoil& spoil) {
  for (int i = first; i < first + count; ++i) drive.images[i] = spoil(drive.images[i]);
}

cv::Mat Nothing(const cv::Mat& /*image*/) { return {}; }
cv::Mat Black(const cv::Mat& image) { return cv::Mat::zeros(image.size(), image.type()); }
// As a recorder repeats an image: not to the same bytes.
cv::Mat CompressedAnew(const cv::Mat& image) {
  cv::RNG random(7);
  cv::Mat noise(image.size(), CV_16S);
  random.fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::Mat again;
  cv::add(image, noise, again, cv::noArray(), CV_8U);
  return again;
}
cv::Mat Blurred(const cv::Mat& image) {
  cv::Mat blurred;
  cv::GaussianBlur(image, blurred, {}, 25);
  return blurred;
}

void ExpectStates(const OdometryRun& run, int first, int count, TrackingState state) {
  for (int i = first; i < first + count; ++i) {
    EXPECT_EQ(run.live[i].state, state) << "frame " << i;
    EXPECT_EQ(run.refined[i].state, state) << "frame " << i;
    EXPECT_TRUE(run.live[i].world_from_camera) << "frame " << i;
  }
}

void ExpectGoodDrive(const OdometryRun& run, const StreetDrive& drive) {
  ASSERT_TRUE(AllPosed(run.refined));
  const RunErrors errors = MeasureRun(run.refined, drive.world_from_camera);
  EXPECT_LT(std::abs(errors.path_length), 0.022);
  EXPECT_LT(errors.position, 0.45);
}

Eigen::Vector3d PositionAt(const std::vector<FrameResult>& frames, int frame) {
  return frames.at(frame).world_from_camera.value().translation;
}

// The farthest that frames first..last are from the first of them.
double Drift(const std::vector<FrameResult>& frames, int first, int last) {
  double drift = 0;
  for (int i = first; i <= last; ++i)
    drift = std::max(drift, (PositionAt(frames, i) - PositionAt(frames, first)).norm());
  return drift;
}

// The same of the truth.
double DriftOf(const StreetDrive& drive, int first, int last) {
  double drift = 0;
  for (int i = first; i <= last; ++i)
    drift =
        std::max(drift, (drive.world_from_camera[i].translation - drive.world_from_camera[first].translation).norm());
  return drift;
}

int KeyframesIn(const std::vector<FrameResult>& frames, int first, int last) {
  return static_cast<int>(std::count_if(frames.begin() + first, frames.begin() + last + 1,
                                        [](const FrameResult& frame) { return frame.keyframe; }));
}

TEST(OdometryTrouble, UnreadableImagesAreBridged) {
  StreetDrive drive = PlainStreetDrive();
  SpoilImages(drive, 40, 1, Nothing);
  SpoilImages(drive, 72, 3, Nothing);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ExpectStates(run, 40, 1, TrackingState::kUnreadable);
  ExpectStates(run, 72, 3, TrackingState::kUnreadable);
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), kStreetFrames - 4);
  EXPECT_EQ(run.turns.size(), 2U);
  ExpectGoodDrive(run, drive);
}

// Images that look like nothing end the map after so long; without images, there is nothing to end it.
TEST(OdometryTrouble, ManyUnreadableImagesDoNotEndTheMap) {
  StreetDrive drive = PlainStreetDrive();
  SpoilImages(drive, 30, 6, Nothing);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ExpectStates(run, 30, 6, TrackingState::kUnreadable);
  ExpectStates(run, 36, 3, TrackingState::kTracked);
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), kStreetFrames - 6);
  ExpectGoodDrive(run, drive);
}

TEST(OdometryTrouble, BlurAndDarknessAreBridged) {
  StreetDrive drive = PlainStreetDrive();
  SpoilImages(drive, 18, 3, Black);
  SpoilImages(drive, 72, 3, Blurred);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ExpectStates(run, 18, 3, TrackingState::kBridged);
  ExpectStates(run, 72, 3, TrackingState::kBridged);
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), kStreetFrames - 6);
  EXPECT_EQ(run.turns.size(), 2U);
  ExpectGoodDrive(run, drive);
}

TEST(OdometryTrouble, DarknessWithinATurnIsBridged) {
  StreetDrive drive = PlainStreetDrive();
  SpoilImages(drive, 100, 3, Black);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ExpectStates(run, 100, 3, TrackingState::kBridged);
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), kStreetFrames - 3);
  ExpectGoodDrive(run, drive);
}

TEST(OdometryTrouble, TrackingRestartsAfterALongGap) {
  // Right after the first turn, before its end could be told: the gap closes it.
  constexpr int kFirst = 64;
  constexpr int kCount = 12;
  StreetDrive drive = PlainStreetDrive();
  SpoilImages(drive, kFirst, kCount, Black);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ExpectStates(run, kFirst, kCount, TrackingState::kBridged);
  const int after = kFirst + kCount + 6;
  EXPECT_TRUE(std::all_of(run.refined.begin() + after, run.refined.end(),
                          [](const FrameResult& frame) { return frame.state == TrackingState::kTracked; }));
  ASSERT_EQ(run.turns.size(), 2U);
  for (const TurnResult& turn : run.turns) EXPECT_TRUE(turn.used) << turn.reason;
  for (int i = kFirst; i < kStreetFrames; ++i) EXPECT_TRUE(run.live[i].world_from_camera) << "frame " << i;
  ASSERT_TRUE(AllPosed(run.refined));
  EXPECT_LT(std::abs(MeasureRun(run.refined, drive.world_from_camera).path_length), 0.01);
}

// The drive without `count` images from `first` on.
StreetDrive DriveWithGap(int first, int count) {
  StreetDrive drive = PlainStreetDrive();
  const auto take_out = [&](auto& list) { list.erase(list.begin() + first, list.begin() + first + count); };
  take_out(drive.images);
  take_out(drive.times);
  take_out(drive.world_from_camera);
  return drive;
}

TEST(OdometryTrouble, TheDirectionAfterAGapInATurnIsMeasured) {
  constexpr int kFirst = 30;
  const StreetDrive drive = DriveWithGap(kFirst, 20);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  const auto start = std::ranges::find_if(run.map.keyframes, &Keyframe::after_gap);
  ASSERT_NE(start, run.map.keyframes.end());
  EXPECT_TRUE(start->gap_turn_is_measured);
  ASSERT_TRUE(AllPosed(run.refined));
  const auto turn_between = [](const Eigen::Quaterniond& before, const Eigen::Quaterniond& after) {
    return Eigen::Quaterniond(before.conjugate() * after);
  };
  constexpr int kBefore = kFirst - 2;
  constexpr int kAfter = kFirst + 15;
  const Eigen::Quaterniond found =
      turn_between(run.refined[kBefore].world_from_camera->rotation, run.refined[kAfter].world_from_camera->rotation);
  const Eigen::Quaterniond truth =
      turn_between(drive.world_from_camera[kBefore].rotation, drive.world_from_camera[kAfter].rotation);
  EXPECT_GT(InDegrees(RotationAngle(truth)), 80);
  EXPECT_LT(InDegrees(RotationAngle(truth.conjugate() * found)), 1);
}

TEST(OdometryTrouble, AWallAloneDoesNotShowTheDirectionAfterAGap) {
  const OdometryRun run = RunOdometry(StreetOptions(), DriveWithGap(80, 26));
  const auto start = std::ranges::find_if(run.map.keyframes, &Keyframe::after_gap);
  ASSERT_NE(start, run.map.keyframes.end());
  EXPECT_FALSE(start->gap_turn_is_measured);
  EXPECT_GT(InDegrees(start->gap_turn_sigma), 15);
}

TEST(OdometryTrouble, ARestartHasThePixelsOfTheLensCorrectionLearnedUpToTheGap) {
  constexpr int kFirst = 36;
  constexpr int kCount = 12;
  StreetDrive drive = RenderStreetDrive({.frames = 60, .k1 = 0.01});
  SpoilImages(drive, kFirst, kCount, Black);
  drive.camera.lens = LensModel::kPinhole;
  drive.camera.distortion = {};
  Odometry odometry(StreetOptions(), drive.camera);
  int i = 0;
  for (; i < kFirst; ++i) odometry.Process(drive.images[i], drive.times[i]);
  const double before = odometry.camera().radial_correction;
  const size_t keyframes = odometry.map().keyframes.size();
  for (; i < static_cast<int>(drive.images.size()) && odometry.map().keyframes.size() == keyframes; ++i)
    odometry.Process(drive.images[i], drive.times[i]);
  ASSERT_EQ(odometry.map().keyframes.size(), keyframes + 2);
  ASSERT_TRUE(odometry.map().keyframes[keyframes].after_gap);
  EXPECT_NE(odometry.camera().radial_correction, before) << "the gap ends no work that changes it";
  const auto expect_pixel = [&](const LandmarkObservation& seen, const cv::Point2f& raw) {
    const std::optional<Eigen::Vector2d> pixel = odometry.camera().Undistort({raw.x, raw.y});
    ASSERT_TRUE(pixel);
    EXPECT_EQ(seen.pixel, *pixel);
  };
  for (const FeatureTrack& track : odometry.tracks()) {
    const Landmark& landmark = odometry.map().landmarks[track.landmark];
    ASSERT_EQ(landmark.observations.size(), 2U);
    expect_pixel(landmark.observations[0], track.reference_pixel);
    expect_pixel(landmark.observations[1], track.pixel);
  }
}

TEST(OdometryTrouble, ADriveThatStartsInTheDarkIsFollowedFromTheFirstLight) {
  constexpr int kDark = 8;
  StreetDrive drive = PlainStreetDrive(40);
  SpoilImages(drive, 0, kDark, Black);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  for (int i = 0; i < kDark; ++i) EXPECT_EQ(run.refined[i].state, TrackingState::kInitializing) << "frame " << i;
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), static_cast<int>(drive.times.size()) - kDark);
}

TEST(OdometryTrouble, StandingAtTheStartDoesNotDrift) {
  constexpr int kStanding = 20;
  const StreetDrive drive = RenderStreetDrive({.frames = 95, .standing_at = 0, .standing_frames = kStanding});
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ExpectGoodDrive(run, drive);
  for (int i = 0; i <= kStanding; ++i) EXPECT_EQ(run.live[i].state, TrackingState::kInitializing) << "frame " << i;
  EXPECT_LT(Drift(run.refined, 0, kStanding), 0.001);
  EXPECT_LE(KeyframesIn(run.refined, 0, kStanding), 1);
}

TEST(OdometryTrouble, StandingBetweenTurnsIsNoTrouble) {
  constexpr int kFirst = 72;
  constexpr int kLast = kFirst + 15;
  const StreetDrive drive =
      RenderStreetDrive({.frames = 115, .standing_at = kFirst, .standing_frames = 15, .braking_frames = 8});
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), static_cast<int>(drive.times.size()));
  ExpectGoodDrive(run, drive);
  EXPECT_LE(KeyframesIn(run.refined, kFirst + 1, kLast), 1);
}

TEST(OdometryTrouble, StandingBetweenTurnsDriftsByTheNoiseOfAnImage) {
  constexpr int kFirst = 72;
  constexpr int kLast = kFirst + 15;
  const std::vector<StreetDrive> drives = RenderStreetDrives(
      {.frames = 95, .standing_at = kFirst, .standing_frames = 15, .braking_frames = 8}, {42, 1, 2, 3, 4, 5, 6, 7});
  double live = 0;
  double refined = 0;
  for (const StreetDrive& drive : drives) {
    const OdometryRun run = RunOdometry(StreetOptions(), drive);
    live += std::pow(Drift(run.live, kFirst, kLast), 2);
    refined += std::pow(Drift(run.refined, kFirst, kLast), 2);
  }
  EXPECT_LT(std::sqrt(live / static_cast<double>(drives.size())), 0.002);
  EXPECT_LT(std::sqrt(refined / static_cast<double>(drives.size())), 0.002);
}

TEST(OdometryTrouble, ACameraThatIsKnockedInTheDriveGivesTheSameMetres) {
  StreetDrive drive = PlainStreetDrive();
  const Pinhole& pinhole = drive.camera.pinhole;
  const Eigen::Matrix3d k{{pinhole.fx, 0, pinhole.cx}, {0, pinhole.fy, pinhole.cy}, {0, 0, 1}};
  const Eigen::Quaterniond before_from_after = RotationFromYawPitchRoll({0.03, 0.01, 0.01});
  const Eigen::Matrix3d homography = k * before_from_after.conjugate().toRotationMatrix() * k.inverse();
  cv::Mat warp;
  cv::eigen2cv(homography, warp);
  constexpr int kKnock = kStreetFirstTurn + kStreetTurnFrames + 10;  // on the street between the turns
  SpoilImages(drive, kKnock, kStreetFrames - kKnock, [&](const cv::Mat& image) {
    cv::Mat turned;
    cv::warpPerspective(image, turned, warp, image.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    return turned;
  });
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ExpectGoodDrive(run, drive);
  ASSERT_EQ(run.turns.size(), 2U);
  for (const TurnResult& turn : run.turns) EXPECT_TRUE(turn.used) << turn.reason;
  ASSERT_EQ(run.mount_jumps.size(), 1U);
  EXPECT_EQ(run.mount_jumps[0].first_frame, kKnock);
  EXPECT_LT(InDegrees(run.mount_jumps[0].before_from_after.angularDistance(before_from_after)), 0.2);
}

TEST(OdometryTrouble, RepeatedImagesAreNoStandstill) {
  StreetDrive drive = PlainStreetDrive();
  // One at a time, two and three in a row, on straights, in both turns and before a turn.
  const std::vector<int> repeats = {14, 18, 20, 21, 30, 36, 40, 41, 52, 66, 70, 71, 72, 84, 92, 98, 99, 110, 116, 128};
  for (const int frame : repeats) drive.images[frame] = CompressedAnew(drive.images[frame - 1]);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  for (const int frame : repeats) {
    ExpectStates(run, frame, 1, TrackingState::kRepeated);
    EXPECT_FALSE(run.live[frame].keyframe);
    // The live pose goes on with the car, as the image does not.
    EXPECT_GT(Drift(run.live, frame - 1, frame), 0.5 * Drift(run.live, frame - 2, frame - 1)) << "frame " << frame;
  }
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), kStreetFrames - static_cast<int>(repeats.size()));
  ExpectGoodDrive(run, drive);
}

TEST(OdometryTrouble, APictureThatFreezesIsNoStandstill) {
  constexpr int kFrozen = kStreetFirstTurn + kStreetTurnFrames + 5;  // on the street between the turns
  // Up to a place that shows the same scene, and up to another one in the second turn.
  for (const int count : {15, 45}) {
    StreetDrive drive = PlainStreetDrive();
    for (int i = 0; i < count; ++i) drive.images[kFrozen + i] = drive.images[kFrozen - 1];
    const OdometryRun run = RunOdometry(StreetOptions(), drive);
    for (const int frame : {kFrozen + 3, kFrozen + count - 2})
      EXPECT_NE(run.refined[frame].state, TrackingState::kTracked) << count << ", frame " << frame;
    EXPECT_EQ(run.refined[kStreetFrames - 1].state, TrackingState::kTracked);
    const int last = kFrozen + count;
    EXPECT_GT(Drift(run.refined, kFrozen - 1, last), 0.8 * DriftOf(drive, kFrozen - 1, last));
    EXPECT_LT(Drift(run.refined, kFrozen - 1, last), 1.3 * DriftOf(drive, kFrozen - 1, last));
  }
}

TEST(OdometryTrouble, EachImageThreeTimesIsTheSameDrive) {
  const StreetDrive plain = PlainStreetDrive();
  StreetDrive drive = plain;
  drive.images.clear();
  drive.times.clear();
  for (int i = 0; i < kStreetFrames; ++i)
    for (int k = 0; k < 3; ++k) {
      drive.images.push_back(k == 0 ? plain.images[i] : CompressedAnew(plain.images[i]));
      drive.times.push_back(plain.times[i] + kStreetInterval * k / 3);
    }
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  EXPECT_EQ(Count(run.refined, TrackingState::kBridged), 0);
  // On straights the motion within a third of an interval is at times too small to tell a repeat from standing.
  EXPECT_GT(Count(run.refined, TrackingState::kRepeated), 1.4 * kStreetFrames);
  std::vector<FrameResult> whole;
  for (int i = 0; i < kStreetFrames; ++i) {
    whole.push_back(run.refined[3 * i]);
    EXPECT_EQ(whole.back().state, TrackingState::kTracked) << "image " << i;
  }
  OdometryRun thinned = run;
  thinned.refined = whole;
  ExpectGoodDrive(thinned, drive);
}

TEST(OdometryTrouble, ImagesOfTwoMomentsWidenTheScale) {
  const StreetDrive drive = PlainStreetDrive();
  const auto record = [&](const auto& image) {
    Odometry odometry(StreetOptions(), drive.camera);
    DriveRecorder recorder(odometry);
    for (size_t i = 0; i < drive.times.size(); ++i) {
      if (i == 40)
        recorder.ProcessUnreadable(drive.times[i], "cannot be read");
      else
        recorder.Process(image(i), drive.times[i]);
    }
    recorder.Finish();
    return recorder.Refined();
  };
  EXPECT_FALSE(record([&](size_t i) { return drive.images[i]; }).blending);
  const RefinedResults mixed = record([&](size_t i) {
    cv::Mat image;
    cv::addWeighted(drive.images[i], 0.5, drive.images[i == 0 ? 0 : i - 1], 0.5, 0, image);
    return image;
  });
  ASSERT_TRUE(mixed.blending);
  EXPECT_EQ(mixed.blending->period, 0);
  ASSERT_TRUE(mixed.scale.estimate);
  EXPECT_GE(mixed.scale.estimate->length_sigma, FrameBlending::kScaleSigma);
  EXPECT_TRUE(mixed.scale.estimate->is_doubtful);
}

TEST(OdometryTrouble, AnImageThatFreezesStandsAfterAWhile) {
  // As if the car stopped from 4 m/s at once, and after 1.5 s went on as fast.
  constexpr int kFirst = 72;
  constexpr int kLast = kFirst + 15;
  const StreetDrive drive = RenderStreetDrive({.frames = 110, .standing_at = kFirst, .standing_frames = 15});
  OdometryOptions options = StreetOptions();
  options.repeats.max_seconds = 0.5;
  const OdometryRun run = RunOdometry(options, drive);
  const int limit = static_cast<int>(std::ceil(options.repeats.max_seconds / kStreetInterval));
  ExpectStates(run, kFirst + 1, 3, TrackingState::kRepeated);
  ExpectStates(run, kFirst + 1 + limit, 15 - limit, TrackingState::kTracked);
  EXPECT_EQ(Count(run.refined, TrackingState::kBridged), 0) << "the speed from before finds the way on";
  EXPECT_LT(Drift(run.refined, kFirst, kLast), 0.006);
  ExpectGoodDrive(run, drive);
}

TEST(OdometryTrouble, AStandstillAsShortAsAFreezeKeepsItsPath) {
  constexpr int kFirst = 72;
  constexpr int kLast = kFirst + 15;
  const StreetDrive drive = RenderStreetDrive({.frames = 110, .standing_at = kFirst, .standing_frames = 15});
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ExpectStates(run, kFirst + 1, 15, TrackingState::kRepeated);
  EXPECT_EQ(Count(run.refined, TrackingState::kBridged), 0);
  // Spread over the time that no image measures, there is the way to the first image afterwards, and no more.
  EXPECT_NEAR(Drift(run.refined, kFirst, kLast + 1), DriftOf(drive, kFirst, kLast + 1), 0.03);
  ExpectGoodDrive(run, drive);
}

TEST(OdometryTrouble, AFreezeWhileTheCarGoesOnIsPartOfThePath) {
  for (const int frozen : {8, 20}) {
    StreetDrive drive = PlainStreetDrive();
    for (int i = 65; i < 65 + frozen; ++i) drive.images[i] = CompressedAnew(drive.images[64]);
    const OdometryRun run = RunOdometry(StreetOptions(), drive);
    ASSERT_TRUE(AllPosed(run.refined));
    ExpectStates(run, 65, frozen, TrackingState::kRepeated);
    EXPECT_NEAR(Drift(run.refined, 64, 90) / Drift(run.refined, 54, 64),
                DriftOf(drive, 64, 90) / DriftOf(drive, 54, 64), 0.1 * DriftOf(drive, 64, 90) / DriftOf(drive, 54, 64))
        << frozen << " frames";
  }
}

TEST(OdometryTrouble, ARestartTellsHowFarItsUnitMayBeOff) {
  const auto sigma_after = [](int dark) {
    StreetDrive drive = PlainStreetDrive();
    SpoilImages(drive, 64, dark, Black);
    Odometry odometry(StreetOptions(), drive.camera);
    double sigma = 0;
    for (size_t i = 0; i < drive.images.size() && sigma == 0; ++i) {
      odometry.Process(drive.images[i], drive.times[i]);
      for (const Keyframe& keyframe : odometry.map().keyframes) {
        EXPECT_EQ(keyframe.gap_sigma > 0, keyframe.after_gap);
        sigma = std::max(sigma, keyframe.gap_sigma);
      }
    }
    return sigma;
  };
  const MotionModelOptions motion;
  const TrackingOptions tracking;
  const double after_short = sigma_after(5);
  EXPECT_GT(after_short, motion.speed_sigma + 0.3 * motion.speed_sigma_per_second);
  EXPECT_LT(after_short, tracking.depth_sigma);
  EXPECT_GT(sigma_after(8), after_short + 0.2 * motion.speed_sigma_per_second);
  EXPECT_EQ(sigma_after(40), tracking.depth_sigma) << "after 4 s the depth of the scene says more";
}

TEST(OdometryTrouble, ARestartAfterAFreezeKeepsTheSpeedFromBefore) {
  // The image freezes for 0.8 s and is dark for as long before it goes on; the car keeps its speed meanwhile.
  StreetDrive drive = PlainStreetDrive();
  for (int i = 60; i < 68; ++i) drive.images[i] = CompressedAnew(drive.images[59]);
  SpoilImages(drive, 68, 8, Black);
  OdometryOptions options = StreetOptions();
  for (const double max_seconds : {0.5, options.repeats.max_seconds}) {
    options.repeats.max_seconds = max_seconds;
    const OdometryRun run = RunOdometry(options, drive);
    ASSERT_TRUE(AllPosed(run.refined));
    const double before = Drift(run.refined, 50, 59);
    EXPECT_NEAR(Drift(run.refined, 90, 100) / before, DriftOf(drive, 90, 100) / DriftOf(drive, 50, 59), 0.075)
        << max_seconds << " s";
  }
}

// A wall of texture passes from the right to the left and hides all of the image but its upper edge.
void PassBefore(StreetDrive& drive, int first, int count) {
  const cv::Size size = drive.images[first].size();
  cv::Mat coarse(size.height / 6, size.width / 2, CV_8UC1);
  cv::RNG(5).fill(coarse, cv::RNG::UNIFORM, 40, 216);
  cv::Mat wall;
  cv::resize(coarse, wall, {3 * size.width, size.height});
  for (int i = 0; i < count; ++i) {
    const int left = size.width - 4 * size.width * (i + 1) / (count + 1);
    const cv::Rect hidden = cv::Rect(left, size.height / 10, wall.cols, size.height) & cv::Rect({0, 0}, size);
    if (hidden.empty()) continue;
    drive.images[first + i] = drive.images[first + i].clone();
    wall(hidden - cv::Point(left, hidden.y)).copyTo(drive.images[first + i](hidden));
  }
}

TEST(OdometryTrouble, WhatPassesBeforeACarThatWaitsLeavesNoTrace) {
  StreetDrive drive = RenderStreetDrive({.standing_at = 68, .standing_frames = 60, .braking_frames = 6});
  PassBefore(drive, 90, 30);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  EXPECT_LT(Drift(run.refined, 80, 120), 0.25) << "few landmarks are left in sight";
  EXPECT_TRUE(std::ranges::none_of(run.map.keyframes, [](const Keyframe& keyframe) { return keyframe.after_gap; }));
  for (size_t i = 124; i < run.refined.size(); ++i) EXPECT_EQ(run.refined[i].state, TrackingState::kTracked) << i;
  ExpectGoodDrive(run, drive);
}

TEST(OdometryTrouble, ACarThatNeverMovesHasNoMap) {
  StreetDrive drive = RenderStreetDrive({.frames = 31, .standing_at = 0, .standing_frames = 30});
  SpoilImages(drive, 10, 1, Nothing);
  SpoilImages(drive, 20, 2, Black);
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  EXPECT_TRUE(run.map.keyframes.empty());
  EXPECT_TRUE(run.turns.empty());
  ASSERT_EQ(run.refined.size(), drive.times.size());
  for (const std::vector<FrameResult>* frames : {&run.live, &run.refined})
    for (const FrameResult& frame : *frames) {
      EXPECT_FALSE(frame.world_from_camera) << "frame " << frame.frame;
      EXPECT_EQ(frame.state, frame.frame == 10 ? TrackingState::kUnreadable : TrackingState::kInitializing);
    }
}

std::string Complaint(Odometry& odometry, const cv::Mat& image, double time) {
  try {
    odometry.Process(image, time);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(OdometryTrouble, WhatIsNoFrameIsRefusedAndLeavesNoTrace) {
  const StreetDrive drive = PlainStreetDrive(3);
  CameraModel camera = drive.camera;
  camera.width = camera.height = 0;
  Odometry odometry(StreetOptions(), camera);
  EXPECT_NE(Complaint(odometry, {}, 0).find("image: is empty"), std::string::npos)
      << "its type is that of a gray image";
  const cv::Mat small(100, 200, CV_8UC1, cv::Scalar(0));
  for (const double time : {HUGE_VAL, -HUGE_VAL, std::nan("")}) {
    EXPECT_NE(Complaint(odometry, small, time).find("s: has to be a finite number"), std::string::npos) << time;
    EXPECT_THROW(odometry.ProcessUnreadable(time), InputError);
  }
  EXPECT_EQ(odometry.camera().width, 0);
  odometry.SetMask(cv::Mat(drive.images[0].size(), CV_8UC1, cv::Scalar(255)));
  EXPECT_NE(Complaint(odometry, small, 0).find("mask: is 480x192, the images are 200x100"), std::string::npos);
  EXPECT_EQ(odometry.camera().width, 0);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(Complaint(odometry, drive.images[i], drive.times[i]), "") << i;
  EXPECT_EQ(odometry.camera().width, drive.images[0].cols);
  EXPECT_NE(Complaint(odometry, drive.images[0], drive.times[2]).find("after the frame before"), std::string::npos);
  EXPECT_NE(Complaint(odometry, small, drive.times[2] + 1).find("200x100"), std::string::npos);
  EXPECT_THROW(odometry.SetMask(small), InternalError) << "it comes too late";
}

TEST(OdometryTrouble, ACameraWithHalfASizeOrWithoutAFocalLengthIsRefused) {
  CameraModel camera;
  camera.width = 480;
  EXPECT_THROW(Odometry(StreetOptions(), camera), InputError);
  camera.width = 0;
  for (const double fx : {0.0, -400.0, std::nan(""), HUGE_VAL}) {
    camera.pinhole = {fx, 400, 240, 96};
    EXPECT_THROW(Odometry(StreetOptions(), camera), InputError) << fx;
  }
  camera.pinhole = {400, 400, std::nan(""), 96};
  EXPECT_THROW(Odometry(StreetOptions(), camera), InputError);
}

TEST(OdometryTrouble, AMaskHasToLeaveSomething) {
  Odometry odometry(StreetOptions(), PlainStreetDrive(1).camera);
  for (const cv::Mat& mask :
       {cv::Mat(), cv::Mat(192, 480, CV_8UC3, cv::Scalar::all(255)), cv::Mat(192, 480, CV_8UC1, cv::Scalar(0))})
    EXPECT_THROW(odometry.SetMask(mask), InputError);
}

TEST(OdometryTrouble, TimesThatCannotBeSecondsAreRefused) {
  const StreetDrive drive = PlainStreetDrive(1);
  // The ninth of frames that are so far apart is refused, but not a usual one between them.
  for (const auto& [interval, refused] : {std::pair(9.0, false), {104.0, true}, {1e8, true}}) {
    Odometry odometry(StreetOptions(), drive.camera);
    for (int i = 0; i < 8; ++i) EXPECT_EQ(Complaint(odometry, drive.images[0], i * interval), "");
    const std::string complaint = Complaint(odometry, drive.images[0], 8 * interval);
    EXPECT_EQ(complaint.find("Give seconds") != std::string::npos, refused) << complaint;
    if (!refused) continue;
    EXPECT_THROW(odometry.ProcessUnreadable(8 * interval), InputError);
    EXPECT_EQ(Complaint(odometry, drive.images[0], 7 * interval + 0.1), "");
    EXPECT_EQ(Complaint(odometry, drive.images[0], 8 * interval), "");
  }
}

}  // namespace
}  // namespace turnscale

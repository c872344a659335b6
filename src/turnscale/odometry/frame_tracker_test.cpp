// SPDX-License-Identifier: MIT
#include "turnscale/odometry/frame_tracker.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "turnscale/features/corners.h"
#include "turnscale/features/synthetic_texture.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kWallDepth = 10;
constexpr double kInterval = 0.1;  // seconds

// A textured wall straight ahead, all of whose landmarks have their depth; the camera moves to the right and the image
// to the left.
class FrameTracking : public testing::Test {
 protected:
  FrameTracking() {
    map_.camera = {.pinhole = {400, 400, 160, 120}, .width = 320, .height = 240};
    map_.keyframes.push_back({0, 0, {}, {}, false});
    const FlowImage image = Seen(0);
    const auto reference = std::make_shared<const cv::Mat>(image.gray);
    std::vector<FeatureTrack> tracks;
    for (int row = 24; row <= 216; row += 16)
      for (int column = 24; column <= 296; column += 16) {
        const Eigen::Vector2d pixel(column + 0.3, row - 0.2);
        const int landmark = static_cast<int>(map_.landmarks.size());
        map_.landmarks.push_back({kWallDepth * map_.camera.pinhole.Ray(pixel), true, {}});
        AddObservation(map_, 0, landmark, pixel);
        const cv::Point2f shown(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
        tracks.push_back({landmark, shown, pixel, pixel, reference, shown, 0, 0});
      }
    const int landmarks = static_cast<int>(tracks.size());
    tracker_.Start(image, std::move(tracks), landmarks);
    motion_.Restart(0, {});
  }

  RigidTransform Moved(double pixels) const {
    return {Eigen::Quaterniond::Identity(), {-pixels * kWallDepth / map_.camera.pinhole.fx, 0, 0}};
  }

  FlowImage Seen(double pixels) const {
    return BuildFlowImage(options_.flow,
                          MakeImage({map_.camera.width, map_.camera.height}, [&](const Eigen::Vector2d& pixel) {
                            return texture_.At(pixel + Eigen::Vector2d(pixels, 0));
                          }));
  }

  FlowImage Noise() const {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> gray(0, 255);
    return BuildFlowImage(options_.flow, MakeImage({map_.camera.width, map_.camera.height},
                                                   [&](const Eigen::Vector2d&) { return gray(random); }));
  }

  TrackedFrame Track(FlowImage image, const RigidTransform& predicted, double time) {
    return tracker_.Track(map_, mask_, image, motion_, predicted, time);
  }

  TrackedFrame Track(FlowImage image, double predicted_pixels) {
    return Track(std::move(image), Moved(predicted_pixels), kInterval);
  }

  OdometryOptions options_;
  Map map_;
  cv::Mat mask_;
  SyntheticTexture texture_{11};
  FrameTracker tracker_{options_};
  MotionModel motion_;
};

TEST_F(FrameTracking, FindsThePose) {
  const int before = static_cast<int>(tracker_.tracks().size());
  const TrackedFrame frame = Track(Seen(6.4), 4);
  ASSERT_TRUE(frame.camera_from_world);
  EXPECT_GT(frame.inliers, 0.9 * before);
  EXPECT_EQ(frame.tracked, static_cast<int>(tracker_.tracks().size()));
  // A twentieth of a pixel.
  EXPECT_LT((frame.camera_from_world->translation - Moved(6.4).translation).norm(), 0.05 * kWallDepth / 400);
}

TEST_F(FrameTracking, OpticalFlowAloneFollowsNothingAcrossAGap) {
  constexpr int kEvery = 3;
  for (size_t i = 0; i < map_.landmarks.size(); i += kEvery) map_.landmarks[i].valid = false;
  const auto without_depth = [&] {
    return std::ranges::count_if(tracker_.tracks(),
                                 [&](const FeatureTrack& track) { return !map_.landmarks[track.landmark].valid; });
  };
  const auto track = [&](double pixels, double time) {
    const TrackedFrame frame = Track(Seen(pixels), Moved(pixels), time);
    ASSERT_TRUE(frame.camera_from_world);
    motion_.Update(time, *frame.camera_from_world);
  };
  track(2, kInterval);
  EXPECT_GT(without_depth(), 0);
  track(4, 2 * kInterval);
  EXPECT_GT(without_depth(), 0);
  track(6, 2);
  EXPECT_EQ(without_depth(), 0);
  EXPECT_FALSE(tracker_.tracks().empty());
}

TEST_F(FrameTracking, AVideoAtALowRateHasNoGaps) {
  map_.landmarks.front().valid = false;
  for (int i = 1; i <= 3; ++i) {
    const TrackedFrame frame = Track(Seen(2 * i), Moved(2 * i), i);
    ASSERT_TRUE(frame.camera_from_world);
    motion_.Update(i, *frame.camera_from_world);
  }
  EXPECT_TRUE(std::ranges::any_of(tracker_.tracks(), [&](const FeatureTrack& track) { return track.landmark == 0; }));
}

TEST_F(FrameTracking, AParallaxFollowsTheUnitOfLength) {
  std::vector<FeatureTrack> tracks = tracker_.tracks();
  for (FeatureTrack& track : tracks) {
    track.parallax = Eigen::Vector2d(30, 0);
    track.parallax_base = 0.2;
  }
  const int landmarks = static_cast<int>(tracks.size());
  tracker_.Start(Seen(0), std::move(tracks), landmarks);
  tracker_.Rescale(2);
  for (const FeatureTrack& track : tracker_.tracks()) {
    EXPECT_EQ(track.parallax->x(), 15);
    EXPECT_EQ(track.parallax_base, 0.4);
  }
}

// With half of the wall gone, too few of the sample agree, and all tracks are followed by optical flow.
TEST_F(FrameTracking, FindsThePoseWhereMostOfTheSampleIsGone) {
  FlowImage image = Seen(6.4);
  cv::Mat gray = image.gray.clone();
  // As bright as before: the images are not made equally bright.
  gray.colRange(0, 190).setTo(cv::mean(gray));
  std::vector<FeatureTrack> tracks = tracker_.tracks();
  for (FeatureTrack& track : tracks) {
    track.parallax = Eigen::Vector2d(1e6, 1e6);
    track.parallax_base = 1;
  }
  const int landmarks = static_cast<int>(tracks.size());
  tracker_.Start(Seen(0), std::move(tracks), landmarks);
  const TrackedFrame frame = Track(BuildFlowImage(options_.flow, gray), 4);
  ASSERT_TRUE(frame.camera_from_world);
  EXPECT_LT(frame.inliers, 0.6 * landmarks);
  EXPECT_GT(frame.inliers, options_.tracking.min_inliers);
  for (const FeatureTrack& track : tracker_.tracks()) {
    EXPECT_GT(track.pixel.x, 180);
    // Half of the wall hardly tells a turn from a motion to the side; where it is seen, it does.
    const Eigen::Vector3d seen = *frame.camera_from_world * map_.landmarks[track.landmark].position;
    EXPECT_LT((map_.camera.pinhole.Project(seen) - *track.in_keyframe + Eigen::Vector2d(6.4, 0)).norm(), 0.2);
    EXPECT_FALSE(track.parallax) << "that of an earlier image";
  }
}

// Fewer landmarks than a sample needs.
TEST_F(FrameTracking, FindsThePoseByFewLandmarks) {
  std::vector<FeatureTrack> tracks = tracker_.tracks();
  std::erase_if(tracks, [](const FeatureTrack& track) { return track.landmark % 6 != 0; });
  ASSERT_LT(tracks.size(), 50U);
  const int landmarks = static_cast<int>(tracks.size());
  tracker_.Start(Seen(0), std::move(tracks), landmarks);
  const TrackedFrame frame = Track(Seen(6.4), 4);
  ASSERT_TRUE(frame.camera_from_world);
  EXPECT_GT(frame.inliers, 0.9 * landmarks);
  EXPECT_LT((frame.camera_from_world->translation - Moved(6.4).translation).norm(), 0.05 * kWallDepth / 400);
}

TEST_F(FrameTracking, FindsThePoseFromAnotherPrediction) {
  // The prediction is out of the optical flow's reach; that the camera stands still is right.
  motion_.Update(kInterval, {});
  const TrackedFrame frame = Track(Seen(0.3), Moved(250), 2 * kInterval);
  ASSERT_TRUE(frame.camera_from_world);
  EXPECT_LT((frame.camera_from_world->translation - Moved(0.3).translation).norm(), 0.05 * kWallDepth / 400);
}

TEST_F(FrameTracking, WhatShowsNothingKnownLeavesTheTracks) {
  const size_t before = tracker_.tracks().size();
  const TrackedFrame frame = Track(Noise(), 0);
  EXPECT_FALSE(frame.camera_from_world);
  EXPECT_EQ(tracker_.tracks().size(), before);
  EXPECT_TRUE(Track(Seen(5), 3).camera_from_world) << "the next image is tracked from the last good one";
}

TEST_F(FrameTracking, AnImageThatIsTheLastOneIsARepeat) {
  EXPECT_TRUE(tracker_.IsRepeat(map_, Seen(0), Moved(5), {kInterval, kInterval}));
  EXPECT_FALSE(tracker_.IsRepeat(map_, Seen(5), Moved(5), {kInterval, kInterval}));
}

TEST_F(FrameTracking, ACameraHasStoodAfterASecondWithoutMotion) {
  const auto has_stood = [&](double pixels, double time) {
    EXPECT_TRUE(Track(Seen(pixels), Moved(pixels), time).camera_from_world);
    return tracker_.HasStood();
  };
  EXPECT_FALSE(has_stood(0, 0.5));
  EXPECT_FALSE(has_stood(0, 1.4));
  EXPECT_TRUE(has_stood(0, 1.5));
  EXPECT_FALSE(has_stood(6, 1.6)) << "it has moved";
  EXPECT_FALSE(has_stood(0, 1.7));
  EXPECT_TRUE(has_stood(0, 2.7));
  tracker_.Start(Seen(0), tracker_.tracks(), static_cast<int>(tracker_.tracks().size()));
  EXPECT_FALSE(tracker_.HasStood()) << "of another map";
}

// As at more than 40 images per second: a sample of the landmarks gives the pose of some of them.
class FrameSampling : public FrameTracking {
 protected:
  TrackedFrame TrackNext(double pixels, double time) {
    FlowImage image = Seen(pixels);
    image.pyramid.clear();
    const TrackedFrame frame = tracker_.Track(map_, mask_, image, motion_, motion_.Predict(time), time);
    EXPECT_TRUE(frame.camera_from_world);
    EXPECT_EQ(image.pyramid.empty(), frame.is_sampled);
    if (frame.camera_from_world) motion_.Update(time, *frame.camera_from_world);
    return frame;
  }

  // Pixels by which the camera has moved according to two frames.
  double Motion(const TrackedFrame& first, const TrackedFrame& second) const {
    const Eigen::Vector3d moved = first.camera_from_world->translation - second.camera_from_world->translation;
    return moved.x() * map_.camera.pinhole.fx / kWallDepth;
  }
};

TEST_F(FrameSampling, EveryOtherImageAtSixtyPerSecond) {
  const TrackedFrame first = TrackNext(6, 0.1);
  EXPECT_FALSE(first.is_sampled);
  const std::vector<FeatureTrack> tracks = tracker_.tracks();
  const TrackedFrame next = TrackNext(7.5, 0.117);
  EXPECT_TRUE(next.is_sampled);
  EXPECT_LT(next.tracked, 0.7 * static_cast<double>(tracks.size()));
  EXPECT_GT(next.inliers, 100);
  EXPECT_NEAR(Motion(first, next), 1.5, 0.05);
  EXPECT_FALSE(tracker_.NeedsKeyframe(map_, next));
  EXPECT_EQ(tracker_.tracks().size(), tracks.size());
  EXPECT_EQ(tracker_.tracks().front().pixel, tracks.front().pixel) << "the tracks are those of the image before";
  EXPECT_EQ(static_cast<int>(tracker_.found().size()), next.tracked);
  EXPECT_NEAR(tracker_.found().front().pixel.x, tracks.front().pixel.x - 1.5, 0.2);
  EXPECT_TRUE(tracker_.IsRepeat(map_, Seen(7.5), Moved(12), {0.017, 0.017}));
  EXPECT_FALSE(tracker_.IsRepeat(map_, Seen(6), Moved(12), {0.017, 0.017})) << "the image before";
  const TrackedFrame last = TrackNext(9, 0.134);
  EXPECT_FALSE(last.is_sampled);
  EXPECT_NEAR(Motion(first, last), 3, 0.05);
  EXPECT_NEAR(tracker_.tracks().front().pixel.x, tracks.front().pixel.x - 3, 0.3);
  EXPECT_EQ(tracker_.found().size(), tracker_.tracks().size());
}

TEST_F(FrameSampling, TwoOfThreeImagesAtOneHundredAndTwentyPerSecond) {
  TrackedFrame last = TrackNext(6, 0.1);
  for (const bool is_sampled : {true, true, false, true, true, false}) {
    const double time = motion_.last_measured_time() + 1.0 / 120;
    const TrackedFrame next = TrackNext(6 + 90 * (time - 0.1), time);
    EXPECT_EQ(next.is_sampled, is_sampled) << time;
    EXPECT_NEAR(Motion(last, next), 0.75, 0.06) << time;
    last = next;
  }
}

// The sample may have other errors than all landmarks together.
TEST_F(FrameSampling, ErrorsOfLandmarksCancel) {
  for (const FeatureTrack* track : SampleWithDepth(map_, tracker_.tracks(), 120))
    map_.landmarks[track->landmark].position.x() += kWallDepth / 400;
  const TrackedFrame first = TrackNext(6, 0.1);
  const TrackedFrame next = TrackNext(7.5, 0.117);
  ASSERT_TRUE(next.is_sampled);
  EXPECT_NEAR(Motion(first, next), 1.5, 0.05);
}

TEST_F(FrameSampling, WhatIsFarFromThePredictionIsTrackedInFull) {
  TrackNext(6, 0.1);
  const TrackedFrame next = TrackNext(10.5, 0.117);
  EXPECT_FALSE(next.is_sampled);
  EXPECT_LT((next.camera_from_world->translation - Moved(10.5).translation).norm(), 0.05 * kWallDepth / 400);
}

TEST_F(FrameTracking, AKeyframeIsDueAfterEnoughParallax) {
  const double due = 400 * std::tan(options_.keyframes.min_parallax_deg * M_PI / 180);
  const TrackedFrame little = Track(Seen(0.8 * due), 0.8 * due);
  ASSERT_TRUE(little.camera_from_world);
  EXPECT_FALSE(tracker_.NeedsKeyframe(map_, little));
  const TrackedFrame enough = Track(Seen(1.2 * due), Moved(1.2 * due), 2 * kInterval);
  ASSERT_TRUE(enough.camera_from_world);
  EXPECT_TRUE(tracker_.NeedsKeyframe(map_, enough));
}

TEST_F(FrameTracking, AKeyframeGetsNewFeatures) {
  const FlowImage image = Seen(20);
  const TrackedFrame frame = Track(image, 20);
  ASSERT_TRUE(frame.camera_from_world);
  map_.keyframes.push_back({1, kInterval, *frame.camera_from_world, {}, false});
  const size_t tracked = tracker_.tracks().size();
  const size_t landmarks = map_.landmarks.size();
  tracker_.Replenish(image, mask_, FindCandidates(options_.corners, image.gray), map_);
  EXPECT_GT(map_.landmarks.size(), landmarks);
  EXPECT_EQ(tracker_.tracks().size() - tracked, map_.landmarks.size() - landmarks);
  EXPECT_FALSE(map_.landmarks.back().valid) << "its depth is not known yet";
  for (const FeatureTrack& track : tracker_.tracks()) {
    EXPECT_EQ(track.last_keyframe, 1);
    EXPECT_EQ(*track.in_keyframe, track.undistorted);
  }
}

TEST_F(FrameTracking, WhatStandsStillWhileTheSceneMovesIsNoneOfIt) {
  // Two features without a depth, first seen by the keyframe: one moves with the wall, one stays where it was.
  const Eigen::Vector2d seen(150.3, 135.8);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(100.3, 55.8), seen}) {
    map_.landmarks.push_back({});
    AddObservation(map_, 0, static_cast<int>(map_.landmarks.size()) - 1, pixel);
  }
  const int moving = static_cast<int>(map_.landmarks.size()) - 2;
  const FlowImage image = Seen(0);
  const auto reference = std::make_shared<const cv::Mat>(image.gray);
  const auto track = [&](int landmark, const Eigen::Vector2d& before, const Eigen::Vector2d& now) {
    const cv::Point2f pixel(static_cast<float>(now.x()), static_cast<float>(now.y()));
    return FeatureTrack{landmark, pixel, now, before, reference, pixel, 0, 0};
  };
  tracker_.Start(image, {track(moving, {100.3, 55.8}, {120.3, 55.8}), track(moving + 1, seen, seen)}, 0);
  const Eigen::Quaterniond turned = RotationFromVector({0, 0.05, 0});
  EXPECT_TRUE(tracker_.DropStatic(map_, {Eigen::Quaterniond::Identity(), {0, 0, -1}}).size() == 1)
      << "straight ahead it may be far away";
  EXPECT_EQ(tracker_.tracks().size(), 2U);
  const std::vector<ObservedMotion> motion = tracker_.DropStatic(map_, {turned, Eigen::Vector3d::Zero()});
  ASSERT_EQ(motion.size(), 2U);
  EXPECT_FALSE(motion[0].stands_still);
  EXPECT_TRUE(motion[1].stands_still);
  ASSERT_EQ(tracker_.tracks().size(), 1U);
  EXPECT_EQ(tracker_.tracks().front().landmark, moving);
}

TEST_F(FrameTracking, MaskedPixelsAreLeftOut) {
  mask_ = cv::Mat(map_.camera.height, map_.camera.width, CV_8U, cv::Scalar(255));
  mask_.rowRange(160, 240).setTo(0);
  const FlowImage image = Seen(20);
  const TrackedFrame frame = Track(image, 20);
  ASSERT_TRUE(frame.camera_from_world);
  map_.keyframes.push_back({1, kInterval, *frame.camera_from_world, {}, false});
  tracker_.Replenish(image, mask_, FindCandidates(options_.corners, image.gray), map_);
  EXPECT_GT(tracker_.tracks().size(), 100U);
  for (const FeatureTrack& track : tracker_.tracks()) EXPECT_TRUE(IsKept(mask_, track.pixel)) << track.pixel;
}

TEST_F(FrameTracking, LandmarksThatGoTakeTheirTracksAlong) {
  const size_t before = tracker_.tracks().size();
  tracker_.Drop({3, 7});
  ASSERT_EQ(tracker_.tracks().size(), before - 2);
  std::vector<int> new_index(before, -1);
  for (size_t i = 10; i < before; ++i) new_index[i] = static_cast<int>(i) - 10;
  tracker_.Reindex(new_index);
  ASSERT_EQ(tracker_.tracks().size(), before - 10);
  std::set<int> seen;
  for (const FeatureTrack& track : tracker_.tracks()) seen.insert(track.landmark);
  EXPECT_EQ(*seen.begin(), 0);
  EXPECT_EQ(*seen.rbegin(), static_cast<int>(before) - 11);
}

TEST_F(FrameTracking, CorrectedPixelsAreThoseOfTracksAndKeyframe) {
  const FeatureTrack before = tracker_.tracks().front();
  tracker_.Correct([](const Eigen::Vector2d& pixel) -> Eigen::Vector2d { return pixel + Eigen::Vector2d(1, -2); });
  const FeatureTrack& after = tracker_.tracks().front();
  EXPECT_EQ(after.undistorted, before.undistorted + Eigen::Vector2d(1, -2));
  EXPECT_EQ(*after.in_keyframe, *before.in_keyframe + Eigen::Vector2d(1, -2));
  EXPECT_EQ(after.pixel, before.pixel);
}

}  // namespace
}  // namespace turnscale

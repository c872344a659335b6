// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/core/utility.hpp>

#include "odometry_run.h"
#include "street_drive.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/odometry.h"

namespace turnscale {
namespace {

// The plain drive up to where the first turn is over and its scale known.
StreetDrive DriveWithOneTurn() { return PlainStreetDrive(75); }

void ExpectBothTurns(const OdometryRun& run) {
  ASSERT_EQ(run.turns.size(), 2U);
  EXPECT_NEAR(run.turns[0].angle * kDegreesPerRadian, 90, 5);
  EXPECT_NEAR(run.turns[1].angle * kDegreesPerRadian, -90, 5);
  const int starts[] = {kStreetFirstTurn, kStreetSecondTurn};
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(run.turns[i].first_frame, starts[i], 4);
    EXPECT_NEAR(run.turns[i].last_frame, starts[i] + kStreetTurnFrames, 4);
    EXPECT_TRUE(run.turns[i].used) << run.turns[i].reason;
    EXPECT_NEAR(run.turns[i].effective_lever_arm, kStreetLeverArm, 0.016 * kStreetLeverArm);
  }
}

// Relative error of the length of the live path's last `frames` steps.
double MotionError(const OdometryRun& run, const StreetDrive& drive, int frame, int frames) {
  const auto length = [&](const RigidTransform& first, const RigidTransform& second) {
    return (second.translation - first.translation).norm();
  };
  return length(*run.live[frame - frames].world_from_camera, *run.live[frame].world_from_camera) /
             length(drive.world_from_camera[frame - frames], drive.world_from_camera[frame]) -
         1;
}

void ExpectSameBits(const std::vector<FrameResult>& first, const std::vector<FrameResult>& second) {
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    ASSERT_EQ(first[i].world_from_camera.has_value(), second[i].world_from_camera.has_value()) << "frame " << i;
    if (!first[i].world_from_camera) continue;
    const RigidTransform& a = *first[i].world_from_camera;
    const RigidTransform& b = *second[i].world_from_camera;
    ASSERT_EQ(a.translation, b.translation) << "frame " << i;
    ASSERT_EQ(a.rotation.coeffs(), b.rotation.coeffs()) << "frame " << i;
    ASSERT_EQ(first[i].inliers, second[i].inliers) << "frame " << i;
  }
}

TEST(OdometryMetres, TwoTurnsGiveTheDrivesMetres) {
  const StreetDrive drive = PlainStreetDrive();
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ExpectMetres(run, drive);
  ExpectBothTurns(run);
  EXPECT_EQ(Count(run.refined, TrackingState::kTracked), kStreetFrames);
}

TEST(OdometryMetres, ScaleIsPendingUntilWellInsideTheFirstTurn) {
  const StreetDrive drive = DriveWithOneTurn();
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ASSERT_EQ(run.turns.size(), 1U);
  const auto known = std::ranges::find_if(
      run.live, [](const FrameResult& frame) { return frame.scale_state != ScaleState::kPending; });
  ASSERT_NE(known, run.live.end());
  EXPECT_EQ(known->scale_state, ScaleState::kObserved);
  EXPECT_GT(known->frame, run.turns[0].first_frame + 2);
  EXPECT_LT(known->frame, run.turns[0].first_frame + 12) << "long before the turn is over";
  for (auto frame = run.live.begin(); frame != known; ++frame) EXPECT_TRUE(std::isinf(frame->scale_sigma));
  for (auto frame = known; frame != run.live.end(); ++frame) {
    EXPECT_NE(frame->scale_state, ScaleState::kPending) << "frame " << frame->frame;
    EXPECT_LE(frame->scale_sigma, 0.15) << "frame " << frame->frame;
  }
  EXPECT_LT(run.live.back().scale_sigma, known->scale_sigma) << "better with every keyframe of the turn";
  EXPECT_EQ(run.live.back().scale_state, ScaleState::kFromRoad);
  // What is tracked from here on is in metres, and tracking does not notice.
  int fewest_inliers_before = known->inliers;
  for (auto frame = known - 5; frame != known; ++frame)
    fewest_inliers_before = std::min(fewest_inliers_before, frame->inliers);
  for (auto frame = known + 1; frame != run.live.end(); ++frame) {
    EXPECT_EQ(frame->state, TrackingState::kTracked) << "frame " << frame->frame;
    EXPECT_GT(frame->inliers, 0.7 * fewest_inliers_before) << "frame " << frame->frame;
    // While the turn goes on, the way before it grows or shrinks as its scale becomes known.
    if (frame->frame < run.turns[0].last_frame + 10) continue;
    // The step to a keyframe holds its adjustment besides, which takes back what tracking on the old map fell short.
    if (!frame->keyframe) {
      EXPECT_NEAR(MotionError(run, drive, frame->frame, 1), 0, 0.04) << "frame " << frame->frame;
    }
  }
  for (const FrameResult& frame : run.refined)
    EXPECT_NE(frame.scale_state, ScaleState::kPending) << "frame " << frame.frame;
}

TEST(OdometryMetres, TheLivePathGoesOnInMetresAfterATurn) {
  // Ways of four frames, over several drives: adjustments of keyframes scatter them.
  double squares = 0;
  double worst = 0;
  int ways = 0;
  for (const StreetDrive& drive : RenderStreetDrives({.frames = 80}, {42, 1, 2, 3, 4})) {
    const OdometryRun run = RunOdometry(StreetOptions(), drive);
    ASSERT_FALSE(run.turns.empty());
    for (int frame = run.turns[0].last_frame + 10; frame < static_cast<int>(run.live.size()); ++frame, ++ways) {
      const double error = MotionError(run, drive, frame, 4);
      squares += error * error;
      worst = std::max(worst, std::abs(error));
    }
  }
  EXPECT_GT(ways, 40);
  EXPECT_LT(std::sqrt(squares / ways), 0.02);
  EXPECT_LT(worst, 0.07);
}

TEST(OdometryMetres, DoNotDependOnTheFirstUnit) {
  const StreetDrive drive = DriveWithOneTurn();
  const OdometryRun one = RunOdometry(StreetOptions(), drive);
  ASSERT_EQ(one.turns.size(), 1U);
  ASSERT_TRUE(AllPosed(one.refined));
  const double extent = one.refined.back().world_from_camera->translation.norm();
  for (const double unit : {0.1, 10.0}) {
    OdometryOptions options = StreetOptions();
    options.initialization.initial_baseline = unit;
    const OdometryRun other = RunOdometry(options, drive);
    ASSERT_EQ(other.turns.size(), 1U);
    EXPECT_NEAR(other.turns[0].own * unit / one.turns[0].own, 1, 1e-6);
    ASSERT_TRUE(AllPosed(other.refined));
    for (size_t i = 0; i < drive.times.size(); ++i)
      EXPECT_LT(
          (other.refined[i].world_from_camera->translation - one.refined[i].world_from_camera->translation).norm(),
          1e-6 * extent)
          << "unit " << unit << ", frame " << i;
  }
}

TEST(OdometryMetres, ReadingResultsOnTheWayChangesNoBits) {
  const StreetDrive drive = DriveWithOneTurn();
  const OdometryRun undisturbed = RunOdometry(StreetOptions(), drive);
  for (const int threads : {1, 2}) {
    cv::setNumThreads(threads);
    Odometry odometry(StreetOptions(), drive.camera);
    for (size_t i = 0; i < drive.images.size(); ++i) {
      odometry.Process(drive.images[i], drive.times[i]);
      if (i % 3 != 0 || odometry.map().keyframes.empty()) continue;
      EXPECT_EQ(odometry.RefinedFrames().size(), i + 1);
      EXPECT_GE(odometry.lens().sigma(), 0);
      EXPECT_GE(odometry.calibration_check().windows(), 0);
    }
    odometry.Finish();
    ExpectSameBits(undisturbed.refined, odometry.RefinedFrames());
  }
}

TEST(OdometryMetres, ARadialCorrectionOfTheCameraStaysWithoutRefinement) {
  const StreetDrive drive = DriveWithOneTurn();
  OdometryOptions options = StreetOptions();
  options.lens.enabled = false;
  CameraModel camera = drive.camera;
  camera.radial_correction = 0.004;
  Odometry odometry(options, camera);
  for (size_t i = 0; i < drive.images.size(); ++i) odometry.Process(drive.images[i], drive.times[i]);
  odometry.Finish();
  EXPECT_GT(odometry.map().keyframes.size(), 5U);
  EXPECT_EQ(odometry.camera().radial_correction, 0.004);
}

TEST(OdometryMetres, AreTheSameBitsInEveryRunAndForAnyThreads) {
  const StreetDrive drive = DriveWithOneTurn();
  const OdometryRun first = RunOdometry(StreetOptions(), drive);
  for (const int threads : {1, 2}) {
    cv::setNumThreads(threads);
    const OdometryRun again = RunOdometry(StreetOptions(), drive);
    EXPECT_EQ(cv::getNumThreads(), threads) << "the library leaves the process as it is";
    ExpectSameBits(first.live, again.live);
    ExpectSameBits(first.refined, again.refined);
  }
}

TEST(OdometryMetres, AreTheSameBitsForAnyThreadsWhereATurnIsLostWhileTheLensIsRefined) {
  StreetDrive drive = RenderStreetDrive({.frames = 66, .k1 = 0.01});
  drive.camera.lens = LensModel::kPinhole;
  drive.camera.distortion = {};
  for (int i = 36; i < 48; ++i) drive.images[i].setTo(0);
  std::vector<OdometryRun> runs;
  for (const int threads : {1, 2}) {
    cv::setNumThreads(threads);
    runs.push_back(RunOdometry(StreetOptions(), drive));
  }
  EXPECT_EQ(std::ranges::count_if(runs[0].map.keyframes, &Keyframe::after_gap), 1);
  EXPECT_NE(runs[0].lens_correction, 0);
  EXPECT_EQ(runs[0].lens_correction, runs[1].lens_correction);
  ExpectSameBits(runs[0].live, runs[1].live);
  ExpectSameBits(runs[0].refined, runs[1].refined);
}

TEST(OdometryMetres, StayUnknownWithoutALeverArm) {
  const StreetDrive drive = PlainStreetDrive();
  OdometryOptions options = StreetOptions();
  options.vehicle.lever_arm.reset();
  const OdometryRun run = RunOdometry(options, drive);
  for (const std::vector<FrameResult>* frames : {&run.live, &run.refined})
    for (const FrameResult& frame : *frames) {
      EXPECT_EQ(frame.scale_state, ScaleState::kPending) << "frame " << frame.frame;
      EXPECT_TRUE(std::isinf(frame.scale_sigma)) << "frame " << frame.frame;
    }
  ASSERT_EQ(run.turns.size(), 2U);
  for (const TurnResult& turn : run.turns) {
    EXPECT_FALSE(turn.used);
    EXPECT_EQ(turn.reason, "no lever arm given");
  }
  ASSERT_TRUE(AllPosed(run.refined));
  EXPECT_LT(MeasureRun(run.refined, drive.world_from_camera).shape, 0.22);
}

TEST(OdometryMetres, SurviveALensThatTheCalibrationDoesNotKnow) {
  constexpr double kDistortion = 0.01;
  const StreetDrive drive = RenderStreetDrive({.k1 = kDistortion});
  CameraModel pinhole = drive.camera;
  pinhole.lens = LensModel::kPinhole;
  pinhole.distortion = {};
  const OdometryRun run = RunOdometry(StreetOptions(), pinhole, drive.images, drive.times);
  // The correction takes the distortion back.
  EXPECT_NEAR(run.lens_correction, -kDistortion, 0.0015);
  // With the lens left as it is, path and positions are twice as far off as this allows.
  ExpectMetres(run, drive);
}

TEST(OdometryMetres, HaveOneStateAtTheEndOfADriveWhereverItEnds) {
  const auto state_after = [](int frames) {
    const StreetDrive drive = PlainStreetDrive(frames);
    Odometry odometry(StreetOptions(), drive.camera);
    for (size_t i = 0; i < drive.images.size(); ++i) odometry.Process(drive.images[i], drive.times[i]);
    odometry.Finish();
    const std::vector<FrameResult> refined = odometry.RefinedFrames();
    EXPECT_EQ(odometry.scale_state(), refined.back().scale_state) << frames;
    return odometry.scale_state();
  };
  EXPECT_EQ(state_after(kStreetFirstTurn - 5), ScaleState::kPending);
  EXPECT_EQ(state_after(kStreetFirstTurn + kStreetTurnFrames - 3), ScaleState::kObserved) << "in its first turn";
  EXPECT_NE(state_after(kStreetSecondTurn - 3), ScaleState::kObserved) << "on the street after it";
}

TEST(OdometryMetres, FollowTheTurnsWhereTheImagesContradictTheCalibration) {
  StreetDrive drive = PlainStreetDrive();
  drive.camera.pinhole.fx *= 1.15;
  drive.camera.pinhole.fy *= 1.15;
  const OdometryRun run = RunOdometry(StreetOptions(), drive);
  ASSERT_TRUE(run.scale.estimate) << run.scale.reason;
  ASSERT_FALSE(run.scale.contradicted_calibration.empty());
  EXPECT_EQ(run.scale.contradicted_calibration.front().parameter, IntrinsicsParameter::kFocalLength);
  EXPECT_TRUE(run.scale.estimate->uses_single_turns);
  const double error = MeasureRun(run.refined, drive.world_from_camera).path_length;
  EXPECT_LT(std::abs(error), run.scale.estimate->length_sigma);

  OdometryOptions turns = StreetOptions();
  turns.scale.method = ScaleMethod::kTurns;
  const double error_of_turns = MeasureRun(RunOdometry(turns, drive).refined, drive.world_from_camera).path_length;
  EXPECT_NEAR(error, error_of_turns, 1e-9);
}

TEST(OdometryMetres, ComeThroughADistortedLensThatIsCalibrated) {
  for (const bool fisheye : {false, true}) {
    const StreetDrive drive = RenderStreetDrive({.frames = 75, .k1 = fisheye ? 0.02 : -0.15, .fisheye = fisheye});
    const OdometryRun run = RunOdometry(StreetOptions(), drive);
    ASSERT_EQ(run.turns.size(), 1U) << "fisheye " << fisheye;
    EXPECT_EQ(Count(run.refined, TrackingState::kTracked), static_cast<int>(drive.times.size()));
    EXPECT_NEAR(run.lens_correction, 0, 0.0022);
    EXPECT_TRUE(run.scale.contradicted_calibration.empty());
    ExpectMetres(run, drive);
    if (!fisheye) continue;
    CameraModel wrong = drive.camera;
    wrong.pinhole.fx *= 1.15;
    wrong.pinhole.fy *= 1.15;
    const RefinedScale scale = RunOdometry(StreetOptions(), wrong, drive.images, drive.times).scale;
    ASSERT_FALSE(scale.contradicted_calibration.empty());
    const ParameterEstimate& focal_length = scale.contradicted_calibration.front();
    EXPECT_EQ(focal_length.parameter, IntrinsicsParameter::kFocalLength);
    EXPECT_NEAR(focal_length.found, drive.camera.pinhole.fx, 3 * focal_length.sigma);
  }
}

TEST(OdometryMetres, KnowOrFindHowTheCameraIsTurned) {
  const Eigen::Quaterniond vehicle_from_camera =
      RotationFromYawPitchRoll({5 / kDegreesPerRadian, -4 / kDegreesPerRadian, 2 / kDegreesPerRadian});
  const StreetDrive drive = RenderStreetDrive({.vehicle_from_camera = vehicle_from_camera});
  OdometryOptions options = StreetOptions();
  options.vehicle.calibrate_camera = true;
  const OdometryRun found = RunOdometry(options, drive);
  ExpectMetres(found, drive);
  ExpectBothTurns(found);
  options.vehicle.calibrate_camera = false;
  options.vehicle.vehicle_from_camera = vehicle_from_camera;
  const OdometryRun given = RunOdometry(options, drive);
  ExpectMetres(given, drive);
  ExpectBothTurns(given);
}

}  // namespace
}  // namespace turnscale

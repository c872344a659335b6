// SPDX-License-Identifier: MIT
#include "turnscale/run/run_warnings.h"

#include <algorithm>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/geometry/angle.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/run/test_path.h"

namespace turnscale {
namespace {

TEST(RunWarnings, TheAdviceToRotateImagesCountsThatTheyHaveBeenRotated) {
  DriveFacts drive;
  drive.mount.estimate = MountEstimate();
  drive.mount.estimate->found = true;
  for (const auto& [roll, rotated, advice] :
       {std::tuple(90.0, 0, "--rotate 90)"), {-90.0, 0, "--rotate 270)"}, {-90.0, 90, "leave out --rotate 90"}}) {
    drive.mount.estimate->angles.roll = roll / kDegreesPerRadian;
    drive.given.rotate = rotated;
    const std::vector<std::string> warnings = SummaryOf(drive, {}, {}).warnings;
    ASSERT_EQ(warnings.size(), 1U);
    EXPECT_NE(warnings[0].find(advice), std::string::npos) << warnings[0];
  }
}

TEST(RunWarnings, BlendingIsNamedBeforeTheCalibrationThatItContradicts) {
  std::vector<FrameResult> refined(100);
  for (size_t i = 0; i < refined.size(); ++i) {
    refined[i].time = 0.1 * static_cast<double>(i);
    refined[i].state = TrackingState::kTracked;
    refined[i].scale_state = ScaleState::kHeld;
    refined[i].world_from_camera = RigidTransform{Eigen::Quaterniond::Identity(), {0, 0, static_cast<double>(i)}};
  }
  RefinedScale scale;
  scale.contradicted_calibration.resize(1);
  scale.estimate.emplace().converged = true;
  scale.estimate->length_sigma = 0.02;
  DriveFacts drive;
  drive.images.blending = FrameBlending{.from = 0.1, .to = 9.8, .period = 4};
  const RunSummary summary = SummaryOf(drive, refined, scale);
  ASSERT_EQ(summary.warnings.size(), 2U);
  EXPECT_NE(summary.warnings[0].find("by blending: each"), std::string::npos) << summary.warnings[0];
  EXPECT_TRUE(summary.warnings[1].ends_with("; the scale may be off by 2 % or more; the blending may be the cause"))
      << summary.warnings[1];
}

TEST(RunWarnings, AMethodThatCouldNotBeAppliedIsNamed) {
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  const auto warnings = [&](ScaleMethod method) {
    DriveFacts drive;
    drive.method = method;
    return SummaryOf(drive, {}, scale).warnings;
  };
  EXPECT_TRUE(warnings(ScaleMethod::kSmoothed).empty());
  ASSERT_EQ(warnings(ScaleMethod::kTurns).size(), 1U);
  EXPECT_TRUE(warnings(ScaleMethod::kTurns)[0].starts_with("the method turns was not applied"));
  EXPECT_TRUE(warnings(ScaleMethod::kTurns)[0].ends_with("uses the joint estimate"));
  EXPECT_TRUE(warnings(ScaleMethod::kPaper)[0].starts_with("the method paper was not applied"));
  scale.estimate->uses_single_turns = true;
  EXPECT_TRUE(warnings(ScaleMethod::kTurns)[0].ends_with("uses the scales of single turns, interpolated"));
  scale.constrained = true;
  EXPECT_TRUE(warnings(ScaleMethod::kTurns).empty());
}

TEST(RunWarnings, WarnsOfACameraTooLowOrTooHighForACar) {
  const auto warnings = [&](double height, std::optional<double> given = {}) {
    RefinedScale scale;
    scale.estimate.emplace().converged = true;
    scale.estimate->car.camera_height = height;
    scale.estimate->car.camera_height_sigma = 0.1;
    scale.estimate->length_sigma = 0.03;
    DriveFacts drive;
    drive.vehicle.camera_height = given;
    if (!given) WidenForHeight(scale);
    return SummaryOf(drive, PathFrames(5, 1), scale).warnings;
  };
  for (const double usual : {0.86, 1.3, 2.3}) EXPECT_TRUE(warnings(usual).empty()) << usual;
  for (const double unusual : {0.65, 2.8}) ASSERT_EQ(warnings(unusual).size(), 1u) << unusual;
  EXPECT_NE(warnings(2.8)[0].find("a camera 2.80 +-0.10 m above the road, which is unusual for a car"),
            std::string::npos);
  EXPECT_EQ(warnings(2.8)[0].find("stabilised"), std::string::npos);
  EXPECT_NE(warnings(0.65)[0].find("check --lever-arm, the calibration and whether the video is stabilised"),
            std::string::npos);
  EXPECT_TRUE(warnings(2.8, 2.8).empty()) << "a lorry's";
}

TEST(RunWarnings, WarnsOfStabilisedImages) {
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  EXPECT_TRUE(SummaryOf({}, PathFrames(5, 1), scale).warnings.empty());
  scale.estimate->image_lag = ImageLag{.found = 0.1, .found_sigma = 0.02};
  const RunSummary found = SummaryOf({}, PathFrames(5, 1), scale);
  ASSERT_EQ(found.warnings.size(), 1u);
  EXPECT_TRUE(found.warnings[0].starts_with("the images seem to be stabilised: in turns their orientation lags"));
  DriveFacts drive;
  drive.vehicle.image_lag = 0.12;
  drive.vehicle.image_lag_sigma = 0.03;
  const RunSummary known = SummaryOf(drive, PathFrames(5, 1), scale);
  ASSERT_EQ(known.warnings.size(), 1u);
  EXPECT_EQ(
      known.warnings[0],
      "the images are taken to be stabilised, with a lag of +0.12 +-0.03 s before and +0.10 +-0.02 s after this "
      "drive: without stabilisation, remove image_lag and image_lag_sigma from the file of the car or the settings");
}

TEST(RunWarnings, NamesAYawOfAnEarlierDriveThatIsNotUsed) {
  const auto warnings = [](double found_deg, bool known, std::size_t moves) {
    DriveFacts drive;
    drive.vehicle.camera_known = known;
    drive.vehicle.yaw_sigma = 0.15 / kDegreesPerRadian;
    drive.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({3.5 / kDegreesPerRadian, 0, 0});
    drive.mount.estimate = MountEstimate{
        {found_deg / kDegreesPerRadian, 0, 0}, {0.2 / kDegreesPerRadian, 0, 0}, true, std::vector<MountMove>(moves)};
    return SummaryOf(drive, PathFrames(5, 1), {}).warnings;
  };
  ASSERT_EQ(warnings(0.4, true, 0).size(), 1u);
  EXPECT_NE(warnings(0.4, true, 0)[0].find("a camera yaw of +0.4 +-0.2 deg, not +3.5 deg as in the file of the car"),
            std::string::npos);
  EXPECT_TRUE(warnings(3.3, true, 0).empty());
  EXPECT_TRUE(warnings(0.4, false, 0).empty()) << "assumed";
  EXPECT_TRUE(warnings(0.4, true, 1).empty()) << "the camera was moved";
}

TEST(RunWarnings, NamesTheTurnThatContradicts) {
  RefinedScale scale;
  for (const int first : {10, 50, 90, 130}) {
    TurnResult turn;
    turn.used = first != 50;
    turn.first_frame = first;
    turn.last_frame = first + 20;
    scale.turns.push_back(turn);
  }
  scale.estimate.emplace().converged = true;
  scale.estimate->uses_single_turns = true;
  scale.estimate->test.contradicted = true;
  scale.estimate->test.worst_turn = 2;
  scale.estimate->test.disagreement = 0.17;
  const RunSummary summary = SummaryOf({}, PathFrames(5, 1), scale);
  ASSERT_EQ(summary.warnings.size(), 1u);
  EXPECT_NE(summary.warnings[0].find("on the scale by 17 %"), std::string::npos) << summary.warnings[0];
  EXPECT_NE(summary.warnings[0].find("frames 90-110"), std::string::npos) << summary.warnings[0];
  EXPECT_NE(summary.warnings[0].find("check the camera's calibration"), std::string::npos) << summary.warnings[0];
  EXPECT_EQ(nlohmann::json::parse(SummaryJson(summary))["warnings"][0], summary.warnings[0]);
}

TEST(RunWarnings, WhatAWrongCalibrationDoesIsSaidOnce) {
  RefinedScale scale;
  scale.estimate.emplace();
  scale.estimate->converged = true;
  scale.estimate->length_sigma = 1.16;
  scale.contradicted_calibration = {{IntrinsicsParameter::kFocalLength, 500, 600, 10},
                                    {IntrinsicsParameter::kCentreX, 320, 350, 5},
                                    {IntrinsicsParameter::kDistortion, 0, 0.1, 0.01}};
  const RunSummary summary = SummaryOf({}, PathFrames(5, 1), scale);
  ASSERT_EQ(summary.warnings.size(), 1u);
  EXPECT_TRUE(summary.warnings[0].ends_with("; the scale may be off by 116 % or more")) << summary.warnings[0];

  // What may follow from it has no lines of its own.
  scale.estimate->test.contradicted = true;
  scale.estimate->test.worst_turn = 0;
  scale.estimate->test.disagreement = 0.17;
  scale.turns.resize(1);
  scale.estimate->height_conflict = HeightConflict{1.5, 0.01, 1.2, 0.05};
  scale.estimate->slip_conflict = SlipConflict{0.004, 0.002, 0.02};
  scale.estimate->yaw_conflict = YawConflict{0.01, 0.1, 0.01};
  DriveFacts drive;
  drive.vehicle.lever_arm = 1.5;
  const std::vector<std::string> warnings = SummaryOf(drive, PathFrames(5, 1), scale).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(
      warnings[0].ends_with("; this may also be why the turns disagree on the scale by 17 %, lever arm and camera "
                            "height disagree by 25 %, the "
                            "turns show an unusual side slip and the drive contradicts the camera's yaw"))
      << warnings[0];
  scale.contradicted_calibration.clear();
  EXPECT_EQ(SummaryOf(drive, PathFrames(5, 1), scale).warnings.size(), 4u);
}

TEST(RunWarnings, WarnsOfClipsThatDoNotFollowOneAnother) {
  std::vector<FrameResult> frames = PathFrames(8, 1);
  frames[4].state = TrackingState::kBridged;
  const auto warnings = [&](double start, double gap, bool unknown_gap = false, double likely_gap = 0) {
    DriveFacts drive;
    drive.ending.clips = {{"card/a.mp4", 0, start, 4, 0}, {"card/b.mp4", start, 8, 4, gap, unknown_gap, likely_gap}};
    return SummaryOf(drive, frames, {}).warnings;
  };
  const double seam = frames[4].time;
  ASSERT_EQ(warnings(seam, 0).size(), 1u);
  EXPECT_NE(warnings(seam, 0)[0].find("where a.mp4 ends and b.mp4 begins"), std::string::npos);
  EXPECT_TRUE(warnings(seam, 2).empty()) << "the gap is named already";
  EXPECT_TRUE(warnings(seam, 0, true).empty()) << "that images are missing is named already";
  EXPECT_TRUE(warnings(frames[6].time, 0).empty()) << "lost elsewhere";
  ASSERT_EQ(warnings(seam, 0, false, 1).size(), 1u);
  EXPECT_EQ(warnings(seam, 0, false, 1)[0],
            "tracking is lost where a.mp4 ends and b.mp4 begins (at 0.4 s): by the times in their names, about 1.0 s "
            "are missing there, and the path is too short");
}

TEST(RunWarnings, WarnsOfAPathThatIsMostlyAssumed) {
  const auto warnings = [](int lost) {
    std::vector<FrameResult> frames = PathFrames(11, 1);
    for (FrameResult& frame : frames) frame.keyframe = true;
    for (int i = 2; i < 2 + lost; ++i) frames[i].state = TrackingState::kBridged;
    return SummaryOf({}, frames, {}).warnings;
  };
  EXPECT_TRUE(warnings(0).empty());
  EXPECT_TRUE(warnings(5).empty()) << "half of it";
  ASSERT_EQ(warnings(6).size(), 1u);
  EXPECT_TRUE(warnings(6)[0].starts_with("60 % of the length of the path is not measured")) << warnings(6)[0];
}

TEST(RunWarnings, WarnsOfADirectionThatAGapLeavesOpen) {
  DriveFacts drive;
  drive.given.first_time = 100;
  drive.restarts = {{.frame = 20, .time = 103, .turn_sigma = 0.01}, {.frame = 90, .time = 112.5, .turn_sigma = 0.35}};
  std::vector<FrameResult> frames = PathFrames(8, 1);
  const std::vector<std::string> warnings = SummaryOf(drive, frames, {}).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("the gap before 12.5 s is hardly known (+-20 deg)"), std::string::npos) << warnings[0];
  EXPECT_TRUE(warnings[0].ends_with("as where the car turned a corner in the gap")) << warnings[0];
  // The image at 0.3 s is lost, and none follows for some seconds.
  for (size_t i = 0; i < frames.size(); ++i) frames[i].time += i < 4 ? 100 : 112.1;
  frames[3].state = TrackingState::kBridged;
  drive.restarts[1].time = frames[4].time;
  const auto says = [&](const std::string& words) {
    const std::vector<std::string> all = SummaryOf(drive, frames, {}).warnings;
    return std::ranges::any_of(all, [&](const std::string& warning) { return warning.find(words) != warning.npos; });
  };
  EXPECT_TRUE(says("the gap from 0.3 to 12.5 s is hardly known (+-20 deg)"));
  drive.restarts[1].turn_sigma = 0.1;
  EXPECT_FALSE(says("the direction of travel"));
}

TEST(RunWarnings, DoubtsAKnockWhereTheCalibrationIsWrong) {
  DriveFacts drive;
  drive.mount.jumps.resize(1);
  RefinedScale scale;
  EXPECT_TRUE(SummaryOf(drive, PathFrames(5, 1), scale).warnings.empty());
  scale.contradicted_calibration = {{IntrinsicsParameter::kFocalLength, 500, 600, 10}};
  const std::vector<std::string> warnings = SummaryOf(drive, PathFrames(5, 1), scale).warnings;
  EXPECT_TRUE(std::ranges::any_of(warnings, [](const std::string& warning) {
    return warning.starts_with("the turn of the camera on the car may come from the calibration");
  }));
  drive.images.is_upside_down = true;
  for (const std::string& warning : SummaryOf(drive, PathFrames(5, 1), scale).warnings)
    EXPECT_FALSE(warning.starts_with("the turn of the camera")) << warning;
}

}  // namespace
}  // namespace turnscale

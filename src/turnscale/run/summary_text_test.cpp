// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/geometry/angle.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/run/run_summary.h"

namespace turnscale {
namespace {

bool Says(const RunSummary& summary, const std::string& part) {
  return SummaryText(summary).find(part) != std::string::npos;
}

RunSummary InMetres(double sigma) {
  RunSummary summary;
  summary.scale_state = ScaleState::kHeld;
  summary.vehicle.lever_arm = 1.5;
  summary.path_sigma = summary.scale_sigma = sigma;
  return summary;
}

TEST(SummaryText, AScaleIsKnownUpToASigmaOf15Percent) {
  const auto known = [](double sigma) { return nlohmann::json::parse(SummaryJson(InMetres(sigma)))["scale"]["known"]; };
  EXPECT_EQ(known(0.14), true);
  EXPECT_EQ(known(0.16), false);
  EXPECT_TRUE(Says(InMetres(0.14), "scale   known, path length +-14.0 % (1 sigma)"));
  EXPECT_TRUE(Says(InMetres(0.16), "scale   uncertain, path length +-16.0 % (1 sigma)"));
  RunSummary with_gap = InMetres(0.05);
  with_gap.path_sigma = 0.2;
  with_gap.worst_sigma = 0.05;
  EXPECT_TRUE(Says(
      with_gap, "scale   known, path length +-20.0 % (1 sigma) with what warnings say of its parts, along the drive"))
      << "a part is missing";
  EXPECT_TRUE(Says(InMetres(6.6), "scale   uncertain, path length beyond +-100 % (1 sigma)"));
}

TEST(SummaryText, APendingScaleHasAReasonOrARemedy) {
  RunSummary summary;
  summary.folder = "out";
  EXPECT_TRUE(Says(summary, "turnscale rescale out --lever-arm METRES converts it"));
  summary.vehicle_file = "c.yaml";
  Summarize({}, {}, summary);
  EXPECT_TRUE(Says(summary,
                   "scale   pending, the trajectory is up to scale: c.yaml has neither lever arm nor height; give "
                   "--lever-arm; turnscale rescale out"));
  summary.vehicle.lever_arm = 1.5;
  summary.pending_reason = "no turn";
  EXPECT_TRUE(Says(summary, "scale   pending, the trajectory is up to scale: no turn\n"));
}

TEST(SummaryText, TurnsAreNotUsedWithoutALeverArm) {
  RunSummary summary;
  EXPECT_TRUE(Says(summary, "turns   0 found, 0 used\n"));
  summary.turns_found = 2;
  EXPECT_TRUE(Says(summary, "turns   2 found; not used without --lever-arm\n"));
  summary.vehicle.camera_height = 1.5;
  EXPECT_TRUE(Says(summary, "turns   2 found; not used without --lever-arm\n"));
  summary.vehicle.lever_arm = 1.5;
  EXPECT_TRUE(Says(summary, "turns   2 found, 0 used\n"));
}

TEST(SummaryText, SaysWhetherAGivenCalibrationWasTested) {
  RunSummary summary = InMetres(0.03);
  EXPECT_FALSE(Says(summary, "lens    "));
  summary.pinhole = Pinhole{600, 600, 320, 180};
  EXPECT_TRUE(Says(summary, "lens    focal length 600.0 pixels, assumed\n"));
  summary.camera = "folder/cam.yaml";
  EXPECT_TRUE(
      Says(summary, "not tested, as the drive has no sharp turn; an error of its focal length changes the scale\n"));
  summary.turns_used = 1;
  EXPECT_TRUE(Says(summary, "lens    calibration cam.yaml, not tested, as the drive has no sharp turn\n"));
  summary.calibration_windows = 2;
  EXPECT_TRUE(Says(summary, "lens    calibration cam.yaml, consistent with the turns\n"));
  summary.calibration_agrees = false;
  EXPECT_TRUE(Says(summary, "lens    calibration cam.yaml, contradicted by the turns\n"));
}

TEST(SummaryText, BothFocalLengthsAreShownWherePixelsAreNotSquare) {
  RunSummary summary = InMetres(0.03);
  summary.found_camera = FoundCamera{{{600, 600, 320, 180}}, 2, 5, true};
  summary.found_camera->camera.focal_sigma = 6;
  EXPECT_TRUE(Says(summary, "lens    focal length 600.0 +-6.0, principal point (320.0, 180.0) +-2.0 pixels"));
  summary.found_camera->camera.pinhole.fy = 800;
  EXPECT_TRUE(Says(summary,
                   "lens    focal length 600.0 +-6.0 (vertically 800.0, as pixels are 1.33 times as wide "
                   "as high), principal point"));
}

TEST(SummaryText, AContradictedRotationIsShownWithWhatIsUsed) {
  RunSummary summary = InMetres(0.03);
  summary.vehicle.camera_known = true;
  EXPECT_TRUE(Says(summary, "roll +0.00 deg, as given\n"));
  EXPECT_FALSE(nlohmann::json::parse(SummaryJson(summary))["camera_rotation"].contains("contradicting_yaw_deg"));
  summary.contradicting_yaw = 2 / kDegreesPerRadian;
  EXPECT_TRUE(Says(summary, "as given; the drive shows yaw +2.00 deg, which is used"));
  EXPECT_NEAR(nlohmann::json::parse(SummaryJson(summary))["camera_rotation"]["contradicting_yaw_deg"], 2, 1e-9);
  // With --vehicle, whose rotation the drive would refine.
  summary.mount = MountSummary{};
  const nlohmann::json rotation = nlohmann::json::parse(SummaryJson(summary))["camera_rotation"];
  EXPECT_EQ(rotation["source"], "given");
  EXPECT_NEAR(rotation["contradicting_yaw_deg"], 2, 1e-9);
}

TEST(SummaryText, AnEstimatedHeightIsToBeCompared) {
  RunSummary summary = InMetres(0.03);
  summary.car = CarRefinement();
  summary.car->camera_height = 1.5;
  summary.car->camera_height_sigma = 0.06;
  EXPECT_TRUE(Says(summary, "height  camera 1.500 +-0.060 m above the road (compare with a tape measure)\n"));
  summary.vehicle.camera_height = 1.48;
  EXPECT_TRUE(Says(summary, "height  camera 1.500 m above the road, as given\n")) << "no turn says anything of it";
  summary.turns_used = 1;
  EXPECT_TRUE(Says(summary, "height  camera 1.500 +-0.060 m above the road\n"));
}

TEST(SummaryText, ANegativeSlipIsDoubtfulUnlessNoneWasAssumed) {
  RunSummary summary = InMetres(0.03);
  summary.turns_used = 1;
  summary.car = CarRefinement();
  summary.car->side_slip_at_bound = true;
  EXPECT_TRUE(Says(summary, "would be negative: check lever arm"));
  summary.vehicle.side_slip = 0;
  EXPECT_TRUE(Says(summary, "would be negative\n"));
  EXPECT_FALSE(Says(summary, "check lever arm"));
}

TEST(SummaryText, ASlipThatTheDriveDoesNotRefineIsCalledSo) {
  RunSummary summary = InMetres(0.03);
  summary.turns_used = 1;
  summary.car = CarRefinement();
  summary.car->side_slip = 0.00451;
  summary.car->side_slip_sigma = 0.00199;
  EXPECT_TRUE(Says(summary, "side slip 0.0045 +-0.0020 s^2/m, the default, not refined by the drive\n"));
  summary.vehicle.side_slip = 0.006;
  summary.vehicle.side_slip_sigma = 0.0007;
  EXPECT_TRUE(Says(summary, "side slip 0.0045 +-0.0020 s^2/m, refined from the given 0.0060 +-0.0007 s^2/m\n"));
  summary.car->side_slip = 0.006;
  summary.car->side_slip_sigma = summary.vehicle.side_slip_sigma = 0;
  EXPECT_TRUE(Says(summary, "side slip 0.0060 s^2/m, as given, not refined by the drive\n"));
}

TEST(SummaryText, TheYawIsShownWithItsCorrection) {
  RunSummary summary = InMetres(0.03);
  summary.vehicle.camera_known = true;
  summary.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({1 / kDegreesPerRadian, 0, 0});
  summary.turns_used = 1;
  summary.car = CarRefinement();
  summary.car->yaw_error = 0.25 / kDegreesPerRadian;
  summary.car->yaw_error_sigma = 0.1 / kDegreesPerRadian;
  EXPECT_TRUE(Says(summary, "roll +0.00 deg, as given\n")) << "nor does car.yaml have it where it is not reliable";
  summary.car_evidence.emplace();
  EXPECT_TRUE(Says(summary,
                   "yaw +1.00, pitch +0.00, roll +0.00 deg, as given; the scale estimate corrects the yaw to "
                   "+1.25 +-0.10 deg (by +0.25)\n"));
  summary.car->yaw_error = -1.003 / kDegreesPerRadian;
  EXPECT_TRUE(Says(summary, "corrects the yaw to +0.00 +-0.10 deg (by -1.00)\n")) << "not -0.00";
  summary.car->yaw_error = -0.004 / kDegreesPerRadian;
  EXPECT_TRUE(Says(summary, "roll +0.00 deg, as given\n")) << "rounded to nothing";
  summary.contradicting_yaw = 1.25 / kDegreesPerRadian;
  EXPECT_TRUE(Says(summary, "as given; the drive shows yaw +1.25 deg, which is used\n"));
}

TEST(SummaryText, TimesCountFromTheFirstFrame) {
  RunSummary summary = InMetres(0.03);
  summary.worst_sigma = 0.05;
  summary.worst_sigma_time = 1774160057.4;
  summary.missing = {{MissingReason::kLost, 1774160050.5, 1774160052.0, 15}};
  summary.first_time = 1774160045.0;
  EXPECT_TRUE(Says(summary, "at most +-5.0 % (at 12.4 s)\n"));
  EXPECT_TRUE(Says(summary, "tracking lost from 5.5 s to 7.0 s (15 frames)\n"));
}

TEST(SummaryText, KnocksOfTheCameraAreListedWithTheirTime) {
  const auto knocks = [](const RunSummary& summary) {
    return nlohmann::json::parse(SummaryJson(summary))["camera_rotation"]["knocks"];
  };
  RunSummary summary = InMetres(0.03);
  EXPECT_EQ(knocks(summary), nlohmann::json::array());
  summary.camera_jumps = {{.first_frame = 125, .time = 1774160057.5, .yaw = -2.04 / kDegreesPerRadian}};
  EXPECT_EQ(knocks(summary)[0]["frame"], 125);
  EXPECT_EQ(knocks(summary)[0]["time_s"], 1774160057.5);
  EXPECT_NEAR(knocks(summary)[0]["yaw_deg"].get<double>(), -2.04, 1e-9);
  EXPECT_TRUE(Says(summary, "turned by a knock once"));
  EXPECT_EQ(CameraJumpText(summary.camera_jumps[0], 1774160045.0),
            "frame 125 (at 12.5 s): the camera was turned on the car by 2.0 degrees to the left, as by a knock");
}

TEST(SummaryText, FramesWithoutAMeasuredPoseAreNamedByTheirState) {
  RunSummary summary = InMetres(0.03);
  EXPECT_FALSE(Says(summary, "frames  "));
  summary.initializing = 12;
  summary.repeated = 3;
  EXPECT_TRUE(Says(summary, "frames  without a measured pose: 12 before initialisation, 3 repeated\n"));
}

TEST(Summarize, TheAdviceToRotateImagesCountsThatTheyHaveBeenRotated) {
  RunSummary summary;
  summary.mount = MountSummary();
  summary.mount->found = true;
  for (const auto& [roll, rotated, advice] :
       {std::tuple(90.0, 0, "--rotate 90)"), {-90.0, 0, "--rotate 270)"}, {-90.0, 90, "leave out --rotate 90"}}) {
    summary.mount->angles.roll = roll / kDegreesPerRadian;
    summary.rotate = rotated;
    summary.warnings.clear();
    Summarize({}, {}, summary);
    ASSERT_EQ(summary.warnings.size(), 1U);
    EXPECT_NE(summary.warnings[0].find(advice), std::string::npos) << summary.warnings[0];
  }
}

TEST(Summarize, AContradictedCalibrationMayBeWhyTheScaleIsPending) {
  RefinedScale scale;
  scale.reason = "no turn";
  scale.contradicted_calibration.emplace_back();
  RunSummary without_measure;
  Summarize({}, scale, without_measure);
  EXPECT_EQ(without_measure.pending_reason, "no turn");
  RunSummary summary;
  summary.vehicle.lever_arm = 1.5;
  Summarize({}, scale, summary);
  EXPECT_TRUE(summary.pending_reason.starts_with("no turn; the images contradict the calibration"));
  summary.blending.emplace();
  Summarize({}, scale, summary);
  EXPECT_TRUE(summary.pending_reason.starts_with("no turn; the images are blended, which may be the cause"));
}

TEST(Summarize, ImpossibleMotionIsNamedAndPartOfSigma) {
  std::vector<FrameResult> refined(600);
  double place = 0;
  for (size_t i = 0; i < refined.size(); ++i) {
    place += i > 200 && i <= 300 ? 0.2 : 2;
    refined[i].time = 0.1 * static_cast<double>(i);
    refined[i].state = TrackingState::kTracked;
    refined[i].scale_state = ScaleState::kHeld;
    refined[i].world_from_camera = RigidTransform{Eigen::Quaterniond::Identity(), {0, 0, place}};
  }
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  scale.estimate->length_sigma = 0.02;
  RunSummary summary;
  Summarize(refined, scale, summary);
  ASSERT_EQ(summary.warnings.size(), 1U);
  EXPECT_NE(summary.warnings[0].find("faster than a car's can"), std::string::npos) << summary.warnings[0];
  EXPECT_NEAR(summary.path_sigma, 0.18, 0.02) << "about 180 m of 1020 m";
}

TEST(Summarize, BlendingIsNamedBeforeTheCalibrationThatItContradicts) {
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
  RunSummary summary;
  summary.blending = FrameBlending{.from = 0.1, .to = 9.8, .period = 4};
  Summarize(refined, scale, summary);
  ASSERT_EQ(summary.warnings.size(), 2U);
  EXPECT_NE(summary.warnings[0].find("by blending: each"), std::string::npos) << summary.warnings[0];
  EXPECT_TRUE(summary.warnings[1].ends_with("; the scale may be off by 2 % or more; the blending may be the cause"))
      << summary.warnings[1];
}

TEST(Summarize, ImagesUpsideDownAreNamedAloneIfTheyContradictTheCalibration) {
  RefinedScale scale;
  scale.contradicted_calibration.resize(1);
  RunSummary summary;
  summary.is_upside_down = true;
  summary.rotate = 180;
  Summarize({}, scale, summary);
  ASSERT_EQ(summary.warnings.size(), 1U);
  EXPECT_NE(summary.warnings[0].find("upside down"), std::string::npos) << summary.warnings[0];
  summary.calibration_windows = 3;
  summary.calibration_agrees = false;
  summary.camera = "calib.txt";
  const std::string text = SummaryText(summary);
  EXPECT_EQ(text.find("contradicted"), std::string::npos) << text;
  EXPECT_NE(text.find("calib.txt, not tested, as the images seem to be upside down"), std::string::npos) << text;
}

// 10 frames and 10 m a second, without a map for `late` frames; a short beginning counts, but is not worth a line.
TEST(Summarize, ABeginningWithoutAMapWidensSigma) {
  const auto summary_of = [](int late, TrackingState last_of_them, int count = 100) {
    std::vector<FrameResult> frames(count);
    for (int i = 0; i < count; ++i) {
      frames[i].time = 0.1 * i;
      frames[i].state = i >= late       ? TrackingState::kTracked
                        : i + 1 == late ? last_of_them
                                        : TrackingState::kInitializing;
      frames[i].world_from_camera = RigidTransform{Eigen::Quaterniond::Identity(), {0, 0, double(std::max(i, late))}};
      frames[i].keyframe = true;
    }
    RunSummary summary = InMetres(0);
    RefinedScale scale;
    scale.estimate.emplace().converged = true;
    scale.estimate->length_sigma = 0.05;
    Summarize(frames, scale, summary);
    SummarizeBeginning(frames, {}, summary);
    return summary;
  };
  EXPECT_NEAR(summary_of(0, TrackingState::kTracked).path_sigma, 0.05, 1e-9);
  for (const TrackingState last : {TrackingState::kInitializing, TrackingState::kUnreadable}) {
    const RunSummary brief = summary_of(4, last);
    EXPECT_NEAR(brief.path_sigma, std::hypot(0.05, 4 / 95.0), 1e-6);
    EXPECT_TRUE(brief.warnings.empty());
    EXPECT_TRUE(summary_of(10, last, 1000).warnings.empty()) << "1 % of the drive";
    EXPECT_EQ(summary_of(20, last, 1000).warnings.size(), 1u) << "two seconds";
    const RunSummary late = summary_of(10, last);
    EXPECT_NEAR(late.path_sigma, std::hypot(0.05, 10 / 89.0), 1e-6);
    ASSERT_EQ(late.warnings.size(), 1u);
    EXPECT_NE(late.warnings[0].find(
                  "before 1.0 s (10 of 100 frames); if the car drove there, the path lacks up to about 10 m"),
              std::string::npos)
        << late.warnings[0];
  }
}

TEST(Summarize, AMethodThatCouldNotBeAppliedIsNamed) {
  RefinedScale scale;
  scale.estimate.emplace().converged = true;
  const auto warnings = [&](ScaleMethod method) {
    RunSummary summary;
    summary.method = method;
    Summarize({}, scale, summary);
    return summary.warnings;
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

TEST(SummaryJson, HasTheStabilisationOfTheImages) {
  RunSummary summary;
  const auto stabilisation = [&] { return nlohmann::json::parse(SummaryJson(summary))["image_stabilisation"]; };
  EXPECT_TRUE(stabilisation().is_null());
  summary.image_smoothing = ImageSmoothing{.variance = 0.25};
  EXPECT_EQ(stabilisation(), (nlohmann::json{{"smoothing_s", 0.5}}));
  summary.image_lag = ImageLag{.found = -0.125, .found_sigma = 0.03125};
  EXPECT_EQ(stabilisation(), (nlohmann::json{{"lag_s", -0.125}, {"lag_sigma_s", 0.03125}, {"smoothing_s", 0.5}}));
}

}  // namespace
}  // namespace turnscale

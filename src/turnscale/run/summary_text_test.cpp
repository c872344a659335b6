// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/geometry/angle.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/run/frame_warnings.h"
#include "turnscale/run/run_summary.h"
#include "turnscale/run/test_path.h"

namespace turnscale {
namespace {

bool Says(const RunSummary& summary, const std::string& part) {
  return SummaryText(summary).find(part) != std::string::npos;
}

RunSummary InMetres(double sigma) {
  RunSummary summary;
  summary.scale.state = ScaleState::kHeld;
  summary.drive.vehicle.lever_arm = 1.5;
  summary.scale.path_sigma = summary.scale.sigma = sigma;
  return summary;
}

TEST(SummaryText, AScaleIsKnownUpToASigmaOf15Percent) {
  const auto known = [](double sigma) { return nlohmann::json::parse(SummaryJson(InMetres(sigma)))["scale"]["known"]; };
  EXPECT_EQ(known(0.14), true);
  EXPECT_EQ(known(0.16), false);
  EXPECT_TRUE(Says(InMetres(0.14), "scale   known, path length +-14.0 % (1 sigma)"));
  EXPECT_TRUE(Says(InMetres(0.16), "scale   uncertain, path length +-16.0 % (1 sigma)"));
  RunSummary with_gap = InMetres(0.05);
  with_gap.scale.path_sigma = 0.2;
  with_gap.scale.worst_sigma = 0.05;
  EXPECT_TRUE(Says(
      with_gap, "scale   known, path length +-20.0 % (1 sigma) including the parts that warnings name, by the scale"))
      << "a part is missing";
  EXPECT_TRUE(Says(InMetres(6.6), "scale   uncertain, path length beyond +-100 % (1 sigma)"));
}

TEST(SummaryText, APendingScaleHasAReasonOrARemedy) {
  RunSummary summary;
  summary.drive.given.folder = "out";
  EXPECT_TRUE(Says(summary, "turnscale rescale out --lever-arm METRES converts it"));
  summary.drive.given.vehicle_file = "c.yaml";
  summary.scale = ScaleSummaryOf(summary.drive, {}, {}, {});
  EXPECT_TRUE(Says(summary,
                   "scale   pending, the trajectory is up to scale: c.yaml has neither lever arm nor height; give "
                   "--lever-arm; turnscale rescale out"));
  summary.drive.vehicle.lever_arm = 1.5;
  summary.scale.pending_reason = "no turn";
  EXPECT_TRUE(Says(summary, "scale   pending, the trajectory is up to scale: no turn\n"));
}

TEST(SummaryText, TurnsAreNotUsedWithoutALeverArm) {
  RunSummary summary;
  EXPECT_TRUE(Says(summary, "turns   0 found, 0 used\n"));
  summary.scale.turns_found = 2;
  EXPECT_TRUE(Says(summary, "turns   2 found; not used without --lever-arm\n"));
  summary.drive.vehicle.camera_height = 1.5;
  EXPECT_TRUE(Says(summary, "turns   2 found; not used without --lever-arm\n"));
  summary.drive.vehicle.lever_arm = 1.5;
  EXPECT_TRUE(Says(summary, "turns   2 found, 0 used\n"));
}

TEST(SummaryText, SaysWhetherAGivenCalibrationWasTested) {
  RunSummary summary = InMetres(0.03);
  EXPECT_FALSE(Says(summary, "lens    "));
  summary.drive.camera.pinhole = Pinhole{600, 600, 320, 180};
  EXPECT_TRUE(Says(summary, "lens    focal length 600.0 pixels, assumed\n"));
  summary.drive.given.camera = "folder/cam.yaml";
  EXPECT_TRUE(Says(
      summary, "not tested, as no turn of the drive can test it; an error of its focal length changes the scale\n"));
  summary.scale.turns_used = 1;
  EXPECT_TRUE(Says(summary, "lens    calibration cam.yaml, not tested, as no turn of the drive can test it\n"));
  summary.scale.calibration_windows = 2;
  EXPECT_TRUE(Says(summary, "lens    calibration cam.yaml, consistent with the turns\n"));
  summary.scale.image_lag = ImageLag{.found = 0.1, .found_sigma = 0.02, .scale_error = 0.3, .is_used = false};
  EXPECT_TRUE(Says(summary, "lens    calibration cam.yaml, left in doubt by the turns\n"));
  summary.scale.image_lag.reset();
  summary.scale.calibration_agrees = false;
  EXPECT_TRUE(Says(summary, "lens    calibration cam.yaml, contradicted by the turns\n"));
}

TEST(SummaryText, ARollingShutterIsNamed) {
  RunSummary summary = InMetres(0.03);
  EXPECT_FALSE(Says(summary, "shutter"));
  EXPECT_FALSE(nlohmann::json::parse(SummaryJson(summary))["intrinsics"].contains("readout_ms"));
  summary.scale.readout = ShutterReadout{0.0193, 0.0006};
  EXPECT_TRUE(Says(summary, "shutter rolling, 19.3 +-0.6 ms from the top of the image to the bottom"));
  EXPECT_NEAR(nlohmann::json::parse(SummaryJson(summary))["intrinsics"]["readout_ms"], 19.3, 1e-9);
  EXPECT_EQ(nlohmann::json::parse(SummaryJson(summary))["intrinsics"]["readout_direction"], "down");
  summary.scale.readout->direction = {-1, 0};
  EXPECT_TRUE(Says(summary, "19.3 +-0.6 ms from the right of the image to the left"));
  summary.scale.readout->seconds *= -1;
  EXPECT_TRUE(Says(summary, "19.3 +-0.6 ms from the left of the image to the right"));
}

TEST(SummaryText, BothFocalLengthsAreShownWherePixelsAreNotSquare) {
  RunSummary summary = InMetres(0.03);
  summary.drive.given.found_camera = FoundCamera{{{600, 600, 320, 180}}, 2, 5, true};
  summary.drive.given.found_camera->camera.focal_sigma = 6;
  EXPECT_TRUE(Says(summary, "lens    focal length 600.0 +-6.0, principal point (320.0, 180.0) +-2.0 pixels"));
  summary.drive.given.found_camera->camera.pinhole.fy = 800;
  EXPECT_TRUE(Says(summary,
                   "lens    focal length 600.0 +-6.0 (vertically 800.0, as pixels are 1.333 times as wide "
                   "as high), principal point"));
  EXPECT_FALSE(nlohmann::json::parse(SummaryJson(summary))["intrinsics"].contains("pixel_aspect_sigma"));
  summary.drive.given.found_camera->camera.aspect_sigma = 0.012;
  EXPECT_TRUE(Says(summary, "pixels are 1.333 +-0.016 times as wide as high)"));
  EXPECT_NEAR(nlohmann::json::parse(SummaryJson(summary))["intrinsics"]["pixel_aspect_sigma"], 0.012, 1e-9);
}

TEST(SummaryText, AContradictedRotationIsShownWithWhatIsUsed) {
  RunSummary summary = InMetres(0.03);
  summary.drive.vehicle.camera_known = true;
  EXPECT_TRUE(Says(summary, "roll +0.00 deg, as given\n"));
  EXPECT_FALSE(nlohmann::json::parse(SummaryJson(summary))["camera_rotation"].contains("contradicting_yaw_deg"));
  summary.car.contradicting_yaw = 2 / kDegreesPerRadian;
  EXPECT_TRUE(Says(summary, "as given; the drive shows yaw +2.00 deg, which is used"));
  EXPECT_NEAR(nlohmann::json::parse(SummaryJson(summary))["camera_rotation"]["contradicting_yaw_deg"], 2, 1e-9);
  // With --vehicle, whose rotation the drive would refine.
  summary.drive.mount.estimate = MountEstimate{};
  const nlohmann::json rotation = nlohmann::json::parse(SummaryJson(summary))["camera_rotation"];
  EXPECT_EQ(rotation["source"], "given");
  EXPECT_NEAR(rotation["contradicting_yaw_deg"], 2, 1e-9);
}

TEST(SummaryText, AnEstimatedHeightIsToBeCompared) {
  RunSummary summary = InMetres(0.03);
  summary.car.refined = CarRefinement();
  summary.car.refined->camera_height = 1.5;
  summary.car.refined->camera_height_sigma = 0.06;
  EXPECT_TRUE(Says(summary, "height  camera 1.500 +-0.060 m above the road (compare with a tape measure)\n"));
  summary.drive.vehicle.camera_height = 1.48;
  EXPECT_TRUE(Says(summary, "height  camera 1.500 m above the road, as given\n")) << "no turn says anything of it";
  summary.scale.turns_used = 1;
  EXPECT_TRUE(Says(summary, "height  camera 1.500 +-0.060 m above the road\n"));
}

TEST(SummaryText, ANegativeSlipIsDoubtfulUnlessNoneWasAssumed) {
  RunSummary summary = InMetres(0.03);
  summary.scale.turns_used = 1;
  summary.car.refined = CarRefinement();
  summary.car.refined->side_slip_at_bound = true;
  EXPECT_TRUE(Says(summary, "would be negative: check lever arm"));
  summary.drive.vehicle.side_slip = 0;
  EXPECT_TRUE(Says(summary, "would be negative\n"));
  EXPECT_FALSE(Says(summary, "check lever arm"));
}

TEST(SummaryText, ASlipThatTheDriveDoesNotRefineIsCalledSo) {
  RunSummary summary = InMetres(0.03);
  summary.scale.turns_used = 1;
  summary.car.refined = CarRefinement();
  summary.car.refined->side_slip = 0.00451;
  summary.car.refined->side_slip_sigma = 0.00199;
  EXPECT_TRUE(Says(summary, "side slip 0.0045 +-0.0020 s^2/m, the default, not refined by the drive\n"));
  summary.drive.vehicle.side_slip = 0.006;
  summary.drive.vehicle.side_slip_sigma = 0.0007;
  EXPECT_TRUE(Says(summary, "side slip 0.0045 +-0.0020 s^2/m, refined from the given 0.0060 +-0.0007 s^2/m\n"));
  summary.car.refined->side_slip = 0.006;
  summary.car.refined->side_slip_sigma = summary.drive.vehicle.side_slip_sigma = 0;
  EXPECT_TRUE(Says(summary, "side slip 0.0060 s^2/m, as given, not refined by the drive\n"));
}

TEST(SummaryText, TheYawIsShownWithItsCorrection) {
  RunSummary summary = InMetres(0.03);
  summary.drive.vehicle.camera_known = true;
  summary.drive.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({1 / kDegreesPerRadian, 0, 0});
  summary.scale.turns_used = 1;
  summary.car.refined = CarRefinement();
  summary.car.refined->yaw_error = 0.25 / kDegreesPerRadian;
  summary.car.refined->yaw_error_sigma = 0.1 / kDegreesPerRadian;
  EXPECT_TRUE(Says(summary, "roll +0.00 deg, as given\n")) << "nor does car.yaml have it where it is not reliable";
  summary.car.evidence.emplace();
  EXPECT_TRUE(Says(summary,
                   "yaw +1.00, pitch +0.00, roll +0.00 deg, as given; the scale estimate corrects the yaw to "
                   "+1.25 +-0.10 deg (by +0.25)\n"));
  summary.car.refined->yaw_error = -1.003 / kDegreesPerRadian;
  EXPECT_TRUE(Says(summary, "corrects the yaw to +0.00 +-0.10 deg (by -1.00)\n")) << "not -0.00";
  summary.car.refined->yaw_error = -0.004 / kDegreesPerRadian;
  EXPECT_TRUE(Says(summary, "roll +0.00 deg, as given\n")) << "rounded to nothing";
  summary.car.contradicting_yaw = 1.25 / kDegreesPerRadian;
  EXPECT_TRUE(Says(summary, "as given; the drive shows yaw +1.25 deg, which is used\n"));
}

TEST(SummaryText, TimesCountFromTheFirstFrame) {
  RunSummary summary = InMetres(0.03);
  summary.scale.worst_sigma = 0.05;
  summary.scale.worst_sigma_time = 1774160057.4;
  summary.path.missing = {{MissingReason::kLost, 1774160050.5, 1774160052.0, 15}};
  summary.drive.given.first_time = 1774160045.0;
  EXPECT_TRUE(Says(summary, "at most +-5.0 % (at 12.4 s)\n"));
  EXPECT_TRUE(Says(summary, "tracking lost from 5.5 s to 7.0 s (15 frames)\n"));
}

TEST(SummaryText, KnocksOfTheCameraAreListedWithTheirTime) {
  const auto knocks = [](const RunSummary& summary) {
    return nlohmann::json::parse(SummaryJson(summary))["camera_rotation"]["knocks"];
  };
  RunSummary summary = InMetres(0.03);
  EXPECT_EQ(knocks(summary), nlohmann::json::array());
  summary.drive.mount.jumps = {{.first_frame = 125, .time = 1774160057.5, .yaw = -2.04 / kDegreesPerRadian}};
  EXPECT_EQ(knocks(summary)[0]["frame"], 125);
  EXPECT_EQ(knocks(summary)[0]["time_s"], 1774160057.5);
  EXPECT_NEAR(knocks(summary)[0]["yaw_deg"].get<double>(), -2.04, 1e-9);
  EXPECT_TRUE(Says(summary, "turned by a knock once"));
  EXPECT_EQ(CameraJumpText(summary.drive.mount.jumps[0], 1774160045.0),
            "frame 125 (at 12.5 s): the camera was turned on the car by 2.0 degrees to the left, as by a knock");
}

TEST(SummaryText, MovesOfTheCameraAreListedWithTheirTime) {
  const auto moves = [](const RunSummary& summary) {
    return nlohmann::json::parse(SummaryJson(summary))["camera_rotation"]["moves"];
  };
  RunSummary summary = InMetres(0.03);
  summary.drive.given.first_time = 1774160045.0;
  summary.drive.mount.estimate.emplace();
  summary.drive.mount.estimate->found = true;
  EXPECT_EQ(moves(summary), nlohmann::json::array());
  summary.drive.mount.estimate->moves = {{1774160057.4, {2.04 / kDegreesPerRadian, -3 / kDegreesPerRadian, 0}}};
  EXPECT_EQ(moves(summary)[0]["time_s"], 1774160057.4);
  EXPECT_NEAR(moves(summary)[0]["yaw_deg"].get<double>(), 2.04, 1e-9);
  EXPECT_NEAR(moves(summary)[0]["pitch_deg"].get<double>(), -3, 1e-9);
  EXPECT_TRUE(Says(summary, "moved once by about 2.0 degrees to the right and 3.0 degrees down at 12 s"));
  summary.drive.mount.estimate->moves.push_back({1774160075.0, {0.1 / kDegreesPerRadian, 1.5 / kDegreesPerRadian, 0}});
  EXPECT_TRUE(Says(summary, "moved 2 times, the last time by about 1.5 degrees up at 30 s"));
}

TEST(SummaryText, FramesWithoutAMeasuredPoseAreNamedByTheirState) {
  RunSummary summary = InMetres(0.03);
  EXPECT_FALSE(Says(summary, "frames  "));
  summary.frames.initializing = 12;
  summary.frames.repeated = 3;
  EXPECT_TRUE(Says(summary, "frames  without a measured pose: 12 before initialisation, 3 repeated\n"));
}

TEST(SummaryText, ImagesUpsideDownAreNamedAloneIfTheyContradictTheCalibration) {
  RefinedScale scale;
  scale.contradicted_calibration.resize(1);
  DriveFacts drive;
  drive.images.is_upside_down = true;
  drive.given.rotate = 180;
  RunSummary summary = SummaryOf(drive, {}, scale);
  ASSERT_EQ(summary.warnings.size(), 1U);
  EXPECT_NE(summary.warnings[0].find("upside down"), std::string::npos) << summary.warnings[0];
  summary.scale.calibration_windows = 3;
  summary.scale.calibration_agrees = false;
  summary.drive.given.camera = "calib.txt";
  const std::string text = SummaryText(summary);
  EXPECT_EQ(text.find("contradicted"), std::string::npos) << text;
  EXPECT_NE(text.find("calib.txt, not tested, as the images seem to be upside down"), std::string::npos) << text;
}

TEST(SummaryJson, HasTheStabilisationOfTheImages) {
  RunSummary summary;
  const auto stabilisation = [&] { return nlohmann::json::parse(SummaryJson(summary))["image_stabilisation"]; };
  EXPECT_TRUE(stabilisation().is_null());
  summary.scale.image_smoothing = ImageSmoothing{.variance = 0.25};
  EXPECT_EQ(stabilisation(), (nlohmann::json{{"smoothing_s", 0.5}}));
  summary.scale.image_lag = ImageLag{.found = -0.125, .found_sigma = 0.03125};
  EXPECT_EQ(stabilisation(), (nlohmann::json{{"lag_s", -0.125},
                                             {"lag_sigma_s", 0.03125},
                                             {"lag_used", true},
                                             {"lag_confirmed", true},
                                             {"smoothing_s", 0.5}}));
}

TEST(SummaryText, CountsAndMeasures) {
  std::vector<FrameResult> frames = PathFrames(5, 2);
  frames[1].state = TrackingState::kBridged;
  frames[2].state = TrackingState::kRepeated;
  frames[4].keyframe = true;
  frames[4].scale_sigma = 0.02;
  TurnResult used;
  used.used = true;
  RefinedScale scale = HeldScale();
  scale.turns = {used, {}};
  RunSummary summary = SummaryOf({}, frames, scale);
  summary.drive.images.unreadable.push_back({2, "x.png: is truncated"});
  const auto json = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_EQ(json["frames"]["total"], 5);
  EXPECT_EQ(json["frames"]["tracked"], 3);
  EXPECT_EQ(json["frames"]["repeated"], 1);
  EXPECT_EQ(json["frames"]["bridged"], 1);
  EXPECT_EQ(json["frames"]["keyframes"], 1);
  EXPECT_EQ(json["frames"]["unreadable"], 1);
  EXPECT_EQ(json["unreadable"][0]["problem"], "x.png: is truncated");
  EXPECT_NEAR(json["distance_m"].get<double>(), 8, 1e-12);
  EXPECT_TRUE(json["distance_units"].is_null());
  EXPECT_EQ(json["turns"]["found"], 2);
  EXPECT_EQ(json["turns"]["used"], 1);
  EXPECT_EQ(json["scale"]["state"], "held");
  EXPECT_TRUE(json["lens"].is_null()) << "not looked for";
  summary.drive.camera.correction = {-0.015, 0.002};
  const auto with_lens = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_EQ(with_lens["lens"]["correction"], -0.015);
  EXPECT_EQ(with_lens["lens"]["sigma"], 0.002);
  EXPECT_TRUE(json["by_all_turns"].is_null());
  summary.car.refined = {0.002, 0.001, 0.0041, 0.0003, false};
  summary.car.evidence.emplace();
  const auto with_car = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_EQ(with_car["by_all_turns"]["side_slip_s2_per_m"], 0.0041);
  EXPECT_NE(
      SummaryText(summary).find("side slip 0.0041 +-0.0003 s^2/m, refined from the default 0.0045 +-0.0020 s^2/m\n"),
      std::string::npos);
  EXPECT_NE(SummaryText(summary).find("; the scale estimate corrects the yaw to +"), std::string::npos);
  EXPECT_NE(SummaryText(summary).find(" +-0.06 deg (by +0.11)\n"), std::string::npos);
  summary.car.refined = {0.002, 0.001, 0, 1e-9, true};
  EXPECT_NE(SummaryText(summary).find("side slip 0, since the estimate would be negative"), std::string::npos);
  EXPECT_TRUE(json["complete"].get<bool>());
  EXPECT_NE(SummaryText(summary).find("8.00 m in "), std::string::npos);
}

TEST(SummaryText, UpToScaleSaysSo) {
  const RunSummary summary = SummaryOf({}, PathFrames(3, 1), {});
  EXPECT_NE(
      SummaryText(summary).find("without --lever-arm, --camera-height or --vehicle the trajectory is up to scale"),
      std::string::npos);
  const auto json = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_TRUE(json["distance_m"].is_null());
  EXPECT_EQ(json["scale"]["known"], false);
  EXPECT_TRUE(json["scale"]["worst_relative_sigma"].is_null());
  EXPECT_TRUE(json["path_sigma"].is_null());
  EXPECT_TRUE(json["warnings"].empty());
}

TEST(SummaryText, SaysHowWellTheLengthIsKnownAndWhereLeast) {
  std::vector<FrameResult> frames = PathFrames(5, 1);
  for (FrameResult& frame : frames) frame.scale_sigma = 0.02;
  frames[3].scale_sigma = 0.09;
  RefinedScale scale = HeldScale();
  scale.estimate.emplace().converged = true;
  scale.estimate->length_sigma = 0.034;
  const RunSummary summary = SummaryOf({}, frames, scale);
  const auto json = nlohmann::json::parse(SummaryJson(summary));
  EXPECT_EQ(json["path_sigma"], 0.034);
  EXPECT_EQ(json["scale"]["worst_relative_sigma"], 0.09);
  EXPECT_NEAR(json["scale"]["worst_at_s"].get<double>(), 0.3, 1e-12);
  EXPECT_TRUE(json["warnings"].empty());
  EXPECT_NE(SummaryText(summary).find("path length +-3.4 % (1 sigma), along the drive at most +-9.0 % (at 0.3 s)"),
            std::string::npos)
      << SummaryText(summary);
}

TEST(SummaryText, TheSigmaOfTheLengthMayExceedThatOfTheScale) {
  RunSummary summary = InMetres(0.03);
  summary.scale.worst_sigma = 0.04;
  summary.scale.path_sigma = 0.041;
  EXPECT_TRUE(Says(summary, "path length +-4.1 % (1 sigma), by the scale alone at most +-4.0 % (at 0.0 s)\n"));
  summary.scale.path_sigma = 0.08;
  EXPECT_TRUE(
      Says(summary,
           "path length +-8.0 % (1 sigma) including the parts that warnings name, by the scale alone at most +-4.0 % "
           "(at 0.0 s)\n"));
  summary.scale.path_sigma = 0.0401;
  EXPECT_TRUE(Says(summary, "path length +-4.0 % (1 sigma), along the drive at most +-4.0 % (at 0.0 s)\n"));
}

TEST(SummaryText, SaysHowMuchOfThePathIsNotMeasured) {
  std::vector<FrameResult> frames = PathFrames(4, 1);
  // A minute that is not recorded.
  for (FrameResult& frame : frames) frame.time += frame.frame >= 2 ? 60 : 0;
  frames[2].world_from_camera->translation.z() += 100;
  frames[3].world_from_camera->translation.z() += 100;
  const RunSummary summary = SummaryOf({}, frames, HeldScale());
  EXPECT_NE(SummaryText(summary).find(
                "path    103.00 m in 60.3 s (6 km/h on average), 4 frames, 0 keyframes; 101.00 m of it not measured\n"),
            std::string::npos)
      << SummaryText(summary);
  EXPECT_EQ(nlohmann::json::parse(SummaryJson(summary))["missing"]["distance_m"], 101);
}

TEST(SummaryText, CountsTheAdjustmentsThatFailed) {
  RunSummary summary;
  summary.drive.failed_adjustments = 2;
  EXPECT_EQ(nlohmann::json::parse(SummaryJson(summary))["failed_adjustments"], 2);
}

TEST(SummaryText, SaysWhichCameraRotationIsUsed) {
  RunSummary summary;
  summary.drive.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({3 / kDegreesPerRadian, 0, 0});
  EXPECT_NE(SummaryText(summary).find("camera  yaw +3.00, pitch +0.00, roll +0.00 deg, as given\n"), std::string::npos);
  summary.drive.mount.estimate = MountEstimate{};
  EXPECT_NE(SummaryText(summary).find("camera  yaw +0.00, pitch +0.00, roll +0.00 deg, assumed; no turn"),
            std::string::npos);
}

TEST(SummaryText, WithoutATurnNothingIsSaidToBeFromTurns) {
  RunSummary summary;
  summary.car.refined = CarRefinement{};
  summary.car.refined->camera_height = 1.3;
  summary.car.refined->yaw_error = 0.01;
  summary.car.evidence.emplace();
  EXPECT_EQ(SummaryText(summary).find("corrects the yaw"), std::string::npos);
  EXPECT_EQ(SummaryText(summary).find("side slip"), std::string::npos);
  EXPECT_NE(SummaryText(summary).find("height  camera 1.300"), std::string::npos);
  summary.scale.turns_used = 1;
  EXPECT_NE(SummaryText(summary).find("corrects the yaw"), std::string::npos);
  EXPECT_NE(SummaryText(summary).find("side slip"), std::string::npos);
}

}  // namespace
}  // namespace turnscale

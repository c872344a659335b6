// SPDX-License-Identifier: MIT
#include "turnscale/run/turn_warning.h"

#include <gtest/gtest.h>

#include "turnscale/geometry/angle.h"

namespace turnscale {
namespace {

std::string Warning(const ScaleEstimate& estimate) {
  return TurnWarning(
      estimate, [](int turn) { return "turn " + std::to_string(turn); }, "the lever arm");
}

ScaleEstimate Fallback() {
  ScaleEstimate estimate;
  estimate.uses_single_turns = true;
  estimate.converged = true;
  return estimate;
}

TEST(TurnWarning, IsEmptyUnlessTheTurnsAreTheReason) {
  EXPECT_EQ(Warning(Fallback()), "") << "single-turn scales by choice";
  ScaleEstimate smoothed;
  smoothed.converged = true;
  EXPECT_EQ(Warning(smoothed), "");
}

TEST(TurnWarning, NamesTheTurnThatDeviatesMost) {
  ScaleEstimate estimate = Fallback();
  estimate.test.contradicted = true;
  estimate.test.disagreement = 0.12;
  estimate.test.worst_turn = 3;
  EXPECT_EQ(Warning(estimate),
            "the turns disagree on the scale by 12 % on average, most at turn 3; the trajectory uses the scale of each "
            "turn instead of the joint estimate: check the lever arm");
}

TEST(SlipWarning, GivesWhatWasFoundAndExpected) {
  EXPECT_EQ(SlipWarning({0.0045, 0.002, 0.0104}),
            "the turns show a side slip of 0.0104 s^2/m, far from the expected 0.0045 +-0.0020: check the times of the "
            "images and the lever arm, as errors of both act like slip");
  EXPECT_TRUE(SlipWarning({0, 0.002, 0.0058}).ends_with(", and leave out --side-slip 0"));
}

TEST(HeightWarning, GivesBothLengthsAsTheOtherOneImpliesThem) {
  EXPECT_EQ(HeightWarning({1.3, 0.013, 1.62, 0.08}, 0.95, "measure both again"),
            "lever arm and camera height disagree by 20 %: with the lever arm 0.95 m the turns give a height of 1.62 "
            "+-0.08 m, not 1.30 m; the given height implies a lever arm of 0.76 m: measure both again");
  EXPECT_TRUE(HeightWarning({1.3, 0.013, 1.62, 0.08, true}, 0.95, "measure both again")
                  .ends_with("0.76 m; the trajectory uses the lever arm alone: measure both again"));
}

TEST(YawWarning, SaysToWhichSide) {
  EXPECT_EQ(YawWarning({0.3 / kDegreesPerRadian, 0.1 / kDegreesPerRadian, 0.12 / kDegreesPerRadian}, "look"),
            "the turns of the drive show another camera yaw than its straights: check the calibration, the times of "
            "the images and whether the camera is loose");
  EXPECT_EQ(YawWarning({0.3 / kDegreesPerRadian, -2.7 / kDegreesPerRadian, 0.12 / kDegreesPerRadian}, "look"),
            "the drive gives a camera yaw 2.7 +-0.1 deg further left than the camera-to-vehicle rotation, whose "
            "sigma is 0.3 deg; the trajectory uses the yaw from the drive: look");
}

TEST(StabilisationWarning, SaysHowTheImagesMove) {
  ScaleEstimate estimate;
  EXPECT_FALSE(estimate.is_stabilised());
  estimate.image_smoothing = ImageSmoothing{.variance = 0.25, .variance_sigma = 0.02, .scale_error = 0.08};
  const std::string advice =
      " the scale may be off by 8 % or more; record without image stabilisation, or give the measured height of the "
      "camera instead of the lever arm";
  EXPECT_EQ(
      StabilisationWarning(estimate),
      "the images seem to be stabilised: they begin to turn before the car does, and turn on after it, by which, or "
      "by a lag that the turns do not show," +
          advice);
  estimate.image_lag = ImageLag{.found = 0.15, .found_sigma = 0.03};
  EXPECT_EQ(
      StabilisationWarning(estimate),
      "the images seem to be stabilised: in turns their orientation lags behind the car's by 0.15 +-0.03 s, for "
      "which the scale allows, with a larger sigma; they begin to turn before the car does, and turn on after it, "
      "by which" +
          advice);
  estimate.image_lag->scale_error = 0.3;
  EXPECT_NE(StabilisationWarning(estimate).find(
                "for which the scale allows (+-30 %, as a principal point that is a little off looks the same); "),
            std::string::npos);
  estimate.image_lag->is_used = false;
  EXPECT_NE(StabilisationWarning(estimate).find(
                "the principal point of the calibration may be a little off, or the images stabilised: either explains "
                "what the turns show, and the sigma of the scale allows for both (+-30 %); have the calibration "
                "estimated by --camera-refine, record without"),
            std::string::npos);
  estimate.image_lag->is_used = true;
  estimate.image_lag->found = -0.1;
  EXPECT_NE(StabilisationWarning(estimate).find("is ahead of the car's by 0.10"), std::string::npos);
}

TEST(TurnWarning, TellsThatTheEstimateDidNotConverge) {
  ScaleEstimate estimate = Fallback();
  estimate.converged = false;
  EXPECT_EQ(Warning(estimate),
            "the scale estimate did not converge; the trajectory uses the scale of each turn instead of the joint "
            "estimate: check the lever arm");
  estimate.uses_single_turns = false;
  EXPECT_EQ(Warning(estimate), "the scale estimate did not converge: check the lever arm") << "no turn to go by";
}

}  // namespace
}  // namespace turnscale

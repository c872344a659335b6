// SPDX-License-Identifier: MIT
#include "turnscale/run/image_warnings.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

constexpr auto kBlendingError = "the scale may be wrong";
constexpr auto kCalibrationError = "the scale may be off by 4 % or more";

std::vector<std::string> Warnings(const ImageFindings& findings) {
  return ImageWarnings(findings, 100, kBlendingError, kCalibrationError);
}

ImageFindings Contradicted() {
  ImageFindings findings;
  findings.contradicted_calibration = {
      {.parameter = IntrinsicsParameter::kFocalLength, .given = 700, .found = 650, .sigma = 5},
      {.parameter = IntrinsicsParameter::kDistortion, .given = 0, .found = -0.2, .sigma = 0.01}};
  return findings;
}

TEST(ImageWarnings, NoneWhereNothingIsFound) { EXPECT_TRUE(Warnings({}).empty()); }

TEST(ImageWarnings, AnotherReadoutIsNoOtherCamera) {
  RefinedScale scale;
  EXPECT_EQ(ContradictedReadoutText(scale), "");
  scale.contradicted_readout = ParameterEstimate{IntrinsicsParameter::kReadout, 0.03, 0.0194, 0.0011};
  scale.readout = ShutterReadout{0.0194, 0.0011};
  EXPECT_EQ(ContradictedReadoutText(scale),
            "the turns give a readout time of 19.4 +-1.1 ms, but the camera file has 30.0; that of the turns is used");
  scale.readout.reset();
  EXPECT_TRUE(ContradictedReadoutText(scale).ends_with("the images are taken to have none"));
}

TEST(ImageWarnings, OneLineSaysWhatContradictsTheCalibrationAndWhatFollows) {
  ImageFindings findings = Contradicted();
  std::vector<std::string> warnings = Warnings(findings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(
      warnings[0],
      "the images taken in turns give a focal length of 650 +-5 pixels, but the calibration has 700, and a "
      "distortion other than the calibration's (a radial correction of -0.2000 +-0.01): check that the calibration "
      "belongs to this camera, or have it estimated with --camera-refine; " +
          std::string(kCalibrationError));
  EXPECT_TRUE(ImageWarnings(findings, 0, "", "")[0].ends_with("--camera-refine"));

  findings.consequences = {"the turns disagree", "the height is unusual", "the sky is green"};
  EXPECT_TRUE(Warnings(findings)[0].ends_with(
      "; this may also be why the turns disagree, the height is unusual and the sky is green"));
  findings.consequences.clear();
  findings.is_calibration_refined = true;
  warnings = Warnings(findings);
  EXPECT_NE(warnings[0].find("check that the calibration belongs to this camera; the scale"), std::string::npos)
      << warnings[0];
}

TEST(ImageWarnings, ADoubtIsSaidWhereNothingIsContradicted) {
  ImageFindings findings;
  findings.doubtful_calibration = {
      {.parameter = IntrinsicsParameter::kFocalLength, .given = 300, .found = 520, .sigma = 100}};
  EXPECT_TRUE(
      Warnings(findings)[0].starts_with("the images taken in turns suggest a focal length of 520 +-1e+02 pixels, but "
                                        "the calibration has 300: check that"))
      << Warnings(findings)[0];
  findings.contradicted_calibration = Contradicted().contradicted_calibration;
  EXPECT_EQ(Warnings(findings), Warnings(Contradicted()));
}

TEST(ImageWarnings, ADistortionThatFollowsFromTheFocalLengthIsNotNamed) {
  ImageFindings findings = Contradicted();
  findings.has_distortion = false;
  ParameterEstimate& distortion = findings.contradicted_calibration[1];
  EXPECT_NE(Warnings(findings)[0].find("and a distortion, but the calibration has none (a radial"), std::string::npos);
  distortion = {.parameter = IntrinsicsParameter::kDistortion, .given = -0.0289, .found = 0.004, .sigma = 0.004};
  EXPECT_EQ(Warnings(findings)[0].find("distortion"), std::string::npos) << Warnings(findings)[0];
  distortion.found = -0.02;
  distortion.sigma = 0.002;
  EXPECT_EQ(Warnings(findings)[0].find("distortion"), std::string::npos) << "7 % of the focal length leave that much";
  distortion.found = 0.004;
  distortion.sigma = 0.004;
  findings.contradicted_calibration.erase(findings.contradicted_calibration.begin());
  EXPECT_NE(Warnings(findings)[0].find("(a radial correction of 0.0040 +-0.004; -0.0289 is applied)"),
            std::string::npos)
      << "alone, nothing else explains it";
}

TEST(ImageWarnings, PixelsMayHaveAnotherShape) {
  ImageFindings findings;
  findings.contradicted_calibration = {
      {.parameter = IntrinsicsParameter::kPixelAspect, .given = 1, .found = 1.25, .sigma = 0.06}};
  const std::vector<std::string> warnings = Warnings(findings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(
      warnings[0].starts_with("the images taken in turns give pixels 1.25 +-0.06 times as wide as high, but the "
                              "calibration has 1 (fy / fx): "))
      << warnings[0];
}

TEST(ImageWarnings, BlendingComesBeforeTheCalibrationThatItMayContradict) {
  ImageFindings findings = Contradicted();
  findings.blending = FrameBlending{.from = 101, .to = 120, .period = 4};
  const std::vector<std::string> warnings = Warnings(findings);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_NE(warnings[0].find("from 1.0 to 20.0 s"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[0].find(kBlendingError), std::string::npos) << warnings[0];
  EXPECT_TRUE(warnings[1].ends_with(std::string(kCalibrationError) + "; the blending may be the cause")) << warnings[1];
}

TEST(ImageWarnings, ImagesUpsideDownExplainAContradictedCalibration) {
  ImageFindings findings = Contradicted();
  findings.is_upside_down = true;
  const auto says = [&findings](int rotated, const char* advice) {
    findings.rotated = rotated;
    const std::vector<std::string> warnings = Warnings(findings);
    return warnings.size() == 1 && warnings[0].find(advice) != std::string::npos;
  };
  EXPECT_TRUE(says(0, "rotate them (--rotate 180)"));
  EXPECT_TRUE(says(90, "give --rotate 270 rather than 90"));
  EXPECT_TRUE(says(180, "leave out --rotate 180"));
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/run/image_warnings.h"

#include <fmt/format.h>

#include "turnscale/run/missing_path.h"

namespace turnscale {
namespace {

// Where the images of turns contradict the calibration.
std::string ContradictionText(const ParameterEstimate& estimate, bool refined) {
  const std::string remedy = refined ? "" : ", or have it estimated with --camera-refine";
  if (estimate.parameter == IntrinsicsParameter::kDistortion)
    return fmt::format(
        "the images taken in turns give a distortion other than the calibration's: a radial correction of {:.4f} "
        "+-{:.2g}, where {:.4f} is applied: check that the calibration belongs to this camera{}",
        estimate.found, estimate.sigma, estimate.given, remedy);
  if (estimate.parameter == IntrinsicsParameter::kPixelAspect)
    return fmt::format(
        "the images taken in turns give pixels {:.3g} +-{:.2g} times as wide as high, but the calibration has {:.3g} "
        "(fy / fx): check whether the video was squeezed or stretched{}",
        estimate.found, estimate.sigma, estimate.given, remedy);
  const bool is_focal = estimate.parameter == IntrinsicsParameter::kFocalLength;
  const bool is_x = estimate.parameter == IntrinsicsParameter::kCentreX;
  const char* name = is_focal ? "focal length" : is_x ? "horizontal principal point" : "vertical principal point";
  return fmt::format(
      "the images taken in turns give a {} of {:.4g} +-{:.2g} pixels, but the calibration has {:.4g}: check that the "
      "calibration belongs to this camera{}",
      name, estimate.found, estimate.sigma, estimate.given, remedy);
}

std::string UpsideDownText(int rotated) {
  return "the images seem to be upside down, as the road is above the camera in them: left and right are exchanged in "
         "the path; " +
         RotationAdvice(rotated, 180);
}

}  // namespace

std::vector<std::string> ImageWarnings(const ImageFindings& findings, double first_time,
                                       const std::string& blending_error, const std::string& calibration_error) {
  std::vector<std::string> warnings;
  const std::optional<FrameBlending>& blending = findings.blending;
  if (findings.is_upside_down) warnings.push_back(UpsideDownText(findings.rotated));
  if (blending) warnings.push_back(FrameBlendingText(SinceFirst(*blending, first_time), blending_error));
  // Both make images contradict a right calibration, too.
  if (findings.is_upside_down || findings.contradicted_calibration.empty()) return warnings;
  for (const ParameterEstimate& estimate : findings.contradicted_calibration)
    warnings.push_back(ContradictionText(estimate, findings.is_calibration_refined));
  if (!calibration_error.empty()) warnings.back() += "; " + calibration_error;
  if (blending) warnings.back() += "; the blending may be the cause";
  return warnings;
}

std::string RotationAdvice(int rotated, int more) {
  const int right = (rotated + more) % 360;
  if (right == 0) return fmt::format("leave out --rotate {}", rotated);
  return rotated == 0 ? fmt::format("rotate them (--rotate {})", right)
                      : fmt::format("give --rotate {} rather than {}", right, rotated);
}

}  // namespace turnscale

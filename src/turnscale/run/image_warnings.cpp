// SPDX-License-Identifier: MIT
#include "turnscale/run/image_warnings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

#include "turnscale/run/missing_path.h"

namespace turnscale {
namespace {

// What the images of turns give instead of the calibration.
std::string FoundText(const ParameterEstimate& estimate, bool has_distortion) {
  if (estimate.parameter == IntrinsicsParameter::kDistortion) {
    constexpr double kShown = 0.5e-4;
    const std::string applied =
        std::abs(estimate.given) > kShown ? fmt::format("; {:.4f} is applied", estimate.given) : std::string();
    return fmt::format(
        "{} (a radial correction of {:.4f} +-{:.2g}{})",
        has_distortion ? "a distortion other than the calibration's" : "a distortion, but the calibration has none",
        estimate.found, estimate.sigma, applied);
  }
  if (estimate.parameter == IntrinsicsParameter::kPixelAspect)
    return fmt::format("pixels {:.3g} +-{:.2g} times as wide as high, but the calibration has {:.3g} (fy / fx)",
                       estimate.found, estimate.sigma, estimate.given);
  const bool is_focal = estimate.parameter == IntrinsicsParameter::kFocalLength;
  const bool is_x = estimate.parameter == IntrinsicsParameter::kCentreX;
  const char* name = is_focal ? "focal length" : is_x ? "horizontal principal point" : "vertical principal point";
  return fmt::format("a {} of {:.4g} +-{:.2g} pixels, but the calibration has {:.4g}", name, estimate.found,
                     estimate.sigma, estimate.given);
}

// With a wrong focal length, the correction of the distortion that is estimated during the drive is wrong, too: then
// the images contradict the correction, and not the distortion that the calibration has. Of a large error of the focal
// length, the linear model leaves a part in the distortion.
bool FollowsFromFocalLength(const ParameterEstimate& estimate, const std::vector<ParameterEstimate>& all) {
  constexpr double kSignificance = 3;
  constexpr double kLeast = 0.01;
  constexpr double kShareOfError = 0.3;
  if (estimate.parameter != IntrinsicsParameter::kDistortion) return false;
  const auto focal = std::ranges::find(all, IntrinsicsParameter::kFocalLength, &ParameterEstimate::parameter);
  if (focal == all.end()) return false;
  const double focal_error = std::abs(focal->found / focal->given - 1);
  return std::abs(estimate.found) < std::max({kLeast, kSignificance * estimate.sigma, kShareOfError * focal_error});
}

// "a", "a and b", "a, b and c".
std::string Listed(const std::vector<std::string>& parts) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i == 0 ? "" : i + 1 == parts.size() ? " and " : ", ") + parts[i];
  return text;
}

// Where the images of turns contradict the calibration, or leave it in doubt. One line, as all of it has one remedy.
std::string ContradictionText(const ImageFindings& findings) {
  const bool is_in_doubt = findings.contradicted_calibration.empty();
  const std::vector<ParameterEstimate>& estimates =
      is_in_doubt ? findings.doubtful_calibration : findings.contradicted_calibration;
  std::string found;
  bool is_aspect = false;
  for (const ParameterEstimate& estimate : estimates) {
    if (FollowsFromFocalLength(estimate, estimates)) continue;
    found += (found.empty() ? "" : ", and ") + FoundText(estimate, findings.has_distortion);
    is_aspect = is_aspect || estimate.parameter == IntrinsicsParameter::kPixelAspect;
  }
  return fmt::format(
      "the images taken in turns {} {}: check {}{}", is_in_doubt ? "suggest" : "give", found,
      is_aspect ? "whether the video was squeezed or stretched" : "that the calibration belongs to this camera",
      findings.is_calibration_refined ? "" : ", or have it estimated with --camera-refine");
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
  const bool is_suspect = !findings.contradicted_calibration.empty() || !findings.doubtful_calibration.empty();
  if (findings.is_upside_down || !is_suspect) return warnings;
  warnings.push_back(ContradictionText(findings));
  if (!calibration_error.empty()) warnings.back() += "; " + calibration_error;
  if (!findings.consequences.empty()) warnings.back() += "; this may also be why " + Listed(findings.consequences);
  if (blending) warnings.back() += "; the blending may be the cause";
  return warnings;
}

std::string ContradictedReadoutText(const RefinedScale& scale) {
  if (!scale.contradicted_readout) return "";
  const auto& [parameter, given, found, sigma] = *scale.contradicted_readout;
  return fmt::format("the turns give a readout time of {:.1f} +-{:.2g} ms, but the camera file has {:.1f}; {}",
                     1e3 * found, 1e3 * sigma, 1e3 * given,
                     scale.readout ? "that of the turns is used" : "the images are taken to have none");
}

std::string RotationAdvice(int rotated, int more) {
  const int right = (rotated + more) % 360;
  if (right == 0) return fmt::format("leave out --rotate {}", rotated);
  return rotated == 0 ? fmt::format("rotate them (--rotate {})", right)
                      : fmt::format("give --rotate {} rather than {}", right, rotated);
}

}  // namespace turnscale

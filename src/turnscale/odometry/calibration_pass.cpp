// SPDX-License-Identifier: MIT
#include "turnscale/odometry/calibration_pass.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "turnscale/camera/lens_fit.h"
#include "turnscale/camera/ray_difference.h"

namespace turnscale {
namespace {

constexpr double kLooseAtFirst = 4.0;
constexpr double kTightening = 0.6;
// Farther apart, the last two passes have not found the same camera.
constexpr double kAlternatingSigmas = 2;
// Logs of aspects that differ by rounding alone.
constexpr double kSameAspect = 1e-9;

// The camera after a change of its intrinsics; its tangential distortion stays if the lens model has one. The change
// was read within a radius (pixels) of the principal point: beyond it, the series is an extrapolation.
std::optional<CameraModel> Changed(const CameraModel& camera, const IntrinsicsChange::Vector& change, double radius) {
  const Pinhole pinhole = ChangedPinhole(camera.pinhole, change);
  std::array<double, 2> tangential = {0, 0};
  if (camera.lens == LensModel::kRadialTangential) tangential = {camera.distortion[2], camera.distortion[3]};
  std::optional<CameraModel> changed = FitLens(
      pinhole, camera.width, camera.height,
      [&](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector2d> {
        const std::optional<CorrectedPixel> corrected = Correct(camera, change, pixel);
        if (!corrected) return std::nullopt;
        return pinhole.Ray(corrected->pixel).head<2>();
      },
      radius, tangential);
  if (!changed) return std::nullopt;
  changed->read_direction = camera.read_direction;
  changed->aspect_sigma = camera.aspect_sigma;
  changed->readout = camera.readout;
  changed->readout_sigma = camera.readout_sigma;
  return changed;
}

// Largest change of focal lengths and principal point, in standard deviations. An aspect of the pixels that goes back
// to the expected one has not been tried.
double LargestStep(const IntrinsicsEstimate& estimate) {
  const IntrinsicsChange::Vector& change = estimate.change;
  const IntrinsicsChange::Vector steps = change.cwiseQuotient(estimate.covariance.diagonal().cwiseSqrt()).cwiseAbs();
  const bool holds_aspect = estimate.Holds(IntrinsicsChange::kLogAspect);
  if (holds_aspect && std::abs(change[IntrinsicsChange::kLogAspect]) > kSameAspect) return HUGE_VAL;
  return std::max({steps[IntrinsicsChange::kLogFocal], holds_aspect ? 0.0 : steps[IntrinsicsChange::kLogAspect],
                   steps[IntrinsicsChange::kCentreX], steps[IntrinsicsChange::kCentreY]});
}

// Largest change of the ray of a pixel within a radius (pixels) of the principal point, in focal lengths.
double Difference(const CameraModel& camera, const CameraModel& other, double radius) {
  const auto largest = LargestRayDifference(camera, other, camera.width, camera.height, radius);
  return largest ? largest->distance : HUGE_VAL;
}

}  // namespace

double LooseBy(int pass) { return std::max(1.0, kLooseAtFirst * std::pow(kTightening, pass)); }

IntrinsicsChange::Vector ChangeBetween(const Pinhole& from, const Pinhole& to) {
  IntrinsicsChange::Vector change = IntrinsicsChange::Vector::Zero();
  change[IntrinsicsChange::kLogFocal] = std::log(to.fx / from.fx);
  change[IntrinsicsChange::kLogAspect] = std::log(to.fy / to.fx / (from.fy / from.fx));
  change[IntrinsicsChange::kCentreX] = to.cx - from.cx;
  change[IntrinsicsChange::kCentreY] = to.cy - from.cy;
  return change;
}

std::optional<CameraOfPasses> CameraFrom(const SelfCalibrationOptions& options, const CameraModel& camera,
                                         const PassFindings& findings, int passes) {
  const IntrinsicsChange::Vector& change = findings.estimate.change;
  const std::optional<CameraModel> next = Changed(camera, change, findings.radius);
  if (!next) return std::nullopt;
  const IntrinsicsChange::Vector sigmas = findings.estimate.covariance.diagonal().cwiseSqrt();
  const double step_sigmas = LargestStep(findings.estimate);
  // Observations that only wide thresholds let in bias the camera by a few tenths of a per cent: passes with such
  // thresholds are never the last.
  const bool is_strict = LooseBy(passes - 1) == 1;
  const bool settled = is_strict && (Difference(camera, *next, findings.radius) < options.converged ||
                                     step_sigmas < options.converged_sigmas);
  CameraOfPasses result{.found = {}, .next = *next, .is_last = settled || passes == options.max_passes};
  // Features are tracked a little differently with each lens, so that successive passes end up alternating about the
  // optimum: where windows are few, by as much as their sigmas.
  const bool alternates = settled || (result.is_last && passes > 1 && step_sigmas < kAlternatingSigmas);
  const std::optional<CameraModel> middle = alternates ? Changed(camera, 0.5 * change, findings.radius) : std::nullopt;
  FoundCamera& found = result.found;
  found.camera = middle.value_or(*next);
  const auto sigma_of = [&](IntrinsicsChange::Entry entry) { return std::hypot(sigmas[entry], 0.5 * change[entry]); };
  found.camera.focal_sigma = sigma_of(IntrinsicsChange::kLogFocal) * found.camera.pinhole.fx;
  // One that is held is that of the camera that the passes started with.
  if (!findings.estimate.Holds(IntrinsicsChange::kLogAspect))
    found.camera.aspect_sigma = sigma_of(IntrinsicsChange::kLogAspect);
  // The next pass is not to take it for known: it reads the same images.
  if (const std::optional<ShutterReadout>& readout = findings.readout) {
    found.camera.readout = readout->seconds;
    found.camera.readout_sigma = readout->sigma;
    found.camera.read_direction = readout->direction;
  }
  found.centre_sigma = sigma_of(IntrinsicsChange::kCentreX);
  found.windows = findings.windows;
  found.converged = alternates;
  return result;
}

}  // namespace turnscale

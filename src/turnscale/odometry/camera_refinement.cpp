// SPDX-License-Identifier: MIT
#include "turnscale/odometry/camera_refinement.h"

#include <cmath>
#include <utility>

#include "turnscale/mapping/shutter_readout.h"
#include "turnscale/odometry/refined_scale.h"

namespace turnscale {
namespace {

// A correction that moves the pixels at a wide image's edge by a fortieth of a pixel. Applying one takes up to 10 ms.
constexpr double kLeastLensChange = 5e-5;

// Keyframes that are added between the start of work and the use of its results. In a turn, where they are close to one
// another, it takes about as long as two of them.
constexpr int kKeyframesOfWork = 4;

}  // namespace

CameraRefinement::CameraRefinement(const OdometryOptions& options, const CameraModel& camera)
    : taken_{.lens = LensRefinement(options.lens),
             .check = CalibrationCheck(options.calibration_check, camera.pinhole, IntrinsicsChange::Vector::Zero(),
                                       ReadoutOf(camera)),
             .scale_sigma = CalibrationSigma({}, camera)} {}

void CameraRefinement::StartIfDue(const Map& map) {
  if (pending_.pending()) return;
  std::optional<IntrinsicsProblem> refined = taken_.lens.TakeWindow(map);
  std::optional<IntrinsicsProblem> tested = taken_.check.TakeWindow(map);
  if (!refined && !tested) return;
  pending_.Start(CountKeyframes(map) + kKeyframesOfWork, [findings = taken_, refined = std::move(refined),
                                                          tested = std::move(tested), camera = map.camera]() mutable {
    findings.lens_changed = refined && findings.lens.Read(*refined);
    // The test compares with the correction that the map is going to have.
    if (findings.lens_changed) camera.radial_correction = findings.lens.correction();
    if (tested) findings.check.Read(*tested);
    if (findings.check.windows() > 0)
      findings.scale_sigma =
          CalibrationSigma(findings.check.Contradictions(camera), findings.check.Doubts(camera), camera);
    return findings;
  });
}

std::optional<double> CameraRefinement::TakeIfDue(const Map& map) {
  std::optional<Findings> findings = pending_.TakeIfDue(CountKeyframes(map));
  if (!findings) return std::nullopt;
  taken_ = *std::move(findings);
  const double correction = taken_.lens.correction();
  const bool differs = std::abs(correction - map.camera.radial_correction) >= kLeastLensChange;
  return taken_.lens_changed && differs ? std::optional(correction) : std::nullopt;
}

const CameraRefinement::Findings& CameraRefinement::Latest() const {
  const Findings* pending = pending_.Await();
  return pending != nullptr ? *pending : taken_;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/run/run_summary.h"

#include <algorithm>
#include <utility>

#include "turnscale/base/number_text.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/run/run_warnings.h"

namespace turnscale {

RunSummary SummaryOf(DriveFacts drive, const std::vector<FrameResult>& frames, const RefinedScale& scale) {
  RunSummary summary;
  summary.drive = std::move(drive);
  const DriveFacts& known = summary.drive;
  summary.frames = FrameCountsOf(frames);
  // Results that could not be computed have no frames.
  summary.frames.total = std::max(summary.frames.total, known.processed);
  summary.path = PathSummaryOf(frames, known.repeated, known.seen, known.vehicle.lever_arm.value_or(0.0));
  summary.scale = ScaleSummaryOf(known, frames, scale, summary.path);
  summary.car = CarSummaryOf(known, scale);
  summary.warnings = RunWarnings(summary, frames, scale);
  return summary;
}

const char* LensModelName(LensModel lens) {
  switch (lens) {
    case LensModel::kPinhole:
      return "pinhole";
    case LensModel::kRadialTangential:
      return "radial-tangential";
    case LensModel::kEquidistant:
      return "equidistant";
  }
  return "unknown";
}

std::string FoundCameraText(const FoundCamera& found, const std::optional<ShutterReadout>& readout, bool is_tested) {
  CameraModel camera = found.camera;
  if (readout) {
    camera.readout = readout->seconds;
    camera.readout_sigma = readout->sigma;
    camera.read_direction = readout->direction;
  } else if (is_tested && camera.readout != 0) {
    camera.readout = camera.readout_sigma = 0;
  }
  return CameraFileText(camera) + "principal_point_sigma: " + NumberText(found.centre_sigma) + "\n";
}

}  // namespace turnscale

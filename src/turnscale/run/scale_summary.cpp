// SPDX-License-Identifier: MIT
#include "turnscale/run/scale_summary.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turnscale/run/impossible_direction.h"
#include "turnscale/run/impossible_motion.h"
#include "turnscale/run/missing_path.h"
#include "turnscale/run/sigma_reason.h"
#include "turnscale/scale/camera_height.h"

namespace turnscale {
namespace {

bool HasPose(const std::vector<FrameResult>& frames) {
  return std::ranges::any_of(frames, [](const FrameResult& frame) { return frame.world_from_camera.has_value(); });
}

void FindWorstSigma(const std::vector<FrameResult>& frames, ScaleSummary& summary) {
  summary.worst_sigma = HasPose(frames) ? 0 : INFINITY;
  for (const FrameResult& frame : frames) {
    if (!frame.world_from_camera || summary.worst_sigma >= frame.scale_sigma) continue;
    summary.worst_sigma = frame.scale_sigma;
    summary.worst_sigma_time = frame.time;
  }
}

// With what the path suggests of the error of its length.
void FindPathSigma(const RefinedScale& scale, const PathSummary& path, ScaleSummary& summary) {
  const double distance = std::max(path.distance, 1e-9);
  const double of_uncertain = path.uncertain ? path.uncertain->length_error() : 0;
  const double length_error =
      std::hypot(LengthErrorOf(path.impossible), LengthErrorOf(path.impossible_directions), of_uncertain);
  summary.sigma = std::hypot(LengthSigma(scale), length_error / distance);
  summary.path_sigma = std::hypot(summary.sigma, scale.gap_sigma / distance);
  if (path.beginning) summary.path_sigma = std::hypot(summary.path_sigma, path.beginning->length / distance);
}

// Why there is no scale, and what may be the cause; empty where there is a scale.
std::string PendingReason(const DriveFacts& drive, const std::vector<FrameResult>& frames, const RefinedScale& scale) {
  if (scale.estimate) return "";
  std::string reason = scale.reason;
  if (!drive.has_measure() && !drive.given.vehicle_file.empty())
    reason = fmt::format("{} has neither lever arm nor height; give --lever-arm", drive.given.vehicle_file);
  if (reason.empty()) return "";
  const std::optional<MissingPart> before = PartBeforeMap(frames);
  if (before && IsMostOfDrive(*before, frames))
    reason = fmt::format("the path begins only at {:.1f} s; {}", before->to - drive.given.first_time, reason);
  if (!drive.has_measure()) return reason;
  if (drive.images.blending) {
    reason += "; the images are blended, which may be the cause";
  } else if (drive.images.is_upside_down) {
    reason += "; the images seem to be upside down, which may be the cause";
  } else if (!scale.contradicted_calibration.empty()) {
    reason += "; the images contradict the calibration, which may be the cause";
  }
  // What a part of the drive lacks, the rest may have.
  if (drive.ending.is_part && HasPose(frames)) reason += "; only a part of the drive was processed, process more of it";
  return reason;
}

}  // namespace

ScaleSummary ScaleSummaryOf(const DriveFacts& drive, const std::vector<FrameResult>& frames, const RefinedScale& scale,
                            const PathSummary& path) {
  ScaleSummary summary;
  summary.state = StateAtEnd(scale);
  summary.pending_reason = PendingReason(drive, frames, scale);
  FindPathSigma(scale, path, summary);
  FindWorstSigma(frames, summary);
  summary.turns_found = static_cast<int>(scale.turns.size());
  summary.turns_used = static_cast<int>(std::ranges::count_if(scale.turns, &TurnResult::used));
  summary.calibration_windows = scale.calibration_windows;
  summary.readout = scale.readout;
  summary.calibration_in_doubt = scale.calibration_in_doubt;
  summary.calibration_agrees = scale.contradicted_calibration.empty();
  summary.sigma_reason = SigmaReason(drive, frames, scale, path, summary);
  if (!scale.estimate) return summary;
  summary.turn_test = scale.estimate->test;
  summary.image_lag = scale.estimate->image_lag;
  summary.image_smoothing = scale.estimate->image_smoothing;
  return summary;
}

double LengthSigma(const RefinedScale& scale) { return scale.estimate ? scale.estimate->length_sigma : INFINITY; }

std::string UpToScaleText(const std::string& pending_reason) {
  return "the trajectory is up to scale" + (pending_reason.empty() ? "" : ": " + pending_reason);
}

CarSummary CarSummaryOf(const DriveFacts& drive, const RefinedScale& scale) {
  CarSummary summary;
  if (!scale.estimate) return summary;
  const ScaleEstimate& estimate = *scale.estimate;
  if (!estimate.uses_single_turns) {
    summary.refined = estimate.car;
    // The prior of a height that was measured has the sigma of the aspect.
    const double aspect_sigma = drive.vehicle.has_measured_height() ? 0 : scale.aspect_sigma;
    summary.refined->camera_height_sigma = HeightSigma(estimate, std::hypot(scale.calibration_sigma, aspect_sigma));
  }
  if (estimate.has_reliable_car()) summary.evidence = estimate.car_evidence;
  if (estimate.yaw_conflict) summary.contradicting_yaw = drive.camera_angles().yaw + estimate.car.yaw_error;
  return summary;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/run/run_summary.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/number_text.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/run/image_warnings.h"
#include "turnscale/run/impossible_motion.h"
#include "turnscale/run/settings.h"
#include "turnscale/run/time_check.h"
#include "turnscale/run/turn_warning.h"
#include "turnscale/run/view_change.h"

namespace turnscale {
namespace {

constexpr auto kMeasureAgain =
    "measure both again, and check fx and fy (pixels may not be square) and whether the video is stabilised";
constexpr auto kCheckVehicle = "check that the file of --vehicle is of this car and camera";

// Tracking that is lost at the first image of a clip, though no time is missing before it, is a sign of clips that do
// not follow one another.
std::vector<std::string> SeamWarnings(const RunSummary& summary) {
  constexpr double kAtOnce = 0.15;  // s
  std::vector<std::string> warnings;
  for (size_t i = 1; i < summary.clips.size(); ++i) {
    const ClipPart& clip = summary.clips[i];
    const bool lost = std::ranges::any_of(summary.missing, [&](const MissingPart& part) {
      return part.reason == MissingReason::kLost && std::abs(part.from - clip.start) < kAtOnce;
    });
    if (!lost || clip.gap_before > 0) continue;
    const auto name = [](const ClipPart& part) { return std::filesystem::path(part.file).filename().string(); };
    warnings.push_back(
        fmt::format("tracking is lost where {} ends and {} begins (at {:.1f} s): check that the clips are in order and "
                    "none is missing",
                    name(summary.clips[i - 1]), name(clip), clip.start - summary.first_time));
  }
  return warnings;
}

// The estimated height is proportional to the scale, so that a wrong lever arm shows in it, and an image that
// stabilisation turns with a delay (too low). One line; empty for a usual height.
std::string UnusualHeight(const CarRefinement& car) {
  constexpr double kLeast = 0.9;  // m; sports cars and up
  constexpr double kMost = 2.4;   // m; vans
  const double reach = 2 * car.camera_height_sigma;
  if (car.camera_height + reach >= kLeast && car.camera_height - reach <= kMost) return {};
  return fmt::format(
      "the turns give a camera {:.2f} +-{:.2f} m above the road, which is unusual for a car; if it is wrong, the scale "
      "is wrong by the same factor: check --lever-arm{}, or give the measured --camera-height",
      car.camera_height, car.camera_height_sigma,
      car.camera_height < kLeast ? ", the calibration and whether the video is stabilised" : " and the calibration");
}

// A method that was asked for and has changed nothing. One line; empty where it was applied, or there is no scale.
std::string MethodWarning(ScaleMethod method, const RefinedScale& scale) {
  if (method == ScaleMethod::kSmoothed || scale.constrained || !scale.estimate) return {};
  return fmt::format(
      "the method {} was not applied: no turn could be constrained (turns.csv has the reasons); the "
      "trajectory uses {}",
      ScaleMethodName(method),
      scale.estimate->uses_single_turns ? "the scales of single turns, interpolated" : "the joint estimate");
}

// What to do about a camera-to-vehicle rotation that is wrong.
std::string RotationRemedy(const VehicleOptions& vehicle) {
  if (!vehicle.calibrate_camera) return "correct --camera-rotation, or leave it out to have it estimated";
  if (vehicle.camera_known) return kCheckVehicle;
  return "check whether the camera was moved";
}

double LengthSigma(const RefinedScale& scale) { return scale.estimate ? scale.estimate->length_sigma : INFINITY; }

// Along the keyframes, and from frame to frame where the path is not measured. A standing car adds no keyframes: else
// the noise of its poses would add up, the more the higher the frame rate. One that turns back between two keyframes is
// measured by way of its farthest place.
void MeasurePath(const std::vector<FrameResult>& refined, RunSummary& summary) {
  summary.distance = summary.missing_distance = 0;
  const FrameResult* measured = nullptr;  // up to which the path has been measured
  const FrameResult* farthest = nullptr;  // from there, of the frames since
  const FrameResult* before = nullptr;
  const auto measure_to = [&](const FrameResult& frame) {
    double step = DistanceBetween(*measured, frame);
    if (farthest && DistanceBetween(*measured, *farthest) > step)
      step = DistanceBetween(*measured, *farthest) + DistanceBetween(*farthest, frame);
    summary.distance += step;
    measured = &frame;
    farthest = nullptr;
    return step;
  };
  for (const FrameResult& frame : refined) {
    if (!frame.world_from_camera) continue;
    if (!before) {
      measured = &frame;
    } else if (IsMissing(summary.missing, before->time, frame.time)) {
      measure_to(*before);
      summary.missing_distance += measure_to(frame);
    } else if (frame.keyframe) {
      measure_to(frame);
    } else if (frame.is_measured() &&
               (!farthest || DistanceBetween(*measured, frame) > DistanceBetween(*measured, *farthest))) {
      farthest = &frame;
    }
    before = &frame;
  }
  if (before) measure_to(*before);
}

int CountOf(TrackingState state, const std::vector<FrameResult>& frames) {
  return static_cast<int>(std::ranges::count(frames, state, &FrameResult::state));
}

bool HasPose(const std::vector<FrameResult>& frames) {
  return std::ranges::any_of(frames, [](const FrameResult& frame) { return frame.world_from_camera.has_value(); });
}

void FindWorstSigma(const std::vector<FrameResult>& refined, RunSummary& summary) {
  summary.worst_sigma = HasPose(refined) ? 0 : INFINITY;
  summary.worst_sigma_time = 0;
  for (const FrameResult& frame : refined) {
    if (!frame.world_from_camera || summary.worst_sigma >= frame.scale_sigma) continue;
    summary.worst_sigma = frame.scale_sigma;
    summary.worst_sigma_time = frame.time;
  }
}

void SummarizePath(const std::vector<FrameResult>& refined, RunSummary& summary) {
  summary.frames = static_cast<int>(refined.size());
  summary.missing = FindMissingParts(refined);
  summary.tracked = CountOf(TrackingState::kTracked, refined);
  summary.repeated = CountOf(TrackingState::kRepeated, refined);
  summary.bridged = CountOf(TrackingState::kBridged, refined);
  summary.initializing = CountOf(TrackingState::kInitializing, refined);
  summary.keyframes = static_cast<int>(std::ranges::count_if(refined, &FrameResult::keyframe));
  summary.seconds = refined.empty() ? 0 : refined.back().time - refined.front().time;
  FindWorstSigma(refined, summary);
  MeasurePath(refined, summary);
}

// Whether a part before the map is most of the drive.
bool IsMost(const MissingPart& before, const std::vector<FrameResult>& frames) {
  constexpr double kMost = 0.5;
  return IsLate(before, frames, kMost);
}

// Why there is no scale, and what may be the cause; empty where there is a scale.
std::string PendingReason(const std::vector<FrameResult>& refined, const RefinedScale& scale,
                          const RunSummary& summary) {
  if (scale.estimate) return "";
  std::string reason = scale.reason;
  if (!summary.has_measure() && !summary.vehicle_file.empty())
    reason = fmt::format("{} has neither lever arm nor height; give --lever-arm", summary.vehicle_file);
  if (reason.empty()) return "";
  const std::optional<MissingPart> before = PartBeforeMap(refined);
  if (before && IsMost(*before, refined))
    reason = fmt::format("the path begins only at {:.1f} s; {}", before->to - summary.first_time, reason);
  if (!summary.has_measure()) return reason;
  if (summary.blending) {
    reason += "; the images are blended, which may be the cause";
  } else if (summary.is_upside_down) {
    reason += "; the images seem to be upside down, which may be the cause";
  } else if (!summary.calibration_agrees) {
    reason += "; the images contradict the calibration, which may be the cause";
  }
  // What a part of the drive lacks, the rest may have.
  if (summary.is_part && HasPose(refined)) reason += "; only a part of the drive was processed, process more of it";
  return reason;
}

// After the path, on whose length the shares of its errors depend. `length_error`: what impossible motion, parts of
// uncertain scale and blended images suggest, metres.
void SummarizeScale(const std::vector<FrameResult>& refined, const RefinedScale& scale, double length_error,
                    RunSummary& summary) {
  const double distance = std::max(summary.distance, 1e-9);
  summary.scale_sigma = std::hypot(LengthSigma(scale), length_error / distance);
  summary.path_sigma = std::hypot(summary.scale_sigma, scale.gap_sigma / distance);
  summary.turns_found = static_cast<int>(scale.turns.size());
  summary.turns_used = static_cast<int>(std::ranges::count_if(scale.turns, &TurnResult::used));
  summary.calibration_windows = scale.calibration_windows;
  summary.calibration_agrees = scale.contradicted_calibration.empty();
  summary.pending_reason = PendingReason(refined, scale, summary);
  if (!scale.estimate) return;
  const ScaleEstimate& estimate = *scale.estimate;
  if (!estimate.uses_single_turns) {
    summary.car = estimate.car;
    summary.car->camera_height_sigma = HeightSigma(estimate, scale.calibration_sigma);
  }
  if (estimate.has_reliable_car()) summary.car_evidence = estimate.car_evidence;
  summary.turn_test = estimate.test;
  summary.image_lag = estimate.image_lag;
  summary.image_smoothing = estimate.image_smoothing;
  summary.height_conflict = estimate.height_conflict;
  if (estimate.yaw_conflict) {
    const YawPitchRoll used =
        summary.mount ? summary.mount->angles : YawPitchRollFromRotation(summary.vehicle.vehicle_from_camera);
    summary.contradicting_yaw = used.yaw + estimate.car.yaw_error;
  }
}

std::string TurnsWarning(const RefinedScale& scale) {
  if (!scale.estimate) return "";
  const auto frames_of = [&](int turn) {
    return fmt::format("frames {}-{}", scale.turns[turn].first_frame, scale.turns[turn].last_frame);
  };
  return TurnWarning(*scale.estimate, frames_of,
                     "the camera's calibration and rotation, the timestamps, the lever arm and the side slip");
}

// The yaw of an earlier drive that this one contradicts, and which is therefore not used; empty if there is none.
std::string OtherYaw(const RunSummary& summary) {
  constexpr double kMostSigmas = 3;
  const VehicleOptions& vehicle = summary.vehicle;
  if (!vehicle.camera_known || !summary.mount || !summary.mount->found || summary.mount->moves > 0 ||
      !summary.camera_jumps.empty())
    return "";
  const double known = YawPitchRollFromRotation(vehicle.vehicle_from_camera).yaw;
  const double found = summary.mount->angles.yaw;
  if (!(std::abs(found - known) > kMostSigmas * std::hypot(vehicle.yaw_sigma, summary.mount->sigma.yaw))) return "";
  return fmt::format(
      "the drive gives a camera yaw of {:+.1f} +-{:.1f} deg, not {:+.1f} deg as in the file of the car; "
      "the trajectory uses the yaw from the drive: {}",
      InDegrees(found), InDegrees(summary.mount->sigma.yaw), InDegrees(known), kCheckVehicle);
}

// Images that lie on their side; empty if they do not.
std::string RollWarning(const RunSummary& summary) {
  constexpr double kUpright = 45;  // degrees
  if (!summary.mount || !summary.mount->found) return "";
  const double roll = InDegrees(summary.mount->angles.roll);
  if (std::abs(roll) < kUpright) return "";
  return fmt::format("the camera leans by {:+.0f} deg: if the images lie on their side, {}", roll,
                     RotationAdvice(summary.rotate, roll > 0 ? 90 : 270));
}

// A camera that seems to look far to the side; empty if it does not.
std::string SidewaysWarning(const RunSummary& summary) {
  constexpr double kMost = 40;  // degrees
  if (!summary.mount || !summary.mount->found) return "";
  const double yaw = InDegrees(summary.mount->angles.yaw);
  const double off_axis = std::min(std::abs(yaw), 180 - std::abs(yaw));
  if (off_axis < kMost) return "";
  return fmt::format(
      "the camera seems to be turned by {:+.0f} deg from the direction of travel: if it looks ahead or back, the path "
      "and its scale are wrong; run again from another --start",
      yaw);
}

// Images that are known to be stabilised. The drive may not show that they no longer are.
std::string KnownLagWarning(const VehicleOptions& vehicle, const RefinedScale& scale) {
  std::string text = fmt::format("the images are taken to be stabilised, with a lag of {:+.2f} +-{:.2f} s",
                                 vehicle.image_lag, vehicle.image_lag_sigma);
  if (scale.estimate && scale.estimate->image_lag)
    text += fmt::format(" before and {:+.2f} +-{:.2f} s after this drive", scale.estimate->image_lag->found,
                        scale.estimate->image_lag->found_sigma);
  return text +
         ": without stabilisation, remove image_lag and image_lag_sigma from the file of the car or the settings";
}

// What the drive says of the car against what was given or is usual.
std::vector<std::string> CarWarnings(const RefinedScale& scale, const RunSummary& summary) {
  std::vector<std::string> warnings;
  const VehicleOptions& vehicle = summary.vehicle;
  if (summary.height_conflict)
    warnings.push_back(HeightWarning(*summary.height_conflict, vehicle.lever_arm.value_or(0),
                                     vehicle.camera_known ? kCheckVehicle : kMeasureAgain));
  if (summary.car && summary.car->camera_height > 0 && !vehicle.camera_height)
    warnings.push_back(UnusualHeight(*summary.car));
  if (scale.estimate && scale.estimate->slip_conflict) warnings.push_back(SlipWarning(*scale.estimate->slip_conflict));
  if (vehicle.image_lag_sigma > 0)
    warnings.push_back(KnownLagWarning(vehicle, scale));
  else if (scale.estimate && scale.estimate->is_stabilised())
    warnings.push_back(StabilisationWarning(*scale.estimate));
  if (scale.estimate && scale.estimate->yaw_conflict)
    warnings.push_back(YawWarning(*scale.estimate->yaw_conflict, RotationRemedy(vehicle)));
  if (std::string other = OtherYaw(summary); !other.empty()) warnings.push_back(std::move(other));
  if (std::string roll = RollWarning(summary); !roll.empty()) warnings.push_back(std::move(roll));
  if (std::string sideways = SidewaysWarning(summary); !sideways.empty()) warnings.push_back(std::move(sideways));
  return warnings;
}

void AddWarnings(const std::vector<FrameResult>& refined, const RefinedScale& scale,
                 const std::vector<ImpossibleMotion>& impossible, RunSummary& summary) {
  const auto add = [&](std::string warning) {
    if (!warning.empty()) summary.warnings.push_back(std::move(warning));
  };
  std::string scale_error;
  if (const double sigma = LengthSigma(scale); std::isfinite(sigma))
    scale_error = fmt::format("the scale may be off by {:.0f} % or more", 100 * sigma);
  const double first_time = summary.first_time;
  const ImageFindings images{.is_upside_down = summary.is_upside_down,
                             .rotated = summary.rotate,
                             .blending = summary.blending,
                             .contradicted_calibration = scale.contradicted_calibration,
                             .is_calibration_refined = summary.found_camera.has_value()};
  for (std::string& warning : ImageWarnings(images, first_time, "the scale may be wrong", scale_error))
    add(std::move(warning));
  add(TurnsWarning(scale));
  add(MethodWarning(summary.method, scale));
  for (std::string& warning : CarWarnings(scale, summary)) add(std::move(warning));
  for (std::string& warning : TimeWarnings(refined, scale.turns, first_time)) add(std::move(warning));
  for (std::string& warning : SeamWarnings(summary)) add(std::move(warning));
  std::vector<double> seams;
  for (const ClipPart& clip : summary.clips) seams.push_back(clip.start);
  add(ViewChangeText(FindViewChanges(refined, summary.restarts, seams), first_time));
  add(ImpossibleMotionText(impossible, first_time));
  if (summary.uncertain_scale)
    add(UncertainScaleText(SinceFirst(*summary.uncertain_scale, first_time), summary.distance));
}

}  // namespace

std::string UpToScaleText(const std::string& pending_reason) {
  return "the trajectory is up to scale" + (pending_reason.empty() ? "" : ": " + pending_reason);
}

std::string SkippedWarning(int frame, const std::string& problem) {
  return fmt::format("frame {}: {}; skipped", frame, problem);
}

std::string CameraMovedWarning(int frame) {
  return fmt::format("frame {}: the camera was moved since the last turn; re-estimating the camera-to-vehicle rotation",
                     frame);
}

std::string CameraJumpText(const MountJump& jump, double first_time) {
  return fmt::format(
      "frame {} (at {:.1f} s): the camera was turned on the car by {:.1f} degrees to the {}, as by a knock",
      jump.first_frame, jump.time - first_time, std::abs(InDegrees(jump.yaw)), jump.yaw > 0 ? "right" : "left");
}

std::string CameraJumpWarning(const MountJump& jump, double first_time) {
  return CameraJumpText(jump, first_time) +
         "; the path allows for it, and car.yaml has the rotation after it: check that the camera is still fixed";
}

std::string UnreadableText(const std::vector<UnreadableFrame>& frames) {
  constexpr size_t kNamed = 5;
  std::string numbers;
  for (size_t i = 0; i < std::min(frames.size(), kNamed); ++i)
    numbers += fmt::format("{}{}", i == 0 ? "" : ", ", frames[i].frame);
  if (frames.size() > kNamed) numbers += fmt::format(" and {} more", frames.size() - kNamed);
  return fmt::format("{} image{} cannot be used: frame{} {} (the first: {})", frames.size(),
                     frames.size() == 1 ? "" : "s", frames.size() == 1 ? "" : "s", numbers, frames.front().problem);
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

double HeightSigma(const ScaleEstimate& estimate, double calibration_sigma) {
  const double slip = estimate.slip_conflict ? estimate.test.disagreement : 0;
  const std::optional<HeightConflict>& height = estimate.height_conflict;
  const double between = height ? 0.5 * std::log(height->found / height->given) : 0;
  const double smoothing = estimate.image_smoothing ? estimate.image_smoothing->scale_error : 0;
  return std::hypot(estimate.car.camera_height_sigma,
                    std::hypot(std::hypot(calibration_sigma, slip, between), smoothing) * estimate.car.camera_height);
}

void Summarize(const std::vector<FrameResult>& refined, const RefinedScale& scale, RunSummary& summary) {
  SummarizePath(refined, summary);
  const std::vector<ImpossibleMotion> impossible = FindImpossibleMotion(refined);
  summary.uncertain_scale = FindUncertainScale(refined);
  const double of_uncertain = summary.uncertain_scale ? summary.uncertain_scale->length_error() : 0;
  SummarizeScale(refined, scale, std::hypot(LengthErrorOf(impossible), of_uncertain), summary);
  AddWarnings(refined, scale, impossible, summary);
  if (summary.pose_frame == "vehicle" && !summary.is_metric())
    summary.warnings.emplace_back(
        "without a scale the rear axle has no place: the positions are the camera's, with the directions of the car");
}

void SummarizeBeginning(const std::vector<FrameResult>& frames, const SeenImages& seen, RunSummary& summary) {
  const std::optional<MissingPart> before = PartBeforeMap(frames);
  if (!before) return;
  constexpr double kBriefSeconds = 0.5;
  constexpr double kSmallShare = 0.03;
  if (seen.Still()) return;
  double length = LengthBefore(*before, frames);
  // A map whose scale is hardly known does not tell the speed.
  const std::optional<UncertainScale>& uncertain = summary.uncertain_scale;
  if (uncertain && uncertain->from < before->to + kBriefSeconds)
    length = std::max(length, uncertain->usual_speed() * (before->to - before->from));
  summary.path_sigma = std::hypot(summary.path_sigma, length / std::max(summary.distance, 1e-9));
  const double seconds = before->to - before->from;
  if (seconds < kBriefSeconds || (seconds < kLateSeconds && length < kSmallShare * summary.distance)) return;
  // The cause of a short part is hard to tell.
  const MissingPart shown = SinceFirst(*before, summary.first_time);
  std::string warning =
      IsMost(*before, frames) ? LateBeginningText(shown, summary.frames, seen) : NoMapBeforeText(shown, summary.frames);
  if (summary.is_scale_known())
    warning += fmt::format("; if the car drove there, the path lacks up to about {:.0f} m", length);
  summary.warnings.push_back(std::move(warning));
}

std::string FoundCameraText(const FoundCamera& found) {
  return CameraFileText(found.camera) + "principal_point_sigma: " + NumberText(found.centre_sigma) + "\n";
}

}  // namespace turnscale

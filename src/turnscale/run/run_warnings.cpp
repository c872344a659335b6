// SPDX-License-Identifier: MIT
#include "turnscale/run/run_warnings.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/run/frame_warnings.h"
#include "turnscale/run/image_warnings.h"
#include "turnscale/run/settings.h"
#include "turnscale/run/time_check.h"
#include "turnscale/run/turn_warning.h"
#include "turnscale/scale/camera_height.h"

namespace turnscale {
namespace {

constexpr auto kMeasureAgain =
    "measure both again, and check fx and fy (pixels may not be square) and whether the video is stabilised";
constexpr auto kCheckVehicle = "check that the file of --vehicle is of this car and camera";

// Tracking that is lost at the first image of a clip, though no time is missing before it, is a sign of clips that do
// not follow one another. Where images are seen to be missing before a clip, the reader of the clips has said so.
std::vector<std::string> SeamWarnings(const std::vector<ClipPart>& clips, const std::vector<MissingPart>& missing,
                                      double first_time) {
  constexpr double kAtOnce = 0.15;  // s
  std::vector<std::string> warnings;
  for (size_t i = 1; i < clips.size(); ++i) {
    const ClipPart& clip = clips[i];
    const bool lost = std::ranges::any_of(missing, [&](const MissingPart& part) {
      return part.reason == MissingReason::kLost && std::abs(part.from - clip.start) < kAtOnce;
    });
    if (!lost || clip.gap_before > 0 || clip.unknown_gap_before) continue;
    const auto name = [](const ClipPart& part) { return std::filesystem::path(part.file).filename().string(); };
    const std::string why =
        clip.likely_gap_before > 0
            ? fmt::format("by the times in their names, about {:.1f} s are missing there, and the path is too short",
                          clip.likely_gap_before)
            : std::string("check that the clips are in order and none is missing");
    warnings.push_back(fmt::format("tracking is lost where {} ends and {} begins (at {:.1f} s): {}", name(clips[i - 1]),
                                   name(clip), clip.start - first_time, why));
  }
  return warnings;
}

std::string UnusualHeightWarning(const UnusualHeight& unusual) {
  return fmt::format(
      "the turns give a camera {:.2f} +-{:.2f} m above the road, which is unusual for a car; if this height is wrong, "
      "the scale is wrong by the same factor: check --lever-arm{}, or give the measured --camera-height",
      unusual.height, unusual.sigma,
      unusual.is_low ? ", the calibration and whether the video is stabilised" : " and the calibration");
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

std::string TurnsWarning(const RefinedScale& scale) {
  if (!scale.estimate) return "";
  const auto frames_of = [&](int turn) {
    return fmt::format("frames {}-{}", scale.turns[turn].first_frame, scale.turns[turn].last_frame);
  };
  return TurnWarning(*scale.estimate, frames_of,
                     "the camera's calibration and rotation, the timestamps, the lever arm and the side slip");
}

// The yaw of an earlier drive that this one contradicts, and which is therefore not used; empty if there is none.
std::string OtherYaw(const VehicleOptions& vehicle, const MountSummary& mount) {
  constexpr double kMostSigmas = 3;
  const std::optional<MountEstimate>& estimate = mount.estimate;
  if (!vehicle.camera_known || !estimate || !estimate->found || !estimate->moves.empty() || !mount.jumps.empty())
    return "";
  const double known = YawPitchRollFromRotation(vehicle.vehicle_from_camera).yaw;
  const double found = estimate->angles.yaw;
  if (!(std::abs(found - known) > kMostSigmas * std::hypot(vehicle.yaw_sigma, estimate->sigma.yaw))) return "";
  return fmt::format(
      "the drive gives a camera yaw of {:+.1f} +-{:.1f} deg, not {:+.1f} deg as in the file of the car; "
      "the trajectory uses the yaw from the drive: {}",
      InDegrees(found), InDegrees(estimate->sigma.yaw), InDegrees(known), kCheckVehicle);
}

// Images that lie on their side; empty if they do not. `rotated`: degrees clockwise, by --rotate.
std::string RollWarning(const MountSummary& mount, int rotated) {
  constexpr double kUpright = 45;  // degrees
  if (!mount.estimate || !mount.estimate->found) return "";
  const double roll = InDegrees(mount.estimate->angles.roll);
  if (std::abs(roll) < kUpright) return "";
  return fmt::format("the camera leans by {:+.0f} deg: if the images lie on their side, {}", roll,
                     RotationAdvice(rotated, roll > 0 ? 90 : 270));
}

// A camera that seems to look far to the side; empty if it does not.
std::string SidewaysWarning(const MountSummary& mount) {
  if (!mount.estimate || !mount.estimate->found) return "";
  if (LooksAlong(RotationFromYawPitchRoll(mount.estimate->angles))) return "";
  return fmt::format(
      "the camera seems to be turned by {:+.0f} deg from the direction of travel: if it looks ahead or back, the path "
      "and its scale are wrong; run again from another --start",
      InDegrees(mount.estimate->angles.yaw));
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

// Whether the calibration, which has its own warning, may be the cause of what is wrong with the turns: where the
// images are upside down or blended, they contradict a right one.
bool IsCalibrationSuspect(const DriveFacts& drive, const RefinedScale& scale) {
  return !scale.contradicted_calibration.empty() && !drive.images.is_upside_down && !drive.images.blending;
}

// What may follow from a wrong calibration, as parts of a sentence.
std::vector<std::string> ConsequencesOfCalibration(const DriveFacts& drive, const RefinedScale& scale) {
  std::vector<std::string> parts;
  if (!scale.estimate || !IsCalibrationSuspect(drive, scale)) return parts;
  const ScaleEstimate& estimate = *scale.estimate;
  if (estimate.test.contradicted && estimate.test.worst_turn >= 0)
    parts.push_back(fmt::format("the turns disagree on the scale by {:.0f} %", 100 * estimate.test.disagreement));
  if (const std::optional<HeightConflict>& height = estimate.height_conflict)
    parts.push_back(fmt::format("lever arm and camera height disagree by {:.0f} %",
                                100 * std::abs(height->given / height->found - 1)));
  if (scale.unusual_height)
    parts.push_back(fmt::format("the turns give a camera {:.2f} m above the road", scale.unusual_height->height));
  if (!estimate.converged) parts.emplace_back("the scale estimate did not converge");
  if (estimate.slip_conflict) parts.emplace_back("the turns show an unusual side slip");
  if (estimate.yaw_conflict) parts.emplace_back("the drive contradicts the camera's yaw");
  return parts;
}

// What the drive says of the car against what was given or is usual.
std::vector<std::string> CarWarnings(const DriveFacts& drive, const RefinedScale& scale) {
  std::vector<std::string> warnings;
  const VehicleOptions& vehicle = drive.vehicle;
  // Where it is, its own warning names what may follow from it.
  const bool is_calibration_suspect = IsCalibrationSuspect(drive, scale);
  if (!is_calibration_suspect && scale.estimate && scale.estimate->height_conflict)
    warnings.push_back(HeightWarning(*scale.estimate->height_conflict, vehicle.lever_arm.value_or(0),
                                     vehicle.camera_known ? kCheckVehicle : kMeasureAgain));
  if (!is_calibration_suspect && scale.unusual_height) warnings.push_back(UnusualHeightWarning(*scale.unusual_height));
  if (!is_calibration_suspect && scale.estimate && scale.estimate->slip_conflict)
    warnings.push_back(SlipWarning(*scale.estimate->slip_conflict));
  if (vehicle.image_lag_sigma > 0)
    warnings.push_back(KnownLagWarning(vehicle, scale));
  else if (scale.estimate && scale.estimate->is_stabilised())
    warnings.push_back(StabilisationWarning(*scale.estimate));
  if (!is_calibration_suspect && scale.estimate && scale.estimate->yaw_conflict)
    warnings.push_back(YawWarning(*scale.estimate->yaw_conflict, RotationRemedy(vehicle)));
  warnings.push_back(OtherYaw(vehicle, drive.mount));
  warnings.push_back(RollWarning(drive.mount, drive.given.rotate));
  warnings.push_back(SidewaysWarning(drive.mount));
  return warnings;
}

std::vector<std::string> WarningsOfImages(const DriveFacts& drive, const RefinedScale& scale) {
  std::string scale_error;
  if (const double sigma = LengthSigma(scale); std::isfinite(sigma))
    scale_error = fmt::format("the scale may be off by {:.0f} % or more", 100 * sigma);
  // A small doubt is part of sigma, and no news.
  constexpr double kLargeDoubt = 0.2;
  const bool is_doubtful = scale.doubt_sigma > kLargeDoubt;
  const ImageFindings images{
      .is_upside_down = drive.images.is_upside_down,
      .rotated = drive.given.rotate,
      .blending = drive.images.blending,
      .contradicted_calibration = scale.contradicted_calibration,
      .doubtful_calibration = is_doubtful ? scale.doubtful_calibration : std::vector<ParameterEstimate>{},
      .is_calibration_refined = drive.given.found_camera.has_value(),
      .has_distortion = drive.camera.lens_model != LensModel::kPinhole,
      .consequences = ConsequencesOfCalibration(drive, scale)};
  return ImageWarnings(images, drive.given.first_time, "the scale may be wrong", scale_error);
}

// A path that begins 2 s late, or 0.5 s and lacks 3 % of its length; empty if it does not.
std::string BeginningWarning(const UnmappedBeginning& beginning, const RunSummary& summary) {
  constexpr double kLeastSeconds = 0.5;
  constexpr double kSmallShare = 0.03;
  const double seconds = beginning.part.to - beginning.part.from;
  if (seconds < kLeastSeconds || (seconds < kLateSeconds && beginning.length < kSmallShare * summary.path.distance))
    return "";
  // The cause of a short part is hard to tell.
  const MissingPart shown = SinceFirst(beginning.part, summary.drive.given.first_time);
  const int count = summary.frames.total;
  std::string warning =
      beginning.is_most_of_drive ? LateBeginningText(shown, count, summary.drive.seen) : NoMapBeforeText(shown, count);
  if (summary.scale.is_known())
    warning += fmt::format("; if the car drove there, the path lacks up to about {:.0f} m", beginning.length);
  return warning;
}

// A path that is assumed rather than measured for more than half of its length; empty if it is not.
std::string MostlyMissingWarning(const PathSummary& path) {
  constexpr double kMost = 0.5;
  if (!(path.missing_distance > kMost * path.distance)) return "";
  return fmt::format(
      "{:.0f} % of the length of the path is not measured, but follows from the motion before and after: it is a guess "
      "there; \"missing\" in summary.json says where",
      100 * path.missing_distance / path.distance);
}

// From when to when the path is not measured before a restart of the map, as seconds since the first frame.
std::string GapText(const std::vector<MissingPart>& missing, double restart, double first_time) {
  constexpr double kSameGap = 0.5;  // seconds between parts of it
  const auto last =
      std::find_if(missing.rbegin(), missing.rend(), [&](const MissingPart& part) { return part.from < restart; });
  if (last == missing.rend()) return fmt::format("before {:.1f} s", restart - first_time);
  double from = last->from;
  for (auto part = last + 1; part != missing.rend() && part->to > from - kSameGap; ++part) from = part->from;
  return fmt::format("from {:.1f} to {:.1f} s", from - first_time, last->to - first_time);
}

// Gaps in which the car may have turned by another angle than the path has; empty if there are none.
std::string UnknownTurnWarning(const std::vector<MapRestart>& restarts, const std::vector<MissingPart>& missing,
                               double first_time) {
  constexpr double kLeast = 10 / kDegreesPerRadian;
  constexpr double kUnknown = 40 / kDegreesPerRadian;
  const auto count =
      std::ranges::count_if(restarts, [](const MapRestart& restart) { return restart.turn_sigma > kLeast; });
  if (count == 0) return "";
  const MapRestart& worst = *std::ranges::max_element(restarts, {}, &MapRestart::turn_sigma);
  const std::string gap = GapText(missing, worst.time, first_time);
  const std::string where =
      count == 1 ? fmt::format("the gap {}", gap) : fmt::format("{} gaps (at worst the one {})", count, gap);
  const char* known = count == 1 && worst.turn_sigma > kUnknown ? "is not known" : "is hardly known";
  return fmt::format(
      "the direction of travel after {} {} (+-{:.0f} deg), as it could not be measured in the images: the path that "
      "follows may be rotated, as where the car turned a corner in the gap",
      where, known, InDegrees(worst.turn_sigma));
}

// A wrong calibration distorts a turn where it begins, which looks like a turn of the camera.
std::string DoubtfulKnocksWarning(const DriveFacts& drive, const RefinedScale& scale) {
  if (drive.mount.jumps.empty() || !IsCalibrationSuspect(drive, scale)) return "";
  return fmt::format(
      "the turn{} of the camera on the car may come from the calibration, which the images contradict: "
      "correct it first",
      drive.mount.jumps.size() == 1 ? "" : "s");
}

// The parts of the path that are doubtful.
std::vector<std::string> PathWarnings(const RunSummary& summary, const std::vector<FrameResult>& frames) {
  const DriveFacts& drive = summary.drive;
  const PathSummary& path = summary.path;
  const double first_time = drive.given.first_time;
  std::vector<std::string> warnings = SeamWarnings(drive.ending.clips, path.missing, first_time);
  std::vector<double> seams;
  for (const ClipPart& clip : drive.ending.clips) seams.push_back(clip.start);
  warnings.push_back(ViewChangeText(FindViewChanges(frames, drive.restarts, drive.repeated, seams), first_time));
  warnings.push_back(MostlyMissingWarning(path));
  warnings.push_back(UnknownTurnWarning(drive.restarts, path.missing, first_time));
  warnings.push_back(ImpossibleMotionText(path.impossible, first_time));
  warnings.push_back(ImpossibleDirectionText(path.impossible_directions, first_time));
  if (path.uncertain) warnings.push_back(UncertainScaleText(SinceFirst(*path.uncertain, first_time), path.distance));
  if (drive.given.pose_frame == "vehicle" && !summary.scale.is_metric())
    warnings.emplace_back(
        "without a scale the rear axle has no place: the positions are the camera's, with the directions of the car");
  for (const FrozenPart& part : path.frozen)
    warnings.push_back(FrozenPartText(part, first_time, summary.scale.is_metric() ? "m" : "units"));
  if (path.beginning) warnings.push_back(BeginningWarning(*path.beginning, summary));
  return warnings;
}

}  // namespace

std::vector<std::string> RunWarnings(const RunSummary& summary, const std::vector<FrameResult>& frames,
                                     const RefinedScale& scale) {
  const DriveFacts& drive = summary.drive;
  std::vector<std::string> warnings;
  const auto add = [&](std::string warning) {
    if (!warning.empty()) warnings.push_back(std::move(warning));
  };
  const auto add_all = [&](std::vector<std::string> more) {
    for (std::string& warning : more) add(std::move(warning));
  };
  if (!drive.images.unreadable.empty()) add(UnreadableText(drive.images.unreadable));
  add_all(WarningsOfImages(drive, scale));
  add(ContradictedReadoutText(scale));
  add(DoubtfulKnocksWarning(drive, scale));
  if (!IsCalibrationSuspect(drive, scale)) add(TurnsWarning(scale));
  add(MethodWarning(drive.method, scale));
  add_all(CarWarnings(drive, scale));
  add_all(TimeWarnings(frames, scale.turns, drive.given.first_time));
  add_all(PathWarnings(summary, frames));
  return warnings;
}

}  // namespace turnscale

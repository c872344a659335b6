// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/io/run_files.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/odometry/results.h"
#include "turnscale/run/run_summary.h"

namespace turnscale {
namespace {

constexpr double kKilometresPerHour = 3.6;  // per m/s

// Empty where the whole path is measured.
std::string MissingText(const RunSummary& summary) {
  if (summary.missing.empty()) return {};
  std::string text = fmt::format("missing {:.1f} s of {:.1f} s", TotalSeconds(summary.missing), summary.seconds);
  const std::vector<MissingPart> longest = LongestParts(summary.missing, kShownMissingParts);
  for (size_t i = 0; i < longest.size(); ++i)
    text += (i == 0 ? ": " : "; ") + MissingPartText(SinceFirst(longest[i], summary.first_time));
  if (const size_t more = summary.missing.size() - longest.size(); more > 0)
    text += fmt::format("; and {} shorter part{}", more, more == 1 ? "" : "s");
  return text + "\n";
}

// One line, empty unless there are several.
std::string ClipsText(const std::vector<ClipPart>& clips) {
  if (clips.size() < 2) return {};
  return fmt::format("clips   {}, from {} to {}\n", clips.size(), clips.front().file, clips.back().file);
}

std::string TestOfCalibration(const RunSummary& summary) {
  if (summary.is_upside_down) return "not tested, as the images seem to be upside down";
  if (summary.calibration_windows > 0)
    return summary.calibration_agrees ? "consistent with the turns" : "contradicted by the turns";
  std::string text = "not tested, as the drive has no sharp turn";
  // The height of the camera scales with the focal length.
  if (summary.is_metric() && summary.turns_used == 0) text += "; an error of its focal length changes the scale";
  return text;
}

// One line; empty before the first image.
std::string IntrinsicsText(const RunSummary& summary) {
  const std::optional<FoundCamera>& found = summary.found_camera;
  if (!found && summary.camera.empty())
    return summary.pinhole ? fmt::format("lens    focal length {:.1f} pixels, assumed\n", summary.pinhole->fx) : "";
  if (!found)
    return fmt::format("lens    calibration {}, {}\n", std::filesystem::path(summary.camera).filename().string(),
                       TestOfCalibration(summary));
  const Pinhole& pinhole = found->camera.pinhole;
  return fmt::format(
      "lens    focal length {}, principal point ({:.1f}, {:.1f}) +-{:.1f} pixels, estimated; for the "
      "next drive: --camera {}\n",
      FocalLengthText(found->camera), pinhole.cx, pinhole.cy, found->centre_sigma,
      (std::filesystem::path(summary.folder) / RunFiles::kCamera).string());
}

// Where a rotation comes from that the drive has not estimated.
std::string SourceOfRotation(const RunSummary& summary) {
  if (summary.mount && !summary.vehicle.camera_known) return "assumed; no turn was suitable for estimating it";
  if (!summary.contradicting_yaw) return "as given";
  return fmt::format("as given; the drive shows yaw {:+.2f} deg, which is used", InDegrees(*summary.contradicting_yaw));
}

std::string Times(int count) { return count == 1 ? "once" : fmt::format("{} times", count); }

// Degrees as they are shown. Rounded here: else it may say -0.00.
double Rounded(double angle) { return std::round(100 * InDegrees(angle)) / 100 + 0.0; }

// The angles of the camera's rotation do not include what the estimate of the scale finds for its yaw. Empty where that
// finds nothing, is not reliable, so that the file of the car does not have it either, or the line says so already.
std::string YawCorrectionText(const RunSummary& summary, double yaw) {
  const bool reliable = summary.car && summary.car_evidence;
  if (!reliable || summary.turns_used == 0 || summary.contradicting_yaw) return {};
  const double correction = Rounded(summary.car->yaw_error);
  if (correction == 0) return {};
  return fmt::format("; the scale estimate corrects the yaw to {:+.2f} +-{:.2f} deg (by {:+.2f})",
                     Rounded(yaw + summary.car->yaw_error), InDegrees(summary.car->yaw_error_sigma), correction);
}

std::string KnockText(const RunSummary& summary) {
  const auto knocks = static_cast<int>(summary.camera_jumps.size());
  return knocks > 0 ? "; turned by a knock " + Times(knocks) : "";
}

// One line.
std::string MountText(const RunSummary& summary) {
  const std::optional<MountSummary>& mount = summary.mount;
  if (mount && mount->is_outdated)
    return fmt::format("camera  moved {}; no turn since, so the rotation from before the move is used{}\n",
                       Times(mount->moves), KnockText(summary));
  if (!mount || !mount->found) {
    const YawPitchRoll angles = mount ? mount->angles : YawPitchRollFromRotation(summary.vehicle.vehicle_from_camera);
    return fmt::format("camera  yaw {:+.2f}, pitch {:+.2f}, roll {:+.2f} deg, {}{}{}\n", Rounded(angles.yaw),
                       Rounded(angles.pitch), Rounded(angles.roll), SourceOfRotation(summary), KnockText(summary),
                       YawCorrectionText(summary, angles.yaw));
  }
  const auto degrees = [](double angle) { return angle * kDegreesPerRadian; };
  std::string text = fmt::format(
      "camera  yaw {:+.2f} +-{:.2f}, pitch {:+.2f} +-{:.2f}, roll {:+.1f} +-{:.1f} deg, estimated from {}the drive",
      degrees(mount->angles.yaw), degrees(mount->sigma.yaw), degrees(mount->angles.pitch), degrees(mount->sigma.pitch),
      degrees(mount->angles.roll), degrees(mount->sigma.roll),
      summary.vehicle.camera_known && mount->moves == 0 ? "the file of the car and " : "");
  if (mount->moves > 0) text += "; moved " + Times(mount->moves);
  text += KnockText(summary);
  return text + YawCorrectionText(summary, mount->angles.yaw) + "\n";
}

// Length and frames of the path.
std::string PathText(const RunSummary& summary) {
  constexpr double kLittle = 0.01;
  const char* unit = summary.is_metric() ? "m" : "units";
  std::string text = fmt::format("path    {:.2f} {} in {:.1f} s", summary.distance, unit, summary.seconds);
  if (summary.is_metric() && summary.seconds > 0)
    text += fmt::format(" ({:.0f} km/h on average)", kKilometresPerHour * summary.distance / summary.seconds);
  text += fmt::format(", {} frames, {} keyframes", summary.frames, summary.keyframes);
  if (summary.missing_distance > kLittle * summary.distance)
    text += fmt::format("; {:.2f} {} of it not measured", summary.missing_distance, unit);
  return text + "\n";
}

// A height that only the drive tells is a check of the scale: both are wrong by the same factor.
std::string HeightText(const RunSummary& summary, const CarRefinement& car) {
  if (!(car.camera_height > 0)) return {};
  // Its sigma is that of the scale then, which another line has.
  if (summary.vehicle.camera_height && summary.turns_used == 0)
    return fmt::format("height  camera {:.3f} m above the road, as given\n", car.camera_height);
  return fmt::format("height  camera {:.3f} +-{:.3f} m above the road{}\n", car.camera_height, car.camera_height_sigma,
                     summary.vehicle.camera_height ? "" : " (compare with a tape measure)");
}

std::string SlipValue(double slip, double sigma) {
  return sigma > 0 ? fmt::format("{:.4f} +-{:.4f} s^2/m", slip, sigma) : fmt::format("{:.4f} s^2/m", slip);
}

// Empty without an estimate. Without a turn only the height is one.
std::string CarText(const RunSummary& summary) {
  const std::optional<CarRefinement>& car = summary.car;
  if (!car) return {};
  std::string text;
  if (summary.turns_used > 0)
    text = fmt::format("car     side slip {}\n",
                       SideSlipText(*car, summary.vehicle.side_slip, summary.vehicle.side_slip_sigma));
  return text + HeightText(summary, *car);
}

// Frames without a measured pose, by their state; empty if there are none.
std::string FramesText(const RunSummary& summary) {
  std::string text;
  const auto add = [&](size_t count, const char* state) {
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, state);
  };
  add(static_cast<size_t>(summary.initializing), "before initialisation");
  add(static_cast<size_t>(summary.bridged), "bridged (tracking lost)");
  add(summary.unreadable.size(), "unreadable");
  add(static_cast<size_t>(summary.repeated), "repeated");
  return text.empty() ? "" : "frames  without a measured pose: " + text + "\n";
}

// With the height of the camera alone, the scale may be known, but not from turns.
std::string TurnsText(const RunSummary& summary) {
  if (!summary.vehicle.lever_arm && summary.turns_found > 0)
    return fmt::format("turns   {} found; not used without --lever-arm\n", summary.turns_found);
  return fmt::format("turns   {} found, {} used\n", summary.turns_found, summary.turns_used);
}

std::string SigmaText(double sigma) {
  return sigma > kLargestShownSigma ? std::string("beyond +-100 %") : fmt::format("+-{:.1f} %", 100 * sigma);
}

std::string ScaleText(const RunSummary& summary) {
  if (summary.is_metric()) {
    constexpr double kClearly = 1.05;
    return fmt::format(
        "{}, path length {} (1 sigma){}, along the drive at most {} (at {:.1f} s)",
        summary.is_scale_known() ? "known" : "uncertain", SigmaText(summary.path_sigma),
        summary.path_sigma > kClearly * summary.worst_sigma ? " with what warnings say of its parts" : "",
        SigmaText(summary.worst_sigma), summary.worst_sigma_time - summary.first_time);
  }
  const std::string pending = ScaleStateName(summary.scale_state);
  if (summary.has_measure()) return pending + ", " + UpToScaleText(summary.pending_reason);
  const std::string why = summary.wants_metres()
                              ? ", " + UpToScaleText(summary.pending_reason)
                              : ": without --lever-arm, --camera-height or --vehicle the trajectory is up to scale";
  return fmt::format("{}{}; turnscale rescale {} --lever-arm METRES converts it to metres", pending, why,
                     summary.folder);
}

}  // namespace

std::string SideSlipText(const CarRefinement& car, double assumed, double assumed_sigma) {
  // Around a prior of 0, chance makes it negative.
  if (car.side_slip_at_bound)
    return fmt::format("0, since the estimate would be negative{}",
                       assumed > 0 ? ": check lever arm and timestamps" : "");
  const std::string before = SlipValue(assumed, assumed_sigma);
  const std::string after = SlipValue(car.side_slip, car.side_slip_sigma);
  const bool is_default = before == SlipValue(kUsualSideSlip, kUsualSideSlipSigma);
  if (after == before)
    return fmt::format("{}, {}, not refined by the drive", after, is_default ? "the default" : "as given");
  return fmt::format("{}, refined from the {} {}", after, is_default ? "default" : "given", before);
}

std::string FocalLengthText(const CameraModel& camera) {
  constexpr double kSquare = 0.001;
  const double aspect = camera.pinhole.fy / camera.pinhole.fx;
  std::string text = fmt::format("{:.1f} +-{:.1f}", camera.pinhole.fx, camera.focal_sigma);
  if (std::abs(aspect - 1) > kSquare)
    text += fmt::format(" (vertically {:.1f}, as pixels are {:.3g} times as wide as high)", camera.pinhole.fy, aspect);
  return text;
}

std::string SummaryText(const RunSummary& summary) {
  const RunCost& cost = summary.cost;
  return fmt::format(
      "{}"
      "{}"
      "scale   {}\n"
      "{}"
      "{}"
      "{}"
      "{}"
      "{}"
      "{}"
      "time    {:.1f} s elapsed ({:.1f} frames/s), {:.1f} ms of CPU time per frame over the whole run, {:.0f} MB of "
      "memory\n"
      "files   {}\n",
      ClipsText(summary.clips), PathText(summary), ScaleText(summary), IntrinsicsText(summary), MountText(summary),
      CarText(summary), TurnsText(summary), FramesText(summary), MissingText(summary), cost.wall_seconds,
      summary.frames / std::max(cost.wall_seconds, 1e-9), 1e3 * cost.cpu_seconds / std::max(summary.frames, 1),
      cost.peak_memory_mb, summary.folder);
}

}  // namespace turnscale

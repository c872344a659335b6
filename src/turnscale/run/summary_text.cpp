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
#include "turnscale/run/frame_warnings.h"
#include "turnscale/run/run_summary.h"

namespace turnscale {
namespace {

constexpr double kKilometresPerHour = 3.6;  // per m/s

// Empty where the whole path is measured.
std::string MissingText(const PathSummary& path, double first_time) {
  if (path.missing.empty()) return {};
  std::string text = fmt::format("missing {:.1f} s of {:.1f} s", TotalSeconds(path.missing), path.seconds);
  const std::vector<MissingPart> longest = LongestParts(path.missing, kShownMissingParts);
  for (size_t i = 0; i < longest.size(); ++i)
    text += (i == 0 ? ": " : "; ") + MissingPartText(SinceFirst(longest[i], first_time));
  if (const size_t more = path.missing.size() - longest.size(); more > 0)
    text += fmt::format("; and {} shorter part{}", more, more == 1 ? "" : "s");
  return text + "\n";
}

// One line, empty unless there are several.
std::string ClipsText(const std::vector<ClipPart>& clips) {
  if (clips.size() < 2) return {};
  return fmt::format("clips   {}, from {} to {}\n", clips.size(), clips.front().file, clips.back().file);
}

std::string TestOfCalibration(const ScaleSummary& scale, bool is_upside_down) {
  if (is_upside_down) return "not tested, as the images seem to be upside down";
  if (scale.calibration_in_doubt || (scale.image_lag && !scale.image_lag->is_used)) return "left in doubt by the turns";
  if (scale.calibration_windows > 0)
    return scale.calibration_agrees ? "consistent with the turns" : "contradicted by the turns";
  std::string text = "not tested, as no turn of the drive can test it";
  // The height of the camera scales with the focal length.
  if (scale.is_metric() && scale.turns_used == 0) text += "; an error of its focal length changes the scale";
  return text;
}

// The side of the image at which a step along `direction` ends.
const char* SideAt(const ReadDirection& direction) {
  if (direction.x != 0) return direction.x > 0 ? "right" : "left";
  return direction.y > 0 ? "bottom" : "top";
}

// One line; empty if the images show no rolling shutter.
std::string ShutterText(const ScaleSummary& scale) {
  if (!scale.readout) return {};
  const auto [x, y] = scale.readout->direction;
  const char* last = SideAt({x, y});
  const char* first = SideAt({-x, -y});
  const bool begins_first = scale.readout->seconds > 0;
  return fmt::format("shutter rolling, {:.1f} +-{:.1f} ms from the {} of the image to the {}{}\n",
                     1e3 * std::abs(scale.readout->seconds), 1e3 * scale.readout->sigma, begins_first ? first : last,
                     begins_first ? last : first, scale.readout->is_corrected ? "; corrected" : "");
}

// One line; empty before the first image.
std::string IntrinsicsText(const DriveFacts& drive, const ScaleSummary& scale) {
  const RunInput& given = drive.given;
  const std::optional<FoundCamera>& found = given.found_camera;
  const std::optional<Pinhole>& used = drive.camera.pinhole;
  if (!found && given.camera.empty())
    return used ? fmt::format("lens    focal length {:.1f} pixels, assumed\n", used->fx) : "";
  if (!found)
    return fmt::format("lens    calibration {}, {}\n", std::filesystem::path(given.camera).filename().string(),
                       TestOfCalibration(scale, drive.images.is_upside_down));
  const Pinhole& pinhole = found->camera.pinhole;
  return fmt::format(
      "lens    focal length {}, principal point ({:.1f}, {:.1f}) +-{:.1f} pixels, estimated; for the "
      "next drive: --camera {}\n",
      FocalLengthText(found->camera), pinhole.cx, pinhole.cy, found->centre_sigma,
      (std::filesystem::path(given.folder) / RunFiles::kCamera).string());
}

// Where a rotation comes from that the drive has not estimated.
std::string SourceOfRotation(const DriveFacts& drive, const std::optional<double>& contradicting_yaw) {
  if (drive.mount.estimate && !drive.vehicle.camera_known) return "assumed; no turn was suitable for estimating it";
  if (!contradicting_yaw) return "as given";
  return fmt::format("as given; the drive shows yaw {:+.2f} deg, which is used", InDegrees(*contradicting_yaw));
}

std::string Times(int count) { return count == 1 ? "once" : fmt::format("{} times", count); }

// Degrees as they are shown. Rounded here: else it may say -0.00.
double Rounded(double angle) { return std::round(100 * InDegrees(angle)) / 100 + 0.0; }

// The angles of the camera's rotation do not include what the estimate of the scale finds for its yaw. Empty where that
// finds nothing, is not reliable, so that the file of the car does not have it either, or the line says so already.
std::string YawCorrectionText(const CarSummary& car, int turns_used, double yaw) {
  const bool reliable = car.refined && car.evidence;
  if (!reliable || turns_used == 0 || car.contradicting_yaw) return {};
  const double correction = Rounded(car.refined->yaw_error);
  if (correction == 0) return {};
  return fmt::format("; the scale estimate corrects the yaw to {:+.2f} +-{:.2f} deg (by {:+.2f})",
                     Rounded(yaw + car.refined->yaw_error), InDegrees(car.refined->yaw_error_sigma), correction);
}

std::string KnockText(const MountSummary& mount) {
  const auto knocks = static_cast<int>(mount.jumps.size());
  return knocks > 0 ? "; turned by a knock " + Times(knocks) : "";
}

std::string MovesText(const std::vector<MountMove>& moves, double first_time) {
  const auto count = static_cast<int>(moves.size());
  const char* last = count == 1 ? "" : ", the last time";
  return fmt::format("moved {}{} {}", Times(count), last, CameraMoveText(moves.back(), first_time));
}

// One line.
std::string MountText(const RunSummary& summary) {
  const DriveFacts& drive = summary.drive;
  const std::optional<MountEstimate>& mount = drive.mount.estimate;
  const std::string knocks = KnockText(drive.mount);
  if (mount && mount->is_outdated)
    return fmt::format("camera  {}; no turn since that was noticed, so the rotation from before is used{}\n",
                       MovesText(mount->moves, drive.given.first_time), knocks);
  const YawPitchRoll angles = drive.camera_angles();
  const std::string correction = YawCorrectionText(summary.car, summary.scale.turns_used, angles.yaw);
  if (!mount || !mount->found)
    return fmt::format("camera  yaw {:+.2f}, pitch {:+.2f}, roll {:+.2f} deg, {}{}{}\n", Rounded(angles.yaw),
                       Rounded(angles.pitch), Rounded(angles.roll),
                       SourceOfRotation(drive, summary.car.contradicting_yaw), knocks, correction);
  const auto degrees = [](double angle) { return angle * kDegreesPerRadian; };
  std::string text = fmt::format(
      "camera  yaw {:+.2f} +-{:.2f}, pitch {:+.2f} +-{:.2f}, roll {:+.1f} +-{:.1f} deg, estimated from {}the drive",
      degrees(angles.yaw), degrees(mount->sigma.yaw), degrees(angles.pitch), degrees(mount->sigma.pitch),
      degrees(angles.roll), degrees(mount->sigma.roll),
      drive.vehicle.camera_known && mount->moves.empty() ? "the file of the car and " : "");
  if (!mount->moves.empty()) text += "; " + MovesText(mount->moves, drive.given.first_time);
  return text + knocks + correction + "\n";
}

// Length and frames of the path.
std::string PathText(const PathSummary& path, const FrameCounts& frames, bool is_metric) {
  constexpr double kLittle = 0.01;
  const char* unit = is_metric ? "m" : "units";
  std::string text = fmt::format("path    {:.2f} {} in {:.1f} s", path.distance, unit, path.seconds);
  if (is_metric && path.seconds > 0)
    text += fmt::format(" ({:.0f} km/h on average)", kKilometresPerHour * path.distance / path.seconds);
  text += fmt::format(", {} frames, {} keyframes", frames.total, frames.keyframes);
  if (path.missing_distance > kLittle * path.distance)
    text += fmt::format("; {:.2f} {} of it not measured", path.missing_distance, unit);
  return text + "\n";
}

// A height that only the drive tells is a check of the scale: both are wrong by the same factor.
std::string HeightText(const CarRefinement& car, const DriveFacts& drive, int turns_used) {
  const bool is_given = drive.vehicle.camera_height.has_value();
  const bool was_moved = drive.mount.estimate && !drive.mount.estimate->moves.empty();
  if (!(car.camera_height > 0)) return {};
  // Its sigma is that of the scale then, which another line has.
  if (is_given && turns_used == 0)
    return fmt::format("height  camera {:.3f} m above the road, as given\n", car.camera_height);
  return fmt::format("height  camera {:.3f} +-{:.3f} m above the road{}{}\n", car.camera_height,
                     car.camera_height_sigma, was_moved ? " before it was moved" : "",
                     is_given ? "" : " (compare with a tape measure)");
}

std::string SlipValue(double slip, double sigma) {
  return sigma > 0 ? fmt::format("{:.4f} +-{:.4f} s^2/m", slip, sigma) : fmt::format("{:.4f} s^2/m", slip);
}

// Empty without an estimate. Without a turn only the height is one.
std::string CarText(const std::optional<CarRefinement>& car, const DriveFacts& drive, int turns_used) {
  if (!car) return {};
  std::string text;
  if (turns_used > 0)
    text = fmt::format("car     side slip {}\n",
                       SideSlipText(*car, drive.vehicle.side_slip, drive.vehicle.side_slip_sigma));
  return text + HeightText(*car, drive, turns_used);
}

// Frames without a measured pose, by their state; empty if there are none.
std::string FramesText(const FrameCounts& frames, const ImageSummary& images) {
  std::string text;
  const auto add = [&](size_t count, const char* state) {
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, state);
  };
  add(static_cast<size_t>(frames.initializing), "before initialisation");
  add(static_cast<size_t>(frames.bridged), "bridged (tracking lost)");
  add(images.unreadable.size(), "unreadable");
  add(static_cast<size_t>(frames.repeated), "repeated");
  return text.empty() ? "" : "frames  without a measured pose: " + text + "\n";
}

// With the height of the camera alone, the scale may be known, but not from turns.
std::string TurnsText(const ScaleSummary& scale, bool has_lever_arm) {
  if (!has_lever_arm && scale.turns_found > 0)
    return fmt::format("turns   {} found; not used without --lever-arm\n", scale.turns_found);
  return fmt::format("turns   {} found, {} used\n", scale.turns_found, scale.turns_used);
}

std::string SigmaText(double sigma) {
  return sigma > kLargestShownSigma ? std::string("beyond +-100 %") : fmt::format("+-{:.1f} %", 100 * sigma);
}

std::string ScaleText(const ScaleSummary& scale, const DriveFacts& drive) {
  if (scale.is_metric()) {
    constexpr double kClearly = 1.05;
    // The length has errors beside that of the scale, as of parts that are not measured.
    const std::string length = SigmaText(scale.path_sigma);
    const std::string worst = SigmaText(scale.worst_sigma);
    const bool is_larger = scale.path_sigma > scale.worst_sigma && length != worst;
    return fmt::format(
        "{}, path length {} (1 sigma){}, {} at most {} (at {:.1f} s)", scale.is_known() ? "known" : "uncertain", length,
        scale.path_sigma > kClearly * scale.worst_sigma ? " including the parts that warnings name" : "",
        is_larger ? "by the scale alone" : "along the drive", worst, scale.worst_sigma_time - drive.given.first_time);
  }
  const std::string pending = ScaleStateName(scale.state);
  if (drive.has_measure()) return pending + ", " + UpToScaleText(scale.pending_reason);
  const std::string why = drive.wants_metres()
                              ? ", " + UpToScaleText(scale.pending_reason)
                              : ": without --lever-arm, --camera-height or --vehicle the trajectory is up to scale";
  return fmt::format("{}{}; turnscale rescale {} --lever-arm METRES converts it to metres", pending, why,
                     drive.given.folder);
}

// One line; empty where no sigma is large.
std::string SigmaReasonText(const ScaleSummary& scale) {
  return scale.sigma_reason.empty() ? "" : fmt::format("sigma   large: {}\n", scale.sigma_reason);
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
    text += fmt::format(" (vertically {:.1f}, as pixels are {:.3f}{} times as wide as high)", camera.pinhole.fy, aspect,
                        camera.aspect_sigma > 0 ? fmt::format(" +-{:.3f}", camera.aspect_sigma * aspect) : "");
  return text;
}

std::string SummaryText(const RunSummary& summary) {
  const DriveFacts& drive = summary.drive;
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
      "{}"
      "{}"
      "time    {:.1f} s elapsed ({:.1f} frames/s), {:.1f} ms of CPU time per frame over the whole run, {:.0f} MB of "
      "memory\n"
      "files   {}\n",
      ClipsText(drive.ending.clips), PathText(summary.path, summary.frames, summary.scale.is_metric()),
      ScaleText(summary.scale, drive), SigmaReasonText(summary.scale), IntrinsicsText(drive, summary.scale),
      ShutterText(summary.scale), MountText(summary), CarText(summary.car.refined, drive, summary.scale.turns_used),
      TurnsText(summary.scale, drive.vehicle.lever_arm.has_value()), FramesText(summary.frames, drive.images),
      MissingText(summary.path, drive.given.first_time), cost.wall_seconds,
      summary.frames.total / std::max(cost.wall_seconds, 1e-9),
      1e3 * cost.cpu_seconds / std::max(summary.frames.total, 1), cost.peak_memory_mb, drive.given.folder);
}

}  // namespace turnscale

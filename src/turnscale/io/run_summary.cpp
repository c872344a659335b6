// SPDX-License-Identifier: MIT
#include "turnscale/io/run_summary.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "turnscale/base/number_text.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/terminal.h"
#include "turnscale/io/time_check.h"
#include "turnscale/io/turn_warning.h"

namespace turnscale {
namespace {

constexpr size_t kShownParts = 5;  // of the missing path

// Relative sigma of the path length beyond which the scale is not called known.
constexpr double kMostKnown = 0.15;

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

bool IsMetric(const RunSummary& summary) { return summary.scale_state != ScaleState::kPending; }

nlohmann::ordered_json CostJson(const RunSummary& summary) {
  const RunCost& cost = summary.cost;
  const int frames = std::max(summary.frames, 1);
  nlohmann::ordered_json json = {{"wall_s", cost.wall_seconds},
                                 {"cpu_s", cost.cpu_seconds},
                                 {"frames_per_s", summary.frames / std::max(cost.wall_seconds, 1e-9)},
                                 {"cpu_ms_per_frame", 1e3 * cost.cpu_seconds / frames},
                                 {"peak_memory_mb", cost.peak_memory_mb}};
  if (cost.latency)
    json["latency_ms"] = {{"median", cost.latency->median},
                          {"percentile_99", cost.latency->percentile_99},
                          {"largest", cost.latency->largest}};
  return json;
}

nlohmann::ordered_json ClipsJson(const std::vector<ClipPart>& clips) {
  auto json = nlohmann::ordered_json::array();
  for (const ClipPart& clip : clips) {
    json.push_back({{"file", clip.file},
                    {"start_s", clip.start},
                    {"end_s", clip.end},
                    {"frames", clip.frames},
                    {"gap_before_s", clip.gap_before}});
  }
  return json;
}

nlohmann::ordered_json MissingJson(const RunSummary& summary) {
  auto parts = nlohmann::ordered_json::array();
  for (const MissingPart& part : LongestParts(summary.missing, kShownParts)) {
    parts.push_back({{"reason", MissingReasonName(part.reason)},
                     {"from_s", part.from},
                     {"to_s", part.to},
                     {"frames", part.frames}});
  }
  return {{"seconds", TotalSeconds(summary.missing)},
          {"of_s", summary.seconds},
          {"distance_m", IsMetric(summary) ? nlohmann::ordered_json(summary.missing_distance) : nullptr},
          {"parts", summary.missing.size()},
          {"longest", parts}};
}

// Empty where the whole path is measured.
std::string MissingText(const RunSummary& summary) {
  if (summary.missing.empty()) return {};
  std::string text = fmt::format("missing {:.1f} s of {:.1f} s", TotalSeconds(summary.missing), summary.seconds);
  const std::vector<MissingPart> longest = LongestParts(summary.missing, kShownParts);
  for (size_t i = 0; i < longest.size(); ++i) text += (i == 0 ? ": " : "; ") + MissingPartText(longest[i]);
  if (const size_t more = summary.missing.size() - longest.size(); more > 0)
    text += fmt::format("; and {} shorter part{}", more, more == 1 ? "" : "s");
  return text + "\n";
}

nlohmann::ordered_json MountJson(const std::optional<MountSummary>& mount) {
  if (!mount) return {{"source", "given"}};
  if (!mount->found) return {{"source", mount->moves > 0 ? "before the move" : "assumed"}, {"moves", mount->moves}};
  return {{"source", "found"},
          {"sigma_yaw_pitch_roll_deg",
           {mount->sigma.yaw * kDegreesPerRadian, mount->sigma.pitch * kDegreesPerRadian,
            mount->sigma.roll * kDegreesPerRadian}},
          {"moves", mount->moves}};
}

// One line, empty unless there are several.
std::string ClipsText(const std::vector<ClipPart>& clips) {
  if (clips.size() < 2) return {};
  return fmt::format("clips   {}, from {} to {}\n", clips.size(), clips.front().file, clips.back().file);
}

const char* IntrinsicsSource(const RunSummary& summary) {
  if (!summary.found_camera) return summary.camera.empty() ? "assumed" : "given";
  return summary.camera.empty() ? "estimated" : "refined";
}

nlohmann::ordered_json IntrinsicsJson(const RunSummary& summary) {
  const std::optional<FoundCamera>& found = summary.found_camera;
  const std::optional<Pinhole> pinhole = found ? found->camera.pinhole : summary.pinhole;
  nlohmann::ordered_json json = {{"source", IntrinsicsSource(summary)}};
  if (summary.image_width > 0) json["image_size"] = {summary.image_width, summary.image_height};
  if (pinhole) {
    json["focal_length"] = {pinhole->fx, pinhole->fy};
    json["principal_point"] = {pinhole->cx, pinhole->cy};
  }
  const std::optional<LensModel> lens = found ? found->camera.lens : summary.lens_model;
  if (lens) json["lens_model"] = LensModelName(*lens);
  if (!found) return json;
  json["focal_length_sigma"] = found->camera.focal_sigma;
  json["principal_point_sigma"] = found->centre_sigma;
  json["windows"] = found->windows;
  json["converged"] = found->converged;
  return json;
}

// One line, empty where the intrinsics were given.
std::string IntrinsicsText(const std::optional<FoundCamera>& found, const std::string& folder) {
  if (!found) return {};
  const Pinhole& pinhole = found->camera.pinhole;
  return fmt::format(
      "lens    focal length {:.1f} +-{:.1f}, principal point ({:.1f}, {:.1f}) +-{:.1f} pixels, estimated; for the "
      "next drive: --camera {}\n",
      pinhole.fx, found->camera.focal_sigma, pinhole.cx, pinhole.cy, found->centre_sigma,
      (std::filesystem::path(folder) / RunFiles::kCamera).string());
}

// One line, empty where the rotation was given.
// The camera-to-vehicle rotation in use.
std::string MountText(const RunSummary& summary) {
  const std::optional<MountSummary>& mount = summary.mount;
  if (mount && !mount->found && mount->moves > 0)
    return fmt::format("camera  moved {} times; no turn since, so the rotation from before the move is used\n",
                       mount->moves);
  if (!mount || !mount->found) {
    const YawPitchRoll angles = mount ? mount->angles : YawPitchRollFromRotation(summary.vehicle.vehicle_from_camera);
    // Rounded first: else it may say -0.00.
    const auto degrees = [](double angle) { return std::round(100 * InDegrees(angle)) / 100 + 0.0; };
    return fmt::format("camera  yaw {:+.2f}, pitch {:+.2f}, roll {:+.2f} deg, {}\n", degrees(angles.yaw),
                       degrees(angles.pitch), degrees(angles.roll),
                       mount && !summary.vehicle.camera_known ? "assumed, since no turn is suited to estimate it"
                       : summary.contradicts_mount            ? "as given, contradicted by the drive"
                                                              : "as given");
  }
  const auto degrees = [](double angle) { return angle * kDegreesPerRadian; };
  std::string text = fmt::format(
      "camera  yaw {:+.2f} +-{:.2f}, pitch {:+.2f} +-{:.2f}, roll {:+.1f} +-{:.1f} deg, estimated from the drive",
      degrees(mount->angles.yaw), degrees(mount->sigma.yaw), degrees(mount->angles.pitch), degrees(mount->sigma.pitch),
      degrees(mount->angles.roll), degrees(mount->sigma.roll));
  if (mount->moves > 0) text += fmt::format("; moved {} times", mount->moves);
  return text + "\n";
}

nlohmann::ordered_json CarJson(const std::optional<CarRefinement>& car) {
  if (!car) return nullptr;
  const auto known = [](double value) {
    return value > 0 ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
  };
  return {{"side_slip_s2_per_m", car->side_slip},
          {"side_slip_sigma_s2_per_m", car->side_slip_sigma},
          {"side_slip_at_bound", car->side_slip_at_bound},
          {"yaw_error_deg", car->yaw_error * kDegreesPerRadian},
          {"yaw_error_sigma_deg", car->yaw_error_sigma * kDegreesPerRadian},
          {"lever_arm_m", known(car->lever_arm)},
          {"lever_arm_sigma_m", known(car->lever_arm_sigma)},
          {"camera_height_m", known(car->camera_height)},
          {"camera_height_sigma_m", known(car->camera_height_sigma)}};
}

nlohmann::ordered_json BeliefJson(const CarBelief& belief) {
  nlohmann::ordered_json covariance = nlohmann::ordered_json::array();
  for (int row = 0; row < 4; ++row) {
    const Eigen::RowVector4d cells = belief.covariance.row(row);
    covariance.push_back({cells[0], cells[1], cells[2], cells[3]});
  }
  return {{"mean", {belief.mean[0] + 0.0, belief.mean[1], belief.mean[2], belief.mean[3]}}, {"covariance", covariance}};
}

nlohmann::ordered_json EvidenceJson(const std::optional<CarEvidence>& evidence) {
  if (!evidence) return nullptr;
  return {{"unknowns", {"yaw_error_rad", "side_slip_s2_per_m", "log_lever_arm", "log_camera_height"}},
          {"prior", BeliefJson(evidence->prior)},
          {"posterior", BeliefJson(evidence->posterior)},
          {"inflation", evidence->inflation}};
}

// Length and frames of the path.
std::string PathText(const RunSummary& summary) {
  constexpr double kLittle = 0.01;
  const char* unit = IsMetric(summary) ? "m" : "units";
  std::string text = fmt::format("path    {:.2f} {} in {} frames, {} keyframes", summary.distance, unit, summary.frames,
                                 summary.keyframes);
  if (summary.missing_distance > kLittle * summary.distance)
    text += fmt::format("; {:.2f} {} of it not measured", summary.missing_distance, unit);
  return text + "\n";
}

std::string HeightText(const CarRefinement& car) {
  if (!(car.camera_height > 0)) return {};
  return fmt::format("height  camera {:.3f} +-{:.3f} m above the road\n", car.camera_height, car.camera_height_sigma);
}

// Empty without an estimate. Without a turn only the height is one.
std::string CarText(const std::optional<CarRefinement>& car, int turns_used) {
  if (!car) return {};
  if (turns_used == 0) return HeightText(*car);
  std::string slip;
  if (car->side_slip_at_bound) {
    slip = "side slip 0, since the estimate would be negative: check lever arm and timestamps; ";
  } else if (car->side_slip_sigma > 0) {
    slip = fmt::format("side slip {:.4f} +-{:.4f} s^2/m, ", car->side_slip, car->side_slip_sigma);
  }
  return fmt::format("car     {}remaining yaw error of the camera {:+.2f} +-{:.2f} deg, from all turns\n{}", slip,
                     car->yaw_error * kDegreesPerRadian, car->yaw_error_sigma * kDegreesPerRadian, HeightText(*car));
}

std::string CalibrationWarning(const ParameterEstimate& estimate, bool refined, double scale_sigma) {
  const auto [name, unit] = [&]() -> std::pair<const char*, const char*> {
    switch (estimate.parameter) {
      case IntrinsicsParameter::kFocalLength:
        return {"focal length", " pixels"};
      case IntrinsicsParameter::kCentreX:
        return {"horizontal principal point", " pixels"};
      case IntrinsicsParameter::kCentreY:
        return {"vertical principal point", " pixels"};
      case IntrinsicsParameter::kDistortion:
        return {"radial correction", ""};
    }
    return {"", ""};
  }();
  return fmt::format(
      "the images of turns give a {} of {:.4g} +- {:.2g}{}, the calibration {:.4g}: check that it is this "
      "camera's{}{}",
      name, estimate.found, estimate.sigma, unit, estimate.given,
      refined ? "" : ", or have it estimated with --camera-refine",
      std::isfinite(scale_sigma) ? fmt::format("; the scale may be off by {:.0f} % or more", 100 * scale_sigma) : "");
}

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
                    name(summary.clips[i - 1]), name(clip), clip.start));
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
      "is "
      "wrong by the same factor: check --lever-arm{}, or give the measured --camera-height",
      car.camera_height, car.camera_height_sigma,
      car.camera_height < kLeast ? " and that the video is not stabilised" : "");
}

// What to do about a camera-to-vehicle rotation that is wrong.
std::string RotationRemedy(const VehicleOptions& vehicle) {
  if (!vehicle.calibrate_camera) return "correct --camera-rotation, or leave it out to have it estimated";
  if (vehicle.camera_known) return kCheckVehicle;
  return "check whether the camera was moved";
}

}  // namespace

std::optional<FrameLatency> LatencyOf(const std::vector<double>& seconds) {
  if (seconds.empty()) return std::nullopt;
  return FrameLatency{1e3 * Median(seconds), 1e3 * Quantile(seconds, 0.99), 1e3 * Quantile(seconds, 1)};
}

RunCost MeasureCost() {
  using Clock = std::chrono::steady_clock;
  static const Clock::time_point start = Clock::now();
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  RunCost cost;
  cost.wall_seconds = std::chrono::duration<double>(Clock::now() - start).count();
  cost.cpu_seconds = Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
  cost.peak_memory_mb = static_cast<double>(usage.ru_maxrss) / 1024.0;
  return cost;
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

void Summarize(const std::vector<FrameResult>& refined, const RefinedScale& scale, RunSummary& summary) {
  const std::vector<TurnResult>& turns = scale.turns;
  summary.frames = static_cast<int>(refined.size());
  summary.missing = FindMissingParts(refined);
  const FrameResult* last = nullptr;
  for (const FrameResult& frame : refined) {
    summary.tracked += frame.state == TrackingState::kTracked ? 1 : 0;
    summary.repeated += frame.state == TrackingState::kRepeated ? 1 : 0;
    summary.bridged += frame.state == TrackingState::kBridged ? 1 : 0;
    summary.initializing += frame.state == TrackingState::kInitializing ? 1 : 0;
    summary.keyframes += frame.keyframe ? 1 : 0;
    if (!frame.world_from_camera) continue;
    if (last) {
      const double step = (frame.world_from_camera->translation - last->world_from_camera->translation).norm();
      summary.distance += step;
      if (IsMissing(summary.missing, last->time, frame.time)) summary.missing_distance += step;
    }
    last = &frame;
    if (summary.worst_sigma >= frame.scale_sigma) continue;
    summary.worst_sigma = frame.scale_sigma;
    summary.worst_sigma_time = frame.time;
  }
  if (!refined.empty()) summary.seconds = refined.back().time - refined.front().time;
  const double scale_sigma = scale.estimate ? scale.estimate->length_sigma : INFINITY;
  summary.path_sigma = std::hypot(scale_sigma, scale.gap_sigma / std::max(summary.distance, 1e-9));
  if (scale.estimate) {
    if (!scale.estimate->fell_back) summary.car = scale.estimate->car;
    summary.turn_test = scale.estimate->test;
    summary.height_conflict = scale.estimate->height_conflict;
    if (!scale.estimate->fell_back && !scale.estimate->height_conflict)
      summary.car_evidence = scale.estimate->car_evidence;
  }
  for (const ParameterEstimate& estimate : scale.contradicted_calibration)
    summary.warnings.push_back(CalibrationWarning(estimate, summary.found_camera.has_value(), scale_sigma));
  const auto frames_of = [&](int turn) {
    return fmt::format("frames {}-{}", turns[turn].first_frame, turns[turn].last_frame);
  };
  const std::string warning =
      scale.estimate ? TurnWarning(*scale.estimate, frames_of,
                                   "the camera's calibration and rotation, the timestamps and the lever arm")
                     : "";
  if (!warning.empty()) summary.warnings.push_back(warning);
  if (summary.height_conflict)
    summary.warnings.push_back(HeightWarning(*summary.height_conflict, summary.vehicle.lever_arm.value_or(0),
                                             summary.vehicle.camera_known ? kCheckVehicle : "measure both again"));
  if (summary.car && summary.car->camera_height > 0 && !summary.vehicle.camera_height) {
    const std::string unusual = UnusualHeight(*summary.car);
    if (!unusual.empty()) summary.warnings.push_back(unusual);
  }
  if (scale.estimate && scale.estimate->yaw_conflict) {
    summary.contradicts_mount = true;
    summary.warnings.push_back(YawWarning(*scale.estimate->yaw_conflict, RotationRemedy(summary.vehicle)));
  }
  std::ranges::move(TimeWarnings(refined, turns), std::back_inserter(summary.warnings));
  std::ranges::move(SeamWarnings(summary), std::back_inserter(summary.warnings));
  summary.turns_found = static_cast<int>(turns.size());
  if (!scale.estimate) {
    summary.pending_reason = scale.reason;
    if (!scale.contradicted_calibration.empty())
      summary.pending_reason += "; the images contradict the calibration, which may be the cause";
  }
  summary.turns_used =
      static_cast<int>(std::count_if(turns.begin(), turns.end(), [](const auto& t) { return t.used; }));
}

std::string FoundCameraText(const FoundCamera& found) {
  return CameraFileText(found.camera) + "principal_point_sigma: " + NumberText(found.centre_sigma) + "\n";
}

std::string SummaryJson(const RunSummary& summary) {
  using Json = nlohmann::ordered_json;
  const YawPitchRoll angles =
      summary.mount ? summary.mount->angles : YawPitchRollFromRotation(summary.vehicle.vehicle_from_camera);
  Json unreadable = Json::array();
  for (const UnreadableFrame& frame : summary.unreadable) {
    unreadable.push_back({{"frame", frame.frame}, {"problem", frame.problem}});
  }
  const auto or_null = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  const Json json = {
      {"version", summary.version},
      {"input", summary.input},
      {"topic", summary.topic.empty() ? Json(nullptr) : Json(summary.topic)},
      {"part",
       {{"start", summary.start.empty() ? Json(nullptr) : Json(summary.start)},
        {"end", summary.end.empty() ? Json(nullptr) : Json(summary.end)}}},
      {"clips", ClipsJson(summary.clips)},
      {"camera", summary.camera.empty() ? Json(nullptr) : Json(summary.camera)},
      {"intrinsics", IntrinsicsJson(summary)},
      {"mask", summary.mask.empty() ? Json(nullptr) : Json(summary.mask)},
      {"pose_frame", summary.pose_frame},
      {"lever_arm_m", summary.vehicle.lever_arm ? Json(*summary.vehicle.lever_arm) : Json(nullptr)},
      {"side_slip_s2_per_m", summary.vehicle.side_slip},
      {"camera_height_m", summary.vehicle.camera_height ? Json(*summary.vehicle.camera_height) : Json(nullptr)},
      {"camera_yaw_pitch_roll_deg",
       {angles.yaw * kDegreesPerRadian + 0.0, angles.pitch * kDegreesPerRadian + 0.0,
        angles.roll * kDegreesPerRadian + 0.0}},
      {"camera_rotation", MountJson(summary.mount)},
      {"by_all_turns", CarJson(summary.car)},
      {"car_evidence", EvidenceJson(summary.car_evidence)},
      {"complete", summary.stopped.empty()},
      {"stopped", summary.stopped.empty() ? Json(nullptr) : Json(summary.stopped)},
      {"frames",
       {{"total", summary.frames},
        {"tracked", summary.tracked},
        {"repeated", summary.repeated},
        {"bridged", summary.bridged},
        {"initializing", summary.initializing},
        {"unreadable", summary.unreadable.size()},
        {"keyframes", summary.keyframes}}},
      {"unreadable", unreadable},
      {"missing", MissingJson(summary)},
      {"distance_m", IsMetric(summary) ? Json(summary.distance) : Json(nullptr)},
      {"distance_units", IsMetric(summary) ? Json(nullptr) : Json(summary.distance)},
      {"path_sigma", or_null(summary.path_sigma)},
      {"scale",
       {{"state", ScaleStateName(summary.scale_state)},
        {"pending_reason", summary.pending_reason.empty() ? Json(nullptr) : Json(summary.pending_reason)},
        {"worst_relative_sigma", or_null(summary.worst_sigma)},
        {"worst_at_s", summary.worst_sigma_time}}},
      {"warnings", summary.warnings},
      {"lens",
       summary.lens ? Json{{"correction", summary.lens->correction}, {"sigma", summary.lens->sigma}} : Json(nullptr)},
      {"turns",
       {{"found", summary.turns_found},
        {"used", summary.turns_used},
        {"chi_squared", summary.turn_test.chi_squared},
        {"degrees_of_freedom", summary.turn_test.degrees_of_freedom}}},
      {"cost", CostJson(summary)}};
  // Names of files may not be valid UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string SummaryText(const RunSummary& summary) {
  std::string scale = ScaleStateName(summary.scale_state);
  if (IsMetric(summary)) scale = summary.path_sigma <= kMostKnown ? "known" : "uncertain";
  if (IsMetric(summary))
    scale += fmt::format(", path length +-{:.1f} % (1 sigma), along the drive at most +-{:.1f} % (at {:.1f} s)",
                         100 * summary.path_sigma, 100 * summary.worst_sigma, summary.worst_sigma_time);
  if (!IsMetric(summary)) {
    const bool given = summary.vehicle.lever_arm || summary.vehicle.camera_height;
    scale += given ? ", the trajectory is up to scale"
                   : ": without --lever-arm or --camera-height the trajectory is up to scale; with a lever arm, "
                     "turnscale rescale " +
                         summary.folder + " converts it";
    if (given && !summary.pending_reason.empty()) scale += ": " + summary.pending_reason;
  }
  const RunCost& cost = summary.cost;
  return fmt::format(
      "{}"
      "{}"
      "scale   {}\n"
      "{}"
      "{}"
      "{}"
      "turns   {} found, {} used\n"
      "frames  {} bridged, {} unreadable, {} repeated; {} before initialisation\n"
      "{}"
      "speed   {:.1f} frames/s, {:.1f} ms of CPU time per frame over the whole run, {:.0f} MB of memory\n"
      "files   {}\n",
      ClipsText(summary.clips), PathText(summary), scale, IntrinsicsText(summary.found_camera, summary.folder),
      MountText(summary), CarText(summary.car, summary.turns_used), summary.turns_found, summary.turns_used,
      summary.bridged, summary.unreadable.size(), summary.repeated, summary.initializing, MissingText(summary),
      summary.frames / std::max(cost.wall_seconds, 1e-9), 1e3 * cost.cpu_seconds / std::max(summary.frames, 1),
      cost.peak_memory_mb, summary.folder);
}

}  // namespace turnscale

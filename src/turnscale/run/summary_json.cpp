// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "turnscale/camera/camera_file.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/results.h"
#include "turnscale/run/run_summary.h"

namespace turnscale {
namespace {

nlohmann::ordered_json CostJson(const RunSummary& summary) {
  const RunCost& cost = summary.cost;
  const int frames = std::max(summary.frames.total, 1);
  nlohmann::ordered_json json = {{"wall_s", cost.wall_seconds},
                                 {"cpu_s", cost.cpu_seconds},
                                 {"frames_per_s", summary.frames.total / std::max(cost.wall_seconds, 1e-9)},
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

nlohmann::ordered_json MissingJson(const PathSummary& path, const std::vector<MapRestart>& starts, bool is_metric) {
  auto parts = nlohmann::ordered_json::array();
  for (const MissingPart& part : LongestParts(path.missing, kShownMissingParts)) {
    parts.push_back({{"reason", MissingReasonName(part.reason)},
                     {"from_s", part.from},
                     {"to_s", part.to},
                     {"frames", part.frames}});
  }
  auto restarts = nlohmann::ordered_json::array();
  for (const MapRestart& restart : starts)
    restarts.push_back({{"frame", restart.frame},
                        {"time_s", restart.time},
                        {"unit_sigma", restart.unit_sigma},
                        {"turn_measured", restart.turn_is_measured},
                        {"turn_sigma_deg", InDegrees(restart.turn_sigma)}});
  return {{"seconds", TotalSeconds(path.missing)},
          {"of_s", path.seconds},
          {"distance_m", is_metric ? nlohmann::ordered_json(path.missing_distance) : nullptr},
          {"parts", path.missing.size()},
          {"longest", parts},
          {"restarts", restarts}};
}

const char* RotationSource(const DriveFacts& drive) {
  if (!drive.mount.estimate) return "given";
  if (drive.mount.estimate->found) return "found";
  if (drive.mount.estimate->is_outdated) return "before the move";
  return drive.vehicle.camera_known ? "given" : "assumed";
}

nlohmann::ordered_json MountJson(const DriveFacts& drive, const std::optional<double>& contradicting_yaw) {
  nlohmann::ordered_json json = {{"source", RotationSource(drive)}};
  if (const std::optional<MountEstimate>& mount = drive.mount.estimate) {
    if (mount->found)
      json["sigma_yaw_pitch_roll_deg"] = {mount->sigma.yaw * kDegreesPerRadian, mount->sigma.pitch * kDegreesPerRadian,
                                          mount->sigma.roll * kDegreesPerRadian};
    json["moves"] = nlohmann::ordered_json::array();
    for (const MountMove& move : mount->moves)
      json["moves"].push_back({{"time_s", move.time},
                               {"yaw_deg", move.by.yaw * kDegreesPerRadian},
                               {"pitch_deg", move.by.pitch * kDegreesPerRadian}});
  }
  json["knocks"] = nlohmann::ordered_json::array();
  for (const MountJump& jump : drive.mount.jumps)
    json["knocks"].push_back(
        {{"frame", jump.first_frame}, {"time_s", jump.time}, {"yaw_deg", jump.yaw * kDegreesPerRadian}});
  if (contradicting_yaw) json["contradicting_yaw_deg"] = InDegrees(*contradicting_yaw);
  return json;
}

nlohmann::ordered_json StabilisationJson(const ScaleSummary& scale) {
  if (!scale.image_lag && !scale.image_smoothing) return nullptr;
  nlohmann::ordered_json json;
  if (const std::optional<ImageLag>& lag = scale.image_lag) {
    json["lag_s"] = lag->found;
    json["lag_sigma_s"] = lag->found_sigma;
    json["lag_used"] = lag->is_used;
    json["lag_confirmed"] = lag->is_confirmed();
  }
  if (const std::optional<ImageSmoothing>& smoothing = scale.image_smoothing)
    json["smoothing_s"] = std::sqrt(smoothing->variance);
  return json;
}

const char* IntrinsicsSource(const RunInput& given) {
  if (!given.found_camera) return given.camera.empty() ? "assumed" : "given";
  return given.camera.empty() ? "estimated" : "refined";
}

nlohmann::ordered_json IntrinsicsJson(const DriveFacts& drive, const ScaleSummary& scale) {
  const std::optional<FoundCamera>& found = drive.given.found_camera;
  const std::optional<Pinhole> pinhole = found ? found->camera.pinhole : drive.camera.pinhole;
  nlohmann::ordered_json json = {{"source", IntrinsicsSource(drive.given)}};
  if (drive.images.width > 0) json["image_size"] = {drive.images.width, drive.images.height};
  if (pinhole) {
    json["focal_length"] = {pinhole->fx, pinhole->fy};
    json["principal_point"] = {pinhole->cx, pinhole->cy};
  }
  const std::optional<LensModel> lens = found ? found->camera.lens : drive.camera.lens_model;
  if (lens) json["lens_model"] = LensModelName(*lens);
  if (scale.readout) {
    json["readout_ms"] = 1e3 * scale.readout->seconds;
    json["readout_sigma_ms"] = 1e3 * scale.readout->sigma;
    json["readout_direction"] = ReadDirectionName(scale.readout->direction);
  }
  if (!found) {
    json["tested"] = scale.calibration_windows > 0;
    json["contradicted"] = scale.calibration_windows > 0 && !scale.calibration_agrees;
    json["in_doubt"] = scale.calibration_in_doubt;
    return json;
  }
  json["focal_length_sigma"] = found->camera.focal_sigma;
  if (found->camera.aspect_sigma > 0) json["pixel_aspect_sigma"] = found->camera.aspect_sigma;
  json["principal_point_sigma"] = found->centre_sigma;
  json["windows"] = found->windows;
  json["converged"] = found->converged;
  return json;
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

// Zeros have no sign.
nlohmann::ordered_json BeliefJson(const CarBelief& belief) {
  nlohmann::ordered_json covariance = nlohmann::ordered_json::array();
  for (int row = 0; row < 4; ++row) {
    const Eigen::RowVector4d cells = belief.covariance.row(row).array() + 0.0;
    covariance.push_back({cells[0], cells[1], cells[2], cells[3]});
  }
  return {{"mean", {belief.mean[0] + 0.0, belief.mean[1] + 0.0, belief.mean[2] + 0.0, belief.mean[3] + 0.0}},
          {"covariance", covariance}};
}

nlohmann::ordered_json EvidenceJson(const std::optional<CarEvidence>& evidence) {
  if (!evidence) return nullptr;
  return {{"unknowns", {"yaw_error_rad", "side_slip_s2_per_m", "log_lever_arm", "log_camera_height"}},
          {"prior", BeliefJson(evidence->prior)},
          {"posterior", BeliefJson(evidence->posterior)},
          {"inflation", evidence->inflation}};
}

}  // namespace

std::string SummaryJson(const RunSummary& summary) {
  using Json = nlohmann::ordered_json;
  const DriveFacts& drive = summary.drive;
  const RunInput& given = drive.given;
  const FrameCounts& frames = summary.frames;
  const ScaleSummary& scale = summary.scale;
  const YawPitchRoll angles = drive.camera_angles();
  Json unreadable = Json::array();
  for (const UnreadableFrame& frame : drive.images.unreadable) {
    unreadable.push_back({{"frame", frame.frame}, {"problem", frame.problem}});
  }
  const auto or_null = [](double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); };
  const Json json = {
      {"version", given.version},
      {"input", given.input},
      {"topic", given.topic.empty() ? Json(nullptr) : Json(given.topic)},
      {"part",
       {{"start", given.start.empty() ? Json(nullptr) : Json(given.start)},
        {"end", given.end.empty() ? Json(nullptr) : Json(given.end)}}},
      {"first_frame_s", given.first_time},
      {"recorded_from", given.recorded_from.empty() ? Json(nullptr) : Json(given.recorded_from)},
      {"clips", ClipsJson(drive.ending.clips)},
      {"camera", given.camera.empty() ? Json(nullptr) : Json(given.camera)},
      {"intrinsics", IntrinsicsJson(drive, scale)},
      {"rotate_deg", given.rotate},
      {"mask", given.mask.empty() ? Json(nullptr) : Json(given.mask)},
      {"pose_frame", given.pose_frame},
      {"lever_arm_m", drive.vehicle.lever_arm ? Json(*drive.vehicle.lever_arm) : Json(nullptr)},
      {"side_slip_s2_per_m", drive.vehicle.side_slip},
      {"camera_height_m", drive.vehicle.camera_height ? Json(*drive.vehicle.camera_height) : Json(nullptr)},
      {"camera_yaw_pitch_roll_deg",
       {angles.yaw * kDegreesPerRadian + 0.0, angles.pitch * kDegreesPerRadian + 0.0,
        angles.roll * kDegreesPerRadian + 0.0}},
      {"camera_rotation", MountJson(drive, summary.car.contradicting_yaw)},
      {"image_stabilisation", StabilisationJson(scale)},
      {"by_all_turns", CarJson(summary.car.refined)},
      {"car_evidence", EvidenceJson(summary.car.evidence)},
      {"complete", drive.ending.stopped.empty()},
      {"stopped", drive.ending.stopped.empty() ? Json(nullptr) : Json(drive.ending.stopped)},
      {"frames",
       {{"total", frames.total},
        {"tracked", frames.tracked},
        {"repeated", frames.repeated},
        {"bridged", frames.bridged},
        {"initializing", frames.initializing},
        {"unreadable", drive.images.unreadable.size()},
        {"keyframes", frames.keyframes}}},
      {"unreadable", unreadable},
      {"failed_adjustments", drive.failed_adjustments},
      {"missing", MissingJson(summary.path, drive.restarts, scale.is_metric())},
      {"distance_m", scale.is_metric() ? Json(summary.path.distance) : Json(nullptr)},
      {"distance_units", scale.is_metric() ? Json(nullptr) : Json(summary.path.distance)},
      {"path_sigma", or_null(scale.path_sigma)},
      {"scale",
       {{"state", ScaleStateName(scale.state)},
        {"known", scale.is_known()},
        {"pending_reason", scale.pending_reason.empty() ? Json(nullptr) : Json(scale.pending_reason)},
        {"worst_relative_sigma", or_null(scale.worst_sigma)},
        {"worst_at_s", std::isfinite(scale.worst_sigma) ? Json(scale.worst_sigma_time) : Json(nullptr)},
        {"sigma_reason", scale.sigma_reason.empty() ? Json(nullptr) : Json(scale.sigma_reason)},
        {"live_metres_from_s", drive.live_metric_from ? Json(*drive.live_metric_from) : Json(nullptr)}}},
      {"warnings", summary.warnings},
      {"lens", drive.camera.correction ? Json{{"correction", drive.camera.correction->correction},
                                              {"sigma", drive.camera.correction->sigma}}
                                       : Json(nullptr)},
      {"turns",
       {{"found", scale.turns_found},
        {"used", scale.turns_used},
        {"chi_squared", scale.turn_test.chi_squared},
        {"degrees_of_freedom", scale.turn_test.degrees_of_freedom}}},
      {"cost", CostJson(summary)}};
  // Names of files may not be valid UTF-8.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/results.h"
#include "turnscale/run/run_summary.h"

namespace turnscale {
namespace {

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
  for (const MissingPart& part : LongestParts(summary.missing, kShownMissingParts)) {
    parts.push_back({{"reason", MissingReasonName(part.reason)},
                     {"from_s", part.from},
                     {"to_s", part.to},
                     {"frames", part.frames}});
  }
  auto restarts = nlohmann::ordered_json::array();
  for (const MapRestart& restart : summary.restarts)
    restarts.push_back({{"frame", restart.frame}, {"time_s", restart.time}, {"unit_sigma", restart.unit_sigma}});
  return {{"seconds", TotalSeconds(summary.missing)},
          {"of_s", summary.seconds},
          {"distance_m", summary.is_metric() ? nlohmann::ordered_json(summary.missing_distance) : nullptr},
          {"parts", summary.missing.size()},
          {"longest", parts},
          {"restarts", restarts}};
}

const char* RotationSource(const RunSummary& summary) {
  if (!summary.mount) return "given";
  if (summary.mount->found) return "found";
  if (summary.mount->is_outdated) return "before the move";
  return summary.vehicle.camera_known ? "given" : "assumed";
}

nlohmann::ordered_json MountJson(const RunSummary& summary) {
  nlohmann::ordered_json json = {{"source", RotationSource(summary)}};
  if (const std::optional<MountSummary>& mount = summary.mount) {
    if (mount->found)
      json["sigma_yaw_pitch_roll_deg"] = {mount->sigma.yaw * kDegreesPerRadian, mount->sigma.pitch * kDegreesPerRadian,
                                          mount->sigma.roll * kDegreesPerRadian};
    json["moves"] = mount->moves;
  }
  json["knocks"] = nlohmann::ordered_json::array();
  for (const MountJump& jump : summary.camera_jumps)
    json["knocks"].push_back(
        {{"frame", jump.first_frame}, {"time_s", jump.time}, {"yaw_deg", jump.yaw * kDegreesPerRadian}});
  if (summary.contradicting_yaw) json["contradicting_yaw_deg"] = InDegrees(*summary.contradicting_yaw);
  return json;
}

nlohmann::ordered_json StabilisationJson(const RunSummary& summary) {
  if (!summary.image_lag && !summary.image_smoothing) return nullptr;
  nlohmann::ordered_json json;
  if (const std::optional<ImageLag>& lag = summary.image_lag) {
    json["lag_s"] = lag->found;
    json["lag_sigma_s"] = lag->found_sigma;
  }
  if (const std::optional<ImageSmoothing>& smoothing = summary.image_smoothing)
    json["smoothing_s"] = std::sqrt(smoothing->variance);
  return json;
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
  if (!found) {
    json["tested"] = summary.calibration_windows > 0;
    return json;
  }
  json["focal_length_sigma"] = found->camera.focal_sigma;
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
      {"first_frame_s", summary.first_time},
      {"clips", ClipsJson(summary.clips)},
      {"camera", summary.camera.empty() ? Json(nullptr) : Json(summary.camera)},
      {"intrinsics", IntrinsicsJson(summary)},
      {"rotate_deg", summary.rotate},
      {"mask", summary.mask.empty() ? Json(nullptr) : Json(summary.mask)},
      {"pose_frame", summary.pose_frame},
      {"lever_arm_m", summary.vehicle.lever_arm ? Json(*summary.vehicle.lever_arm) : Json(nullptr)},
      {"side_slip_s2_per_m", summary.vehicle.side_slip},
      {"camera_height_m", summary.vehicle.camera_height ? Json(*summary.vehicle.camera_height) : Json(nullptr)},
      {"camera_yaw_pitch_roll_deg",
       {angles.yaw * kDegreesPerRadian + 0.0, angles.pitch * kDegreesPerRadian + 0.0,
        angles.roll * kDegreesPerRadian + 0.0}},
      {"camera_rotation", MountJson(summary)},
      {"image_stabilisation", StabilisationJson(summary)},
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
      {"distance_m", summary.is_metric() ? Json(summary.distance) : Json(nullptr)},
      {"distance_units", summary.is_metric() ? Json(nullptr) : Json(summary.distance)},
      {"path_sigma", or_null(summary.path_sigma)},
      {"scale",
       {{"state", ScaleStateName(summary.scale_state)},
        {"known", summary.is_scale_known()},
        {"pending_reason", summary.pending_reason.empty() ? Json(nullptr) : Json(summary.pending_reason)},
        {"worst_relative_sigma", or_null(summary.worst_sigma)},
        {"worst_at_s", std::isfinite(summary.worst_sigma) ? Json(summary.worst_sigma_time) : Json(nullptr)},
        {"live_metres_from_s", summary.live_metric_from ? Json(*summary.live_metric_from) : Json(nullptr)}}},
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

}  // namespace turnscale

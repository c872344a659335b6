// SPDX-License-Identifier: MIT
#include "rescale_report.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

std::string PositiveCell(double value) { return value > 0 ? fmt::format("{:.6g}", value) : std::string(); }

// Lowest and highest of the drive.
std::pair<double, double> ScaleRange(const RescaleResult& result) {
  const auto [low, high] =
      std::minmax_element(result.poses.begin(), result.poses.end(),
                          [](const auto& a, const auto& b) { return a.metres_per_unit < b.metres_per_unit; });
  return {low->metres_per_unit, high->metres_per_unit};
}

std::pair<double, double> SigmaRange(const RescaleResult& result) {
  const auto [low, high] = std::minmax_element(result.poses.begin(), result.poses.end(),
                                               [](const auto& a, const auto& b) { return a.sigma < b.sigma; });
  return {low->sigma, high->sigma};
}

auto UsedTurns(const RescaleResult& result) {
  return std::count_if(result.turns.begin(), result.turns.end(), [](const RescaledTurn& turn) { return turn.used; });
}

}  // namespace

std::string PoseScaleTable(const RescaleResult& result) {
  std::string table = "pose,time,metres_per_unit,sigma_relative,filtered_metres_per_unit,filtered_sigma_relative\n";
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    const PoseScale& scale = result.poses[i];
    fmt::format_to(std::back_inserter(table), "{},{:.6f},{:.9g},{:.6g},{},{}\n", i, result.metric[i].time,
                   scale.metres_per_unit, scale.sigma, PositiveCell(scale.filtered_metres_per_unit),
                   PositiveCell(scale.filtered_sigma));
  }
  return table;
}

std::string TurnScaleTable(const RescaleResult& result) {
  std::string table =
      "first_pose,last_pose,angle_deg,speed_mps,metres_per_unit,sigma_relative,smoothed_metres_per_unit,"
      "smoothed_sigma_relative,effective_lever_arm_m,used,weight\n";
  for (const RescaledTurn& turn : result.turns) {
    fmt::format_to(std::back_inserter(table), "{},{},{:.4f},{},{},{},{:.9g},{:.6g},{:.6g},{},{:.4g}\n", turn.first_pose,
                   turn.last_pose, turn.angle * kDegreesPerRadian, PositiveCell(turn.speed),
                   PositiveCell(turn.metres_per_unit), PositiveCell(turn.sigma), turn.smoothed, turn.smoothed_sigma,
                   turn.effective_lever_arm, turn.used ? 1 : 0, turn.weight);
  }
  return table;
}

std::string RescaleJson(const RescaleResult& result, const std::string& input) {
  const auto [low, high] = ScaleRange(result);
  const auto [best, worst] = SigmaRange(result);
  const YawPitchRoll camera = YawPitchRollFromRotation(result.vehicle_from_camera);
  const nlohmann::ordered_json json = {{"input", input},
                                       {"poses", result.poses.size()},
                                       {"key_spacing", result.key_spacing},
                                       {"length_m", result.length},
                                       {"metres_per_unit", {{"min", low}, {"max", high}}},
                                       {"sigma_relative", {{"min", best}, {"max", worst}}},
                                       {"turns", {{"found", result.turns.size()}, {"used", UsedTurns(result)}}},
                                       {"converged", result.converged},
                                       {"camera_rotation",
                                        {{"yaw_deg", camera.yaw * kDegreesPerRadian},
                                         {"pitch_deg", camera.pitch * kDegreesPerRadian},
                                         {"roll_deg", camera.roll * kDegreesPerRadian}}},
                                       {"yaw_error_deg", result.yaw_error * kDegreesPerRadian},
                                       {"yaw_error_sigma_deg", result.yaw_error_sigma * kDegreesPerRadian},
                                       {"side_slip_s2pm", result.side_slip},
                                       {"side_slip_sigma_s2pm", result.side_slip_sigma},
                                       {"side_slip_at_bound", result.side_slip_at_bound},
                                       {"height_above_roll_axis_m", result.height},
                                       {"height_sigma_m", result.height_sigma},
                                       {"noise",
                                        {{"sway_m", result.sway_sigma},
                                         {"turn_relative", result.noise.stretch.lever},
                                         {"direction_deg", result.noise.stretch.direction * kDegreesPerRadian},
                                         {"log_scale_per_100m", result.noise.per_distance},
                                         {"log_scale_per_90deg", result.noise.per_angle}}}};
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string RescaleText(const RescaleResult& result) {
  const auto [low, high] = ScaleRange(result);
  const auto [best, worst] = SigmaRange(result);
  std::string text = fmt::format("scale         {:.5g} m per unit", low);
  if (high > low) text = fmt::format("scale         {:.5g} ... {:.5g} m per unit", low, high);
  text += worst - best > 0.0005 ? fmt::format(", +- {:.1f} ... {:.1f} %\n", 100 * best, 100 * worst)
                                : fmt::format(", +- {:.1f} %\n", 100 * best);
  text += fmt::format("path          {:.1f} m, {} turns used of {}, key spacing {}\n", result.length, UsedTurns(result),
                      result.turns.size(), result.key_spacing);
  const YawPitchRoll camera = YawPitchRollFromRotation(result.vehicle_from_camera);
  text += fmt::format("camera        yaw {:+.2f} +- {:.2f}, pitch {:+.2f}, roll {:+.2f} deg\n",
                      (camera.yaw + result.yaw_error) * kDegreesPerRadian, result.yaw_error_sigma * kDegreesPerRadian,
                      camera.pitch * kDegreesPerRadian, camera.roll * kDegreesPerRadian);
  if (result.side_slip_at_bound) {
    text += "side slip     0: the drive wants less than none, check the lever arm and the times\n";
  } else if (result.side_slip_sigma > 0) {
    text += fmt::format("side slip     {:.4f} +- {:.4f} s^2/m\n", result.side_slip, result.side_slip_sigma);
  }
  if (!result.converged) text += "note          the estimate has not settled\n";
  return text;
}

}  // namespace turnscale

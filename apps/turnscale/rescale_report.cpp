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

const std::vector<TurnEstimate>& TurnsOf(const RescaleResult& result) { return result.estimate->turns; }

auto UsedTurns(const RescaleResult& result) {
  return std::ranges::count_if(TurnsOf(result), [](const TurnEstimate& turn) { return turn.used; });
}

}  // namespace

std::string PoseScaleTable(const RescaleResult& result) {
  std::string table = "pose,time,metres_per_unit,sigma_relative,filtered_metres_per_unit,filtered_sigma_relative\n";
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    const RescaledPose& scale = result.poses[i];
    fmt::format_to(std::back_inserter(table), "{},{:.6f},{:.9g},{:.6g},{},{}\n", i, result.metric[i].time,
                   scale.metres_per_unit, scale.sigma, PositiveCell(scale.filtered_metres_per_unit),
                   PositiveCell(scale.filtered_sigma));
  }
  return table;
}

std::string TurnScaleTable(const RescaleResult& result) {
  std::string table =
      "first_pose,last_pose,angle_deg,speed_mps,metres_per_unit,sigma_relative,smoothed_metres_per_unit,"
      "smoothed_sigma_relative,deviation_sigmas,effective_lever_arm_m,used,weight,reason\n";
  for (const TurnEstimate& turn : TurnsOf(result)) {
    fmt::format_to(std::back_inserter(table), "{},{},{:.4f},{},{},{},{:.9g},{:.6g},{:.3f},{},{},{:.4g},{}\n",
                   result.steps[turn.first_step].first, result.steps[turn.last_step].last,
                   turn.angle * kDegreesPerRadian, PositiveCell(turn.speed_units * turn.smoothed),
                   PositiveCell(turn.own), PositiveCell(turn.own_sigma), turn.smoothed, turn.smoothed_sigma,
                   turn.deviation, PositiveCell(turn.lever_arm_units * turn.smoothed), turn.used ? 1 : 0, turn.weight,
                   turn.reason.empty() ? "" : "\"" + turn.reason + "\"");
  }
  return table;
}

std::string RescaleJson(const RescaleResult& result, const std::string& input) {
  const auto [low, high] = ScaleRange(result);
  const auto [best, worst] = SigmaRange(result);
  const YawPitchRoll camera = YawPitchRollFromRotation(result.vehicle_from_camera);
  const ScaleEstimate& estimate = *result.estimate;
  const CarRefinement& car = estimate.car;
  const nlohmann::ordered_json json = {{"input", input},
                                       {"poses", result.poses.size()},
                                       {"length_m", result.length},
                                       {"length_sigma", estimate.length_sigma},
                                       {"metres_per_unit", {{"min", low}, {"max", high}}},
                                       {"sigma_relative", {{"min", best}, {"max", worst}}},
                                       {"turns", {{"found", TurnsOf(result).size()}, {"used", UsedTurns(result)}}},
                                       {"converged", estimate.converged},
                                       {"contradicted", estimate.test.contradicted},
                                       {"follows_single_turns", estimate.fell_back},
                                       {"camera_rotation",
                                        {{"yaw_deg", camera.yaw * kDegreesPerRadian},
                                         {"pitch_deg", camera.pitch * kDegreesPerRadian},
                                         {"roll_deg", camera.roll * kDegreesPerRadian}}},
                                       {"yaw_error_deg", car.yaw_error * kDegreesPerRadian},
                                       {"yaw_error_sigma_deg", car.yaw_error_sigma * kDegreesPerRadian},
                                       {"side_slip_s2pm", car.side_slip},
                                       {"side_slip_sigma_s2pm", car.side_slip_sigma},
                                       {"side_slip_at_bound", car.side_slip_at_bound}};
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

std::string RescaleWarning(const RescaleResult& result) {
  const ScaleEstimate& estimate = *result.estimate;
  if (!estimate.fell_back) return {};
  const std::string what = "the trajectory uses single-turn scales; check the timestamps and the lever arm";
  if (!estimate.test.contradicted || estimate.test.worst_turn < 0)
    return "the scale estimate did not converge: " + what;
  const TurnEstimate& worst = estimate.turns[estimate.test.worst_turn];
  return fmt::format("the turns are inconsistent by {:.0f} % of scale, most of all the one at poses {}-{}: {}",
                     100 * estimate.test.disagreement, result.steps[worst.first_step].first,
                     result.steps[worst.last_step].last, what);
}

std::string RescaleText(const RescaleResult& result) {
  const auto [low, high] = ScaleRange(result);
  const auto [best, worst] = SigmaRange(result);
  std::string text = fmt::format("scale         {:.5g} m per unit", low);
  if (high > low) text = fmt::format("scale         {:.5g} ... {:.5g} m per unit", low, high);
  text += worst - best > 0.0005 ? fmt::format(", +- {:.1f} ... {:.1f} %\n", 100 * best, 100 * worst)
                                : fmt::format(", +- {:.1f} %\n", 100 * best);
  const CarRefinement& car = result.estimate->car;
  text += fmt::format("path          {:.1f} m +- {:.1f} %, {} turns used of {}\n", result.length,
                      100 * result.estimate->length_sigma, UsedTurns(result), TurnsOf(result).size());
  const YawPitchRoll camera = YawPitchRollFromRotation(result.vehicle_from_camera);
  text += fmt::format("camera        yaw {:+.2f} +- {:.2f}, pitch {:+.2f}, roll {:+.2f} deg\n",
                      (camera.yaw + car.yaw_error) * kDegreesPerRadian, car.yaw_error_sigma * kDegreesPerRadian,
                      camera.pitch * kDegreesPerRadian, camera.roll * kDegreesPerRadian);
  if (car.side_slip_at_bound) {
    text += "side slip     0: the estimate would be negative; check the lever arm and the timestamps\n";
  } else if (car.side_slip_sigma > 0) {
    text += fmt::format("side slip     {:.4f} +- {:.4f} s^2/m\n", car.side_slip, car.side_slip_sigma);
  }
  return text;
}

}  // namespace turnscale

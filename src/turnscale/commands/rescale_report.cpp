// SPDX-License-Identifier: MIT
#include "turnscale/commands/rescale_report.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/csv_cells.h"
#include "turnscale/figure/figure.h"
#include "turnscale/geometry/level_frame.h"
#include "turnscale/geometry/path_length.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/run/run_summary.h"
#include "turnscale/run/time_check.h"
#include "turnscale/run/turn_warning.h"
#include "turnscale/scale/camera_height.h"

namespace turnscale {
namespace {

using Json = nlohmann::ordered_json;

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

constexpr double kWidth = 640;  // of the panels, about pixels
constexpr double kPathHeight = 440;
constexpr double kChartHeight = 170;
constexpr std::size_t kMostPoints = 2000;  // of a curve
constexpr double kMostBand = 1;            // by how many bands a single turn may widen the chart
constexpr double kSpeedSeconds = 1;        // over which the speed is taken
constexpr auto kRed = "#c2185b";
constexpr auto kBlue = "#1565c0";
constexpr auto kDark = "#222";
constexpr auto kGray = "#999";

// Every so many, and the last.
std::vector<std::size_t> Thinned(std::size_t first, std::size_t last) {
  const std::size_t stride = (last - first) / kMostPoints + 1;
  std::vector<std::size_t> indices;
  for (std::size_t i = first; i < last; i += stride) indices.push_back(i);
  indices.push_back(last);
  return indices;
}

PlotPanel PathPanel(const RescaleResult& result) {
  const Eigen::Matrix<double, 2, 3> axes = TopViewAxes(result.metric, result.vehicle_from_camera);
  const auto places = [&](std::size_t first, std::size_t last) {
    PlotPoints points;
    for (const std::size_t i : Thinned(first, last))
      points.emplace_back(axes * result.metric[i].world_from_camera.translation);
    return points;
  };
  PlotPanel panel;
  panel.title = "path from above";
  panel.bar_unit = "m";
  panel.equal_axes = true;
  panel.height = kPathHeight;
  panel.lines.push_back({places(0, result.metric.size() - 1), "path", kDark, 2});
  for (const TurnEstimate& turn : result.estimate->turns) {
    panel.lines.push_back(
        {places(result.steps[turn.first_step].first, result.steps[turn.last_step].last), "turn", kRed, 4});
  }
  return panel;
}

PlotPanel ScalePanel(const RescaleResult& result, const std::vector<double>& along) {
  double low = HUGE_VAL;
  double high = 0;
  for (const RescaledPose& scale : result.poses) {
    low = std::min(low, scale.metres_per_unit * std::exp(-2 * scale.sigma));
    high = std::max(high, scale.metres_per_unit * std::exp(2 * scale.sigma));
  }
  const double most = kMostBand * (high - low);
  const double lowest = low - most;
  const double highest = high + most;
  PlotPanel panel;
  panel.title = "scale";
  panel.y_label = "metres per unit";
  PlotLine line{{}, "smoothed", kRed, 1.8};
  PlotArea band{{}, "1 sigma", kRed, 0.18};
  PlotPoints lower;
  for (const std::size_t i : Thinned(0, result.poses.size() - 1)) {
    const RescaledPose& scale = result.poses[i];
    line.points.emplace_back(along[i], scale.metres_per_unit);
    band.outline.emplace_back(along[i], scale.metres_per_unit * std::exp(scale.sigma));
    lower.emplace_back(along[i], scale.metres_per_unit * std::exp(-scale.sigma));
  }
  // Forth along the upper edge, back along the lower one.
  band.outline.insert(band.outline.end(), lower.rbegin(), lower.rend());
  panel.areas = {band};
  panel.lines = {line};
  for (const TurnEstimate& turn : result.estimate->turns) {
    if (!(turn.own > 0)) continue;
    const double least = turn.own * std::exp(-turn.own_relative_sigma);
    const double largest = turn.own * std::exp(turn.own_relative_sigma);
    const double middle = 0.5 * (along[result.steps[turn.first_step].first] + along[result.steps[turn.last_step].last]);
    panel.lines.push_back({{{middle, least}, {middle, largest}},
                           turn.used ? "one turn alone" : "turn not used",
                           turn.used ? kDark : kGray,
                           1.5,
                           turn.used ? "none" : "2 2"});
    if (!turn.used) continue;
    low = std::max(lowest, std::min(low, least));
    high = std::min(highest, std::max(high, largest));
  }
  panel.y = PlotRange{low, high};
  return panel;
}

PlotPanel SpeedPanel(const RescaleResult& result, const std::vector<double>& along) {
  PlotPoints speeds;
  double high = 1;
  std::size_t first = 0;
  for (std::size_t i = 1; i < along.size(); ++i) {
    const double seconds = result.metric[i].time - result.metric[first].time;
    if (seconds < kSpeedSeconds) continue;
    speeds.emplace_back(along[i], (along[i] - along[first]) / seconds);
    high = std::max(high, speeds.back().y());
    first = i;
  }
  PlotPanel panel;
  panel.title = "implied speed";
  panel.y_label = "m/s";
  panel.y = PlotRange{0, std::ceil(high / 5) * 5};
  PlotLine line{{}, "", kBlue, 1.4};
  if (!speeds.empty()) {
    for (const std::size_t i : Thinned(0, speeds.size() - 1)) line.points.push_back(speeds[i]);
  }
  panel.lines = {line};
  return panel;
}

// Steps that no car makes, as where tracking was lost and the poses go on elsewhere; empty if there are none.
std::string JumpWarning(const RescaleResult& result) {
  constexpr double kLeastMetres = 5;
  int jumps = 0;
  double total = 0;
  double most = 0;
  const VehicleStep* longest = nullptr;
  for (const VehicleStep& step : result.steps) {
    const double metres = step.motion.step * result.poses[step.last].metres_per_unit;
    if (step.usable || step.after_gap || !(metres > kLeastMetres)) continue;
    ++jumps;
    total += metres;
    if (metres <= most) continue;
    most = metres;
    longest = &step;
  }
  if (longest == nullptr) return "";
  return fmt::format(
      "the trajectory jumps by {:.0f} m between poses {} and {}{}, perhaps as tracking was lost there: jumps are in "
      "the poses, but not in the path length; if poses before it only repeat another, leave them out",
      most, longest->first, longest->last,
      jumps == 1 ? "" : fmt::format(" ({} jumps of {:.0f} m in all)", jumps, total));
}

bool IsKnown(const RescaleResult& result) { return result.estimate->length_sigma <= kLargestKnownSigma; }

// Turns between poses that are too far apart. One line; empty if there are none.
std::string SparseWarning(const RescaleResult& result) {
  const auto is_sparse = [](const VehicleStep& step) { return !step.dense; };
  const auto first = std::ranges::find_if(result.steps, is_sparse);
  if (first == result.steps.end()) return {};
  const auto count = std::ranges::count_if(result.steps, is_sparse);
  return fmt::format(
      "in turns, poses are so far apart that no scale can be read there ({}, first between poses {} and {}); give the "
      "poses of all frames",
      count == 1 ? "once" : fmt::format("{} times", count), first->first, first->last);
}

// Accelerations sideways of the turns that were used, m/s^2, with their angles.
std::vector<std::pair<double, double>> SidewaysIn(const RescaleResult& result) {
  std::vector<std::pair<double, double>> sideways;
  for (const TurnEstimate& turn : result.estimate->turns) {
    double seconds = 0;
    double metres = 0;
    double angle = 0;
    for (int i = turn.first_step; i <= turn.last_step; ++i) {
      const VehicleStep& step = result.steps[i];
      seconds += step.duration;
      metres += step.driven() * result.poses[step.last].metres_per_unit;
      angle += step.turned();
    }
    if (turn.used && seconds > 0)
      sideways.emplace_back(metres * std::abs(angle) / (seconds * seconds), std::abs(angle));
  }
  return sideways;
}

std::optional<std::string> TimeWarning(const RescaleResult& result) {
  const bool whole =
      std::ranges::all_of(result.metric, [](const StampedPose& pose) { return pose.time == std::floor(pose.time); });
  if (whole)
    return UnusualTurnsWarning(SidewaysIn(result),
                               "the times of the poses, and give --fps if they are numbers of frames", 1);
  return UnusualTurnsWarning(SidewaysIn(result), "the times of the poses");
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
                   PositiveCell(turn.own), PositiveCell(turn.own_relative_sigma), turn.smoothed,
                   turn.smoothed_relative_sigma, turn.deviation, PositiveCell(turn.lever_arm_units * turn.smoothed),
                   turn.used ? 1 : 0, turn.weight, QuotedCell(turn.reason));
  }
  return table;
}

std::string RescaleJson(const RescaleResult& result, const std::string& input, bool timed,
                        const std::vector<std::string>& warnings) {
  const auto [low, high] = ScaleRange(result);
  const auto [best, worst] = SigmaRange(result);
  const YawPitchRoll camera = YawPitchRollFromRotation(result.vehicle_from_camera);
  const ScaleEstimate& estimate = *result.estimate;
  const CarRefinement& car = estimate.car;
  const auto known = [&](double metres) { return metres > 0 ? Json(metres) : Json(nullptr); };
  // Single-turn scales do not use the refined car.
  const auto refined = [&](const auto& value) { return estimate.uses_single_turns ? Json(nullptr) : Json(value); };
  const Json json = {{"input", input},
                     {"timed", timed},
                     {"poses", result.poses.size()},
                     {"length_m", result.length},
                     {"length_sigma", estimate.length_sigma},
                     {"gap_length_m", result.gap_length},
                     {"known", IsKnown(result)},
                     {"metres_per_unit", {{"min", low}, {"max", high}}},
                     {"sigma_relative", {{"min", best}, {"max", worst}}},
                     {"turns", {{"found", TurnsOf(result).size()}, {"used", UsedTurns(result)}}},
                     {"converged", estimate.converged},
                     {"contradicted", estimate.test.contradicted},
                     {"follows_single_turns", estimate.uses_single_turns},
                     {"camera_rotation",
                      {{"yaw_deg", camera.yaw * kDegreesPerRadian},
                       {"pitch_deg", camera.pitch * kDegreesPerRadian},
                       {"roll_deg", camera.roll * kDegreesPerRadian}}},
                     {"yaw_error_deg", refined(car.yaw_error * kDegreesPerRadian)},
                     {"yaw_error_sigma_deg", refined(car.yaw_error_sigma * kDegreesPerRadian)},
                     {"side_slip_s2pm", refined(car.side_slip)},
                     {"side_slip_sigma_s2pm", refined(car.side_slip_sigma)},
                     {"side_slip_at_bound", refined(car.side_slip_at_bound)},
                     {"roll_height_m", refined(car.roll_height)},
                     {"roll_height_sigma_m", refined(car.roll_height_sigma)},
                     {"camera_height_m", refined(known(car.camera_height))},
                     {"camera_height_sigma_m", refined(known(HeightSigma(*result.estimate)))},
                     {"warnings", warnings}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<std::string> RescaleWarnings(const RescaleResult& result, const CarPrior& car) {
  const auto poses_of = [&](int index) {
    const TurnEstimate& turn = result.estimate->turns[index];
    return fmt::format("poses {}-{}", result.steps[turn.first_step].first, result.steps[turn.last_step].last);
  };
  std::vector<std::string> warnings;
  const std::string of_turns = TurnWarning(*result.estimate, poses_of,
                                           "the timestamps, the lever arm, and that the poses are world_from_camera");
  if (!of_turns.empty()) warnings.push_back(of_turns);
  if (result.estimate->height_conflict)
    warnings.push_back(HeightWarning(*result.estimate->height_conflict, car.lever_arm, "measure both again"));
  if (result.estimate->slip_conflict) warnings.push_back(SlipWarning(*result.estimate->slip_conflict));
  if (result.estimate->is_stabilised()) warnings.push_back(StabilisationWarning(*result.estimate));
  if (result.estimate->yaw_conflict)
    warnings.push_back(YawWarning(*result.estimate->yaw_conflict, "check --camera-rotation"));
  if (std::optional<std::string> time = TimeWarning(result)) warnings.push_back(std::move(*time));
  if (std::string jump = JumpWarning(result); !jump.empty()) warnings.push_back(std::move(jump));
  if (std::string sparse = SparseWarning(result); !sparse.empty()) warnings.push_back(std::move(sparse));
  return warnings;
}

std::string RescaleText(const RescaleResult& result) {
  const auto [low, high] = ScaleRange(result);
  const auto [best, worst] = SigmaRange(result);
  std::string text = fmt::format("scale         {:.5g} m per unit", low);
  if (high > low) text = fmt::format("scale         {:.5g} ... {:.5g} m per unit", low, high);
  text += worst - best > 0.0005 ? fmt::format(", +-{:.1f} ... {:.1f} %\n", 100 * best, 100 * worst)
                                : fmt::format(", +-{:.1f} %\n", 100 * best);
  const CarRefinement& car = result.estimate->car;
  // Single-turn scales do not use the refined car.
  const bool refined = !result.estimate->uses_single_turns;
  const double yaw_error = refined ? car.yaw_error : 0.0;
  const double yaw_sigma = refined ? car.yaw_error_sigma : result.yaw_sigma;
  const std::string uncertain =
      IsKnown(result) ? "" : fmt::format(" (uncertain, as it is above {:.0f} %)", 100 * kLargestKnownSigma);
  text += fmt::format("path          {:.1f} m +-{:.1f} %{}, {} of {} turns used\n", result.length,
                      100 * result.estimate->length_sigma, uncertain, UsedTurns(result), TurnsOf(result).size());
  if (result.gap_length > 0)
    text += fmt::format("gaps          {:.1f} m more where tracking was lost or nothing was recorded, not measured\n",
                        result.gap_length);
  const YawPitchRoll camera = YawPitchRollFromRotation(result.vehicle_from_camera);
  text += fmt::format("camera        yaw {:+.2f} +-{:.2f}, pitch {:+.2f}, roll {:+.2f} deg\n",
                      (camera.yaw + yaw_error) * kDegreesPerRadian, yaw_sigma * kDegreesPerRadian,
                      camera.pitch * kDegreesPerRadian, camera.roll * kDegreesPerRadian);
  if (!refined) return text;
  if (const auto& assumed = result.assumed_slip; assumed && UsedTurns(result) > 0)
    text += fmt::format("side slip     {}\n", SideSlipText(car, assumed->value, assumed->sigma));
  if (car.camera_height > 0)
    text += fmt::format("height        camera {:.3f} +-{:.3f} m above the road\n", car.camera_height,
                        HeightSigma(*result.estimate));
  return text;
}

std::string RescaleSvg(const RescaleResult& result, const std::string& title, bool timed) {
  const std::vector<double> along = LengthsAlong(result.metric);
  Figure figure;
  figure.title = title;
  figure.panel_width = kWidth;
  figure.panel_height = kChartHeight;
  figure.panels = {PathPanel(result), ScalePanel(result, along)};
  if (timed) figure.panels.push_back(SpeedPanel(result, along));
  for (std::size_t i = 1; i < figure.panels.size(); ++i) figure.panels[i].x = PlotRange{0, std::max(along.back(), 1.0)};
  figure.panels.back().x_label = "along the path [m]";
  return FigureSvg(figure);
}

}  // namespace turnscale

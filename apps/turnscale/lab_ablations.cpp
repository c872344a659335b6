// SPDX-License-Identifier: MIT
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "lab_experiments.h"
#include "lab_trials.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kPixelNoiseOfAblations = 1;
constexpr int kFewerRuns = 5;         // times fewer runs than Table I has
constexpr double kSideSlip = 0.0045;  // s^2/m, the default of `turnscale run`
constexpr double kLeverArmError = 0.05;

struct Variant {
  std::string key;
  std::string label;
  ScaleEstimatorSettings settings;
};

std::vector<Variant> RigidVariants() {
  std::vector<Variant> variants = {{"pooled", "pooled line, held (as run does)", {}},
                                   {"per_frame", "per-frame observer, held (the paper)", {}},
                                   {"weighted", "pooled line, turns weighted by variance", {}}};
  variants[1].settings.pooled.method = ScaleMethod::kPerFrame;
  variants[2].settings.scales = TurnScales::kSmoothed;
  for (const int turns : {1, 2, 5}) {
    variants.push_back({fmt::format("turns_{}", turns), fmt::format("first {} of 9 turns", turns), {}});
    variants.back().settings.most_turns = turns;
  }
  for (const double yaw : {0.25, 0.5, 1.0}) {
    variants.push_back({fmt::format("yaw_{:g}_deg", yaw), fmt::format("Q wrong by {:g} deg of yaw", yaw), {}});
    variants.back().settings.vehicle_from_camera = RotationFromYawPitchRoll({yaw / kDegreesPerRadian, 0, 0});
  }
  variants.push_back({"yaw_1_deg_weighted", "Q wrong by 1 deg, turns weighted", variants.back().settings});
  variants.back().settings.scales = TurnScales::kSmoothed;
  variants.push_back({"lever_arm", "L wrong by 5 %", {}});
  variants.back().settings.lever_arm.length *= 1 + kLeverArmError;
  return variants;
}

std::vector<Variant> SlippingVariants() {
  std::vector<Variant> variants = {{"slip_ignored", "tyres slip, taken as rigid", {}},
                                   {"slip_known", "tyres slip, slip known", {}}};
  variants[1].settings.lever_arm.side_slip = kSideSlip;
  return variants;
}

// A drive at whose speed the slip shortens the lever arm.
ScaleDriveOptions SlippingDrive() {
  ScaleDriveOptions options;
  const double speed = options.drive.length * options.drive.rate_hz / (options.drive.frames - 1);
  options.drive.lever_arm = LeverArm{options.drive.lever_arm, kSideSlip}.At(speed);
  return options;
}

PlotPanel BarPanel(const std::string& title, std::size_t variants) {
  PlotPanel panel;
  panel.title = title;
  panel.x_label = "scale error ratio RMSE [%]";
  panel.legend = false;
  panel.y = PlotRange{-static_cast<double>(variants) + 0.4, 0.6};
  return panel;
}

}  // namespace

LabResult LabAblations(const LabSettings& settings) {
  LabResult result;
  const int runs = std::max(2, settings.runs / kFewerRuns);
  const std::vector<std::pair<ScaleDriveOptions, std::vector<Variant>>> parts = {{ScaleDriveOptions{}, RigidVariants()},
                                                                                 {SlippingDrive(), SlippingVariants()}};
  result.values["runs"] = runs;
  result.values["pixel_noise"] = kPixelNoiseOfAblations;
  result.values["side_slip"] = kSideSlip;
  result.values["lever_arm_error_percent"] = 100 * kLeverArmError;
  std::vector<std::string> labels;
  PlotPoints turn_marks;
  PlotPoints all_marks;
  int before = 0;
  for (const auto& [drive, variants] : parts) {
    std::vector<ScaleEstimatorSettings> estimators;
    for (const Variant& variant : variants) estimators.push_back(variant.settings);
    ScaleTrials trials = TrialsOf(settings, drive, estimators, runs);
    trials.drive.pixel_noise = kPixelNoiseOfAblations;
    trials.progress = [&](int done, int) {
      return settings.progress(before + done, runs * static_cast<int>(parts.size()));
    };
    const std::vector<ScaleTrial> trial = RunScaleTrials(trials);
    if (trial.empty()) return {};
    before += runs;
    for (std::size_t e = 0; e < variants.size(); ++e) {
      LabJson row = TableRowJson(trial, e);
      row["what"] = variants[e].label;
      const double y = -static_cast<double>(labels.size());
      labels.push_back(variants[e].label);
      turn_marks.emplace_back(row["turn_ratio_percent"]["mean"].get<double>(), y);
      all_marks.emplace_back(row["ratio_percent"]["mean"].get<double>(), y);
      result.lines.push_back(fmt::format("ablations  {:<40} r (turn) {:6.3f} %  r (all) {:6.3f} %", variants[e].label,
                                         turn_marks.back().x(), all_marks.back().x()));
      result.values["variants"][variants[e].key] = std::move(row);
    }
  }
  PlotPanel panel = BarPanel("mean over the runs", labels.size());
  const double most = std::max(std::ranges::max(all_marks, {}, [](const auto& p) { return p.x(); }).x(),
                               std::ranges::max(turn_marks, {}, [](const auto& p) { return p.x(); }).x());
  panel.x = PlotRange{0, 1.08 * most};
  panel.legend = true;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const double y = -static_cast<double>(i);
    panel.y_names.emplace_back(y, labels[i]);
    const auto bar = [&](double value, double low, double high, const char* label, const char* color) {
      panel.areas.push_back({{{0, y + low}, {value, y + low}, {value, y + high}, {0, y + high}}, label, color, 0.9});
    };
    bar(turn_marks[i].x(), 0.02, 0.34, "in turns", "#42a5f5");
    bar(all_marks[i].x(), -0.34, -0.02, "whole drive", "#0d3c78");
  }
  result.figures.emplace_back("ablations", Figure{"Which choice wins: the recovery with one thing changed at a time",
                                                  "",
                                                  1,
                                                  460,
                                                  30.0 * static_cast<double>(labels.size()),
                                                  {panel}});
  return result;
}

}  // namespace turnscale

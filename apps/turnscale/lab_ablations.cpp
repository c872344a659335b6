// SPDX-License-Identifier: MIT
#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "lab_experiments.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kPixelNoiseOfAblations = 1;
constexpr int kFewerRunsOfAblations = 10;         // times fewer runs than Table I has
constexpr double kTrueSideSlip = kUsualSideSlip;  // of the drive whose tyres slip, s^2/m
constexpr double kLeverArmError = 0.05;

// Something that the estimator is told, rightly or wrongly; recovered by all methods.
struct Condition {
  std::string key;
  std::string label;
  std::function<void(ScaleEstimatorSettings&)> tell;
};

std::vector<Condition> RigidConditions() {
  std::vector<Condition> conditions = {{"known", "all known, 9 turns", [](ScaleEstimatorSettings&) {}}};
  for (const int turns : {5, 2, 1}) {
    conditions.push_back({fmt::format("turns_{}", turns), fmt::format("{} of the 9 turns used", turns),
                          [turns](ScaleEstimatorSettings& settings) { settings.most_turns = turns; }});
  }
  for (const double yaw : {0.25, 0.5, 1.0}) {
    conditions.push_back(
        {fmt::format("yaw_{:g}_deg", yaw), fmt::format("yaw of Q off by {:g} deg", yaw),
         [yaw](ScaleEstimatorSettings& settings) {
           settings.odometry.vehicle.vehicle_from_camera = RotationFromYawPitchRoll({yaw / kDegreesPerRadian, 0, 0});
         }});
  }
  conditions.push_back(
      {"lever_arm", fmt::format("L wrong by {:g} %", 100 * kLeverArmError),
       [](ScaleEstimatorSettings& settings) { *settings.odometry.vehicle.lever_arm *= 1 + kLeverArmError; }});
  return conditions;
}

std::vector<Condition> SlippingConditions() {
  return {{"slip_ignored", "tyre slip neglected", [](ScaleEstimatorSettings&) {}},
          {"slip_known", "tyres slip, slip known",
           [](ScaleEstimatorSettings& settings) { settings.odometry.vehicle.side_slip = kTrueSideSlip; }}};
}

std::vector<Condition> SeeingConditions() {
  return {{"front", "all known, unlimited field of view", [](ScaleEstimatorSettings&) {}}};
}

// Cameras that see everything in front of them up to the view limit.
ScaleDriveOptions SeeingDrive() {
  ScaleDriveOptions options;
  options.within_image = false;
  return options;
}

// Bars of the methods under every condition, from above.
PlotPanel BarPanel(const std::string& title, const std::string& column, const LabJson& conditions) {
  PlotPanel panel;
  panel.title = title;
  panel.x_label = "scale error ratio RMSE [%]";
  panel.y = PlotRange{-static_cast<double>(conditions.size()) + 0.5, 0.5};
  constexpr double kBar = 0.8 / kMethods.size();
  double most = 0;
  for (const auto& [key, condition] : conditions.items()) {
    const double y = -static_cast<double>(panel.y_names.size());
    panel.y_names.emplace_back(y, condition["what"].get<std::string>());
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
      const double value = condition[kMethods[m].key][column]["mean"].get<double>();
      most = std::max(most, value);
      const double top = y + 0.4 - static_cast<double>(m) * kBar;
      panel.areas.push_back(
          {{{0, top}, {value, top}, {value, top - kBar}, {0, top - kBar}}, kMethods[m].label, kMethods[m].color, 0.9});
    }
  }
  panel.x = PlotRange{0, 1.05 * most};
  return panel;
}

}  // namespace

LabResult LabAblations(const LabSettings& settings) {
  LabResult result;
  const int runs = std::max(2, settings.runs / kFewerRunsOfAblations);
  const std::vector<std::pair<ScaleDriveOptions, std::vector<Condition>>> parts = {
      {ScaleDriveOptions{}, RigidConditions()},
      {SlippingDrive(kTrueSideSlip), SlippingConditions()},
      {SeeingDrive(), SeeingConditions()}};
  result.values["runs"] = runs;
  result.values["pixel_noise"] = kPixelNoiseOfAblations;
  result.values["side_slip"] = kTrueSideSlip;
  LabJson& all = result.values["conditions"];
  int before = 0;
  for (const auto& [drive, conditions] : parts) {
    std::vector<ScaleEstimatorSettings> estimators;
    for (const Condition& condition : conditions) {
      for (const LabMethod& method : kMethods) {
        estimators.push_back(EstimatorOf(method));
        condition.tell(estimators.back());
      }
    }
    ScaleTrials trials = TrialsOf(settings, drive, estimators, runs);
    trials.drive.pixel_noise = kPixelNoiseOfAblations;
    trials.progress = [&](int done, int) {
      return settings.progress(before + done, runs * static_cast<int>(parts.size()));
    };
    const std::vector<ScaleTrial> trial = RunScaleTrials(trials);
    if (trial.empty()) return {};
    before += runs;
    for (std::size_t e = 0; e < estimators.size(); ++e) {
      const Condition& condition = conditions[e / kMethods.size()];
      const LabMethod& method = kMethods[e % kMethods.size()];
      LabJson row = TableRowJson(trial, e);
      result.lines.push_back(fmt::format("ablations  {:<28} {:<12} r (turn) {:6.3f} %  r (all) {:6.3f} %",
                                         condition.label, method.label, row["turn_ratio_percent"]["mean"].get<double>(),
                                         row["ratio_percent"]["mean"].get<double>()));
      all[condition.key]["what"] = condition.label;
      all[condition.key][method.key] = std::move(row);
    }
  }
  PlotPanel in_turns = BarPanel("in turns", "turn_ratio_percent", all);
  in_turns.legend = false;
  result.figures.emplace_back("ablations", Figure{"Ablations: absolute scale recovery with correct and wrong inputs",
                                                  "",
                                                  2,
                                                  330,
                                                  38.0 * static_cast<double>(all.size()),
                                                  {in_turns, BarPanel("over the whole drive", "ratio_percent", all)}});
  return result;
}

}  // namespace turnscale

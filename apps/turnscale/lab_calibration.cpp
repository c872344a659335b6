// SPDX-License-Identifier: MIT
#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "lab_experiments.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/laboratory/calibration_trials.h"
#include "turnscale/laboratory/scale_trials.h"

namespace turnscale {
namespace {

constexpr std::array<double, 4> kRotationNoise = {0.05, 0.2, 0.5, 1.0};  // deg
constexpr std::array<const char*, 4> kColors = {"#bbdefb", "#64b5f6", "#1976d2", "#0d3c78"};
constexpr std::array<const char*, 3> kAngles = {"yaw", "pitch", "roll"};
constexpr double kPaperSpreadAtOneDegree = 0.5;

using Trials = std::vector<CalibrationTrial>;

double AngleOf(const YawPitchRoll& angles, std::size_t angle) {
  const std::array<double, 3> all = {angles.yaw, angles.pitch, angles.roll};
  return all.at(angle) * kDegreesPerRadian;
}

// Errors in degrees, one a run.
std::vector<double> Errors(const Trials& trials, YawPitchRoll CalibrationTrial::*which, std::size_t angle) {
  std::vector<double> values;
  for (const CalibrationTrial& trial : trials) values.push_back(AngleOf(trial.*which, angle));
  return values;
}

PlotPanel Panel(const std::array<Trials, 4>& levels, YawPitchRoll CalibrationTrial::*which, const std::string& title) {
  PlotPanel panel;
  panel.title = title;
  panel.x_label = "angle of the camera-to-vehicle rotation";
  panel.y_label = "error [deg]";
  panel.x = PlotRange{0.3, 3.7};
  panel.lines.push_back({{{0.3, 0}, {3.7, 0}}, "truth", "#777", 1.2, "6 4"});
  for (std::size_t angle = 0; angle < kAngles.size(); ++angle) {
    panel.x_names.emplace_back(static_cast<double>(angle) + 1, kAngles[angle]);
    for (std::size_t level = 0; level < levels.size(); ++level) {
      panel.boxes.push_back(BoxOf(Errors(levels[level], which, angle),
                                  static_cast<double>(angle) + 0.7 + 0.2 * static_cast<double>(level), 0.16,
                                  fmt::format("noise {:g} deg", kRotationNoise[level]), kColors[level]));
    }
  }
  return panel;
}

}  // namespace

LabResult LabFigure9(const LabSettings& settings) {
  LabResult result;
  std::array<Trials, 4> levels;
  for (std::size_t level = 0; level < levels.size(); ++level) {
    CalibrationTrials trials;
    trials.drive = PaperCalibrationDrive();
    trials.rotation_noise = kRotationNoise[level] / kDegreesPerRadian;
    trials.runs = settings.runs;
    trials.jobs = settings.jobs;
    trials.seed = settings.seed;
    trials.progress = [&](int done, int all) {
      return settings.progress(static_cast<int>(level) * all + done, static_cast<int>(levels.size()) * all);
    };
    levels[level] = RunCalibrationTrials(trials);
    if (levels[level].empty()) return {};
  }
  Figure figure{"Fig. 9: calibration of the camera-to-vehicle rotation on the synthetic drive",
                "Boxes: mean and one standard deviation; whiskers: range over the runs.",
                2,
                480,
                320,
                {}};
  figure.panels = {Panel(levels, &CalibrationTrial::linear, "(a) linear only"),
                   Panel(levels, &CalibrationTrial::refined, "(b) after the full refinement")};
  for (double y : {-kPaperSpreadAtOneDegree, kPaperSpreadAtOneDegree}) {
    figure.panels[1].lines.push_back({{{0.3, y}, {3.7, y}}, "paper: 1 sigma at 1 deg", "#c2185b", 1.4, "2 3"});
  }
  result.figures.emplace_back("fig9", figure);
  result.values["paper_spread_at_1_deg"] = kPaperSpreadAtOneDegree;
  result.values["runs"] = settings.runs;
  for (std::size_t level = 0; level < levels.size(); ++level) {
    LabJson row = {{"noise_deg", kRotationNoise[level]}};
    for (std::size_t angle = 0; angle < kAngles.size(); ++angle) {
      const MeanAndSpread linear = MeanAndSpreadOf(Errors(levels[level], &CalibrationTrial::linear, angle));
      const MeanAndSpread refined = MeanAndSpreadOf(Errors(levels[level], &CalibrationTrial::refined, angle));
      row[kAngles[angle]] = {{"linear_mean_deg", Rounded(linear.mean)},
                             {"linear_spread_deg", Rounded(linear.spread)},
                             {"refined_mean_deg", Rounded(refined.mean)},
                             {"refined_spread_deg", Rounded(refined.spread)}};
    }
    result.values["rows"].push_back(row);
  }
  return result;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "lab_experiments.h"
#include "lab_trials.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Table I as the paper prints it: a row a noise level.
constexpr std::array<std::array<double, 6>, 3> kPaperTable = {{{0.110, 0.045, 0.066, 1.01, 0.100, 3.38},
                                                               {0.214, 0.058, 0.067, 1.14, 0.107, 3.56},
                                                               {0.238, 0.062, 0.067, 1.52, 0.145, 4.57}}};
constexpr double kPaperOdometryPsi = 0.500;
constexpr double kPaperOdometryScale = 1.098;
constexpr double kPaperOdometryRatio = 34.79;
constexpr int kSideReadingShare = 20;  // readings beside the first one have this many times fewer runs

struct Reading {
  std::string name;
  std::string what;
  ScaleDriveOptions drive;
  int runs = 0;
};

std::vector<Reading> Readings(const LabSettings& settings) {
  const int fewer = std::max(2, settings.runs / kSideReadingShare);
  Reading image{"image", "what falls into KITTI's image", {}, settings.runs};
  Reading front{"front", "all in front of the camera up to the view limit", {}, fewer};
  front.drive.within_image = false;
  front.drive.nearest = 1;
  Reading every_frame{"every_frame", "in the image; the odometry loses its share in every frame", {}, fewer};
  every_frame.drive.scale_loss_frames = 1;
  return {image, front, every_frame};
}

// The two estimators of the table.
std::vector<ScaleEstimatorSettings> Estimators() {
  std::vector<ScaleEstimatorSettings> estimators(2);
  estimators[1].scales = TurnScales::kSmoothed;
  return estimators;
}
constexpr std::array<const char*, 2> kEstimators = {"each turn its own", "turns weighted by variance"};
constexpr std::array<const char*, 2> kEstimatorKeys = {"own", "weighted"};
constexpr std::array<const char*, 2> kEstimatorColors = {"#42a5f5", "#7cb342"};

PlotPanel CellPanel(std::size_t column) {
  PlotPanel panel;
  panel.title = std::string(kTableColumns[column].label);
  panel.x_label = "pixel noise [px]";
  panel.y_label = std::string(kTableColumns[column].unit);
  panel.x = PlotRange{0.4, 3.6};
  panel.legend = column == 2 || column == 5;
  for (std::size_t level = 0; level < kPixelNoise.size(); ++level)
    panel.x_names.emplace_back(static_cast<double>(level) + 1, fmt::format("{:g}", kPixelNoise[level]));
  PlotLine paper{{}, "paper's Table I", "#c2185b", 2.4};
  paper.marker = 'x';
  paper.marker_size = 6;
  for (std::size_t level = 0; level < kPixelNoise.size(); ++level)
    paper.points.emplace_back(static_cast<double>(level) + 1, kPaperTable[level][column]);
  panel.lines.push_back(paper);
  return panel;
}

PlotBox CellBox(double x, const std::vector<double>& values, const std::string& label, const std::string& color) {
  const MeanAndSpread cell = MeanAndSpreadOf(values);
  return {x,
          0.22,
          cell.mean,
          cell.spread,
          *std::min_element(values.begin(), values.end()),
          *std::max_element(values.begin(), values.end()),
          label,
          color};
}

LabJson PaperJson() {
  LabJson rows = LabJson::array();
  for (std::size_t level = 0; level < kPaperTable.size(); ++level) {
    LabJson row = {{"pixel_noise", kPixelNoise[level]}};
    for (std::size_t column = 0; column < kTableColumns.size(); ++column)
      row[kTableColumns[column].key] = kPaperTable[level][column];
    rows.push_back(row);
  }
  return {{"odometry",
           {{"psi_deg", kPaperOdometryPsi}, {"scale_m", kPaperOdometryScale}, {"ratio_percent", kPaperOdometryRatio}}},
          {"step_m", Rounded(kPaperOdometryScale / (kPaperOdometryRatio / 100))},
          {"rows", rows}};
}

}  // namespace

LabResult LabTable1(const LabSettings& settings) {
  LabResult result;
  Figure figure{"Table I: errors of the absolute scale recovery, RMSE of each run",
                "Boxes: mean and one standard deviation over the runs; whiskers: their range.",
                3,
                250,
                250,
                {}};
  for (std::size_t column = 0; column < kTableColumns.size(); ++column) figure.panels.push_back(CellPanel(column));
  result.values["paper"] = PaperJson();
  const std::vector<Reading> readings = Readings(settings);
  int all = 0;
  for (const Reading& reading : readings) all += static_cast<int>(kPixelNoise.size()) * reading.runs;
  int before = 0;
  for (const Reading& reading : readings) {
    LabJson rows = LabJson::array();
    for (std::size_t level = 0; level < kPixelNoise.size(); ++level) {
      ScaleTrials trials = TrialsOf(settings, reading.drive, Estimators(), reading.runs);
      trials.drive.pixel_noise = kPixelNoise[level];
      trials.progress = [&](int done, int) { return settings.progress(before + done, all); };
      const std::vector<ScaleTrial> runs = RunScaleTrials(trials);
      if (runs.empty()) return {};
      before += reading.runs;
      LabJson row = {{"pixel_noise", kPixelNoise[level]}};
      row["odometry"] = {
          {"psi_deg",
           Rounded(CellOf(runs, [](const ScaleTrial& t) { return t.odometry.psi * kDegreesPerRadian; }).mean)},
          {"scale_m", Rounded(CellOf(runs, [](const ScaleTrial& t) { return t.odometry.scale; }).mean)},
          {"ratio_percent", Rounded(CellOf(runs, [](const ScaleTrial& t) { return 100 * t.odometry.ratio; }).mean)}};
      for (std::size_t e = 0; e < kEstimatorKeys.size(); ++e) {
        row[kEstimatorKeys[e]] = TableRowJson(runs, e);
        if (reading.name != "image") continue;
        const double x = static_cast<double>(level) + (e == 0 ? 0.78 : 1.22);
        for (std::size_t column = 0; column < kTableColumns.size(); ++column)
          figure.panels[column].boxes.push_back(
              CellBox(x, TableValues(runs, e, column), kEstimators[e], kEstimatorColors[e]));
      }
      std::string line = fmt::format("table1  {:<11} {:>3g} px ", reading.name, kPixelNoise[level]);
      for (const TableColumn& column : kTableColumns)
        line += fmt::format("  {} {:.3f}", column.key, row[kEstimatorKeys[0]][column.key]["mean"].get<double>());
      result.lines.push_back(line);
      rows.push_back(std::move(row));
    }
    result.values["readings"][reading.name] = {
        {"what", reading.what}, {"runs", reading.runs}, {"rows", std::move(rows)}};
  }
  result.figures.emplace_back("table1", figure);
  return result;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "lab_experiments.h"
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
constexpr int kFewerRunsOfAside = 20;  // times fewer, of the reading that is beside the point

struct Reading {
  std::string name;
  std::string what;
  std::string color;  // of its box; empty: not drawn
  ScaleDriveOptions drive;
  std::vector<LabMethod> methods;
  int runs = 0;
};

std::vector<Reading> Readings(const LabSettings& settings) {
  const LabMethod& smoothed = kMethods[0];
  const LabMethod& turns = kMethods[1];
  Reading front{"front", "everything in front up to the view limit", "#7cb342", {}, {smoothed}, settings.runs};
  front.drive.within_image = false;
  const Reading image{"image", "within KITTI's image", "#1565c0", {}, {smoothed}, settings.runs};
  Reading every_frame{"every_frame", "in KITTI's image, loss in every frame", "", {}, {smoothed, turns}};
  every_frame.runs = std::max(2, settings.runs / kFewerRunsOfAside);
  every_frame.drive.scale_loss_frames = 1;
  return {front, image, every_frame};
}

PlotPanel CellPanel(std::size_t column) {
  PlotPanel panel;
  panel.title = std::string(kTableColumns[column].label);
  panel.x_label = "pixel noise [px]";
  panel.y_label = std::string(kTableColumns[column].unit);
  panel.x = PlotRange{0.4, 3.6};
  panel.legend = column == 2;
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

LabJson OdometryJson(const std::vector<ScaleTrial>& runs) {
  const auto mean = [&](const auto& value) { return Rounded(CellOf(runs, value).mean); };
  return {{"psi_deg", mean([](const ScaleTrial& run) { return run.odometry.psi * kDegreesPerRadian; })},
          {"scale_m", mean([](const ScaleTrial& run) { return run.odometry.scale; })},
          {"ratio_percent", mean([](const ScaleTrial& run) { return 100 * run.odometry.ratio; })}};
}

std::string RowLine(const Reading& reading, double pixel_noise, const LabMethod& method, const LabJson& row) {
  std::string line = fmt::format("table1  {:<11} {:>3g} px  {:<11}", reading.name, pixel_noise, method.label);
  for (const TableColumn& column : kTableColumns)
    line += fmt::format("  {} {:.3f}", column.label, row[column.key]["mean"].get<double>());
  return line;
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
  int drawn = 0;
  for (const Reading& reading : readings) {
    LabJson rows = LabJson::array();
    const std::vector<LabMethod>& methods = reading.methods;
    std::vector<ScaleEstimatorSettings> estimators(methods.size());
    std::ranges::transform(methods, estimators.begin(), EstimatorOf);
    for (std::size_t level = 0; level < kPixelNoise.size(); ++level) {
      ScaleTrials trials = TrialsOf(settings, reading.drive, estimators, reading.runs);
      trials.drive.pixel_noise = kPixelNoise[level];
      trials.progress = [&](int done, int) { return settings.progress(before + done, all); };
      const std::vector<ScaleTrial> runs = RunScaleTrials(trials);
      if (runs.empty()) return {};
      before += reading.runs;
      LabJson row = {{"pixel_noise", kPixelNoise[level]}, {"odometry", OdometryJson(runs)}};
      for (std::size_t e = 0; e < methods.size(); ++e) {
        row[methods[e].key] = TableRowJson(runs, e);
        result.lines.push_back(RowLine(reading, kPixelNoise[level], methods[e], row[methods[e].key]));
      }
      rows.push_back(std::move(row));
      if (reading.color.empty()) continue;
      const double x = static_cast<double>(level) + (drawn == 0 ? 0.8 : 1.2);
      for (std::size_t column = 0; column < kTableColumns.size(); ++column) {
        figure.panels[column].boxes.push_back(
            BoxOf(TableValues(runs, 0, column), x, 0.22, "ours, " + reading.what, reading.color));
      }
    }
    ++drawn;
    result.values["readings"][reading.name] = {
        {"what", reading.what}, {"runs", reading.runs}, {"rows", std::move(rows)}};
  }
  result.figures.emplace_back("table1", figure);
  return result;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "turnscale/figure/figure.h"
#include "turnscale/laboratory/scale_trials.h"

namespace turnscale {

using LabJson = nlohmann::ordered_json;

/// What one experiment of the laboratory gives.
struct LabResult {
  LabJson values = LabJson::object();                   ///< its numbers, as lab.json has them
  std::vector<std::pair<std::string, Figure>> figures;  ///< by the name of their file
  std::vector<std::string> lines;                       ///< what is printed
};

/// How the experiments are run.
struct LabSettings {
  int runs = 100;
  int jobs = 2;
  unsigned seed = 1;
  /// Told how many of how many runs are done; false stops the experiment.
  std::function<bool(int done, int all)> progress;
};

/// Six significant digits, which is more than any of the experiments knows.
double Rounded(double value);

/// The curves, boxes and areas of a figure as numbers.
LabJson FigureJson(const Figure& figure);

/// Writes the pictures and puts the numbers into `all` under the experiment's name. Throws as ReplaceFile does, after
/// trying all of them.
void KeepResult(const std::filesystem::path& folder, const std::string& name, const LabResult& result, LabJson& all);

/// Figures 4 (b), 6 and 7 of the paper, from closed form.
LabResult LabFigure4();
LabResult LabFigure6();
LabResult LabFigure7();

/// The rest draws random numbers; the result is empty where the progress asked to stop (Figure 8 is one run, and asks
/// when that is done).
LabResult LabFigure8(const LabSettings& settings);    ///< the synthetic drive
LabResult LabFigure9(const LabSettings& settings);    ///< calibration
LabResult LabFigure10(const LabSettings& settings);   ///< one recovery a noise level
LabResult LabTable1(const LabSettings& settings);     ///< the recovery's errors over many runs
LabResult LabAblations(const LabSettings& settings);  ///< the recovery with one thing changed at a time
LabResult LabCoverage(const LabSettings& settings);   ///< how often the truth is within the stated sigmas

/// The paper's noise levels, pixels.
constexpr std::array<double, 3> kPixelNoise = {0.5, 1.0, 2.0};

/// A column of Table I: how lab.json calls it, and what a picture says.
struct TableColumn {
  const char* key;
  const char* label;
  const char* unit;
};
constexpr std::array<TableColumn, 6> kTableColumns = {{{"psi_deg", "psi", "RMSE [deg]"},
                                                       {"theta_deg", "theta", "RMSE [deg]"},
                                                       {"turn_scale_m", "s (turn)", "RMSE [m]"},
                                                       {"turn_ratio_percent", "r (turn)", "RMSE [%]"},
                                                       {"scale_m", "s (all)", "RMSE [m]"},
                                                       {"ratio_percent", "r (all)", "RMSE [%]"}}};

/// A way of recovering the scale: those of `turnscale run --method`, and one more.
struct LabMethod {
  const char* key;
  const char* label;
  const char* color;
};
constexpr std::array<LabMethod, 4> kMethods = {{{"smoothed", "smoothed", "#1565c0"},
                                                {"turns", "turns", "#64b5f6"},
                                                {"weighted", "turns weighted", "#7cb342"},
                                                {"paper", "the paper's", "#f6a03c"}}};

/// The estimator of the laboratory that recovers the scale that way.
ScaleEstimatorSettings EstimatorOf(const LabMethod& method);

/// The synthetic drive at whose speed that side slip (s^2/m) shortens the lever arm.
ScaleDriveOptions SlippingDrive(double side_slip);

/// Trials with the settings' seed and jobs.
ScaleTrials TrialsOf(const LabSettings& settings, const ScaleDriveOptions& drive,
                     const std::vector<ScaleEstimatorSettings>& estimators, int runs);

MeanAndSpread CellOf(const std::vector<ScaleTrial>& runs, const std::function<double(const ScaleTrial&)>& value);

/// Mean, spread and range of the values as a box of that width (in units of x).
PlotBox BoxOf(const std::vector<double>& values, double x, double width, const std::string& label,
              const std::string& color);

/// Values of a column, one a run, in the column's unit. psi and theta are those of the map before its recovery, for any
/// estimator.
std::vector<double> TableValues(const std::vector<ScaleTrial>& runs, std::size_t estimator, std::size_t column);

/// Mean and spread of each column, and the share of the recoveries that converged.
LabJson TableRowJson(const std::vector<ScaleTrial>& runs, std::size_t estimator);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "lab_trials.h"

#include <algorithm>
#include <string_view>

#include "turnscale/geometry/rotation.h"

namespace turnscale {

ScaleEstimatorSettings EstimatorOf(const LabMethod& method) {
  ScaleEstimatorSettings settings;
  const std::string_view key = method.key;
  settings.weighs_turns = key == "weighted";
  settings.odometry.scale.method = key == "paper"      ? ScaleMethod::kPaper
                                   : key == "smoothed" ? ScaleMethod::kSmoothed
                                                       : ScaleMethod::kTurns;
  return settings;
}

ScaleDriveOptions SlippingDrive(double side_slip) {
  ScaleDriveOptions options;
  const double speed = options.drive.length * options.drive.rate_hz / (options.drive.frames - 1);
  options.drive.lever_arm = LeverArm{options.drive.lever_arm, side_slip}.At(speed);
  return options;
}

ScaleTrials TrialsOf(const LabSettings& settings, const ScaleDriveOptions& drive,
                     const std::vector<ScaleEstimatorSettings>& estimators, int runs) {
  ScaleTrials trials;
  trials.drive = drive;
  trials.estimators = estimators;
  trials.runs = runs;
  trials.jobs = settings.jobs;
  trials.seed = settings.seed;
  trials.progress = settings.progress;
  return trials;
}

MeanAndSpread CellOf(const std::vector<ScaleTrial>& runs, const std::function<double(const ScaleTrial&)>& value) {
  std::vector<double> values(runs.size());
  std::ranges::transform(runs, values.begin(), value);
  return MeanAndSpreadOf(values);
}

PlotBox BoxOf(const std::vector<double>& values, double x, double width, const std::string& label,
              const std::string& color) {
  const MeanAndSpread cell = MeanAndSpreadOf(values);
  const auto [low, high] = std::ranges::minmax(values);
  return {x, width, cell.mean, cell.spread, low, high, label, color};
}

std::vector<double> TableValues(const std::vector<ScaleTrial>& runs, std::size_t estimator, std::size_t column) {
  std::vector<double> values;
  for (const ScaleTrial& run : runs) {
    const ScaleErrors& errors = run.recovered[estimator];
    const std::array<double, kTableColumns.size()> row = {run.adjusted.psi * kDegreesPerRadian,
                                                          run.adjusted.theta * kDegreesPerRadian,
                                                          errors.turn_scale,
                                                          100 * errors.turn_ratio,
                                                          errors.scale,
                                                          100 * errors.ratio};
    values.push_back(row.at(column));
  }
  return values;
}

LabJson TableRowJson(const std::vector<ScaleTrial>& runs, std::size_t estimator) {
  LabJson row = LabJson::object();
  for (std::size_t column = 0; column < kTableColumns.size(); ++column) {
    const MeanAndSpread cell = MeanAndSpreadOf(TableValues(runs, estimator, column));
    row[kTableColumns[column].key] = {{"mean", Rounded(cell.mean)}, {"spread", Rounded(cell.spread)}};
  }
  row["converged_percent"] =
      Rounded(100 * CellOf(runs, [estimator](const ScaleTrial& run) { return run.converged[estimator]; }).mean);
  return row;
}

}  // namespace turnscale

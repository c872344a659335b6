// SPDX-License-Identifier: MIT
#include "lab_experiments.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/output_file.h"
#include "turnscale/run/settings.h"

namespace turnscale {
namespace {

LabJson PointsJson(const PlotPoints& points) {
  LabJson json = LabJson::array();
  for (const Eigen::Vector2d& point : points) json.push_back({Rounded(point.x()), Rounded(point.y())});
  return json;
}

}  // namespace

double Rounded(double value) { return std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr); }

LabJson FigureJson(const Figure& figure) {
  LabJson panels = LabJson::array();
  for (const PlotPanel& panel : figure.panels) {
    LabJson json = {{"title", panel.title}, {"x", panel.x_label}, {"y", panel.y_label}};
    for (const PlotLine& line : panel.lines) {
      json["lines"].push_back({{"label", line.label}, {"points", PointsJson(line.points)}});
    }
    for (const PlotBox& box : panel.boxes) {
      json["boxes"].push_back({{"label", box.label},
                               {"x", Rounded(box.x)},
                               {"mean", Rounded(box.mean)},
                               {"sigma", Rounded(box.sigma)},
                               {"low", Rounded(box.low)},
                               {"high", Rounded(box.high)}});
    }
    for (const PlotArea& area : panel.areas) {
      json["areas"].push_back({{"label", area.label}, {"outline", PointsJson(area.outline)}});
    }
    panels.push_back(std::move(json));
  }
  return {{"title", figure.title}, {"panels", std::move(panels)}};
}

void KeepResult(const std::filesystem::path& folder, const std::string& name, const LabResult& result, LabJson& all) {
  LabJson json = {{"values", result.values}};
  Attempts attempts;
  for (const auto& [file, figure] : result.figures) {
    const std::filesystem::path path = folder / (file + ".svg");
    attempts.Try([&, &drawn = figure] { ReplaceFile(path, FigureSvg(drawn)); });
    json["pictures"][file] = FigureJson(figure);
  }
  all[name] = std::move(json);
  // Numbers in one line each would make the file ten times as long: arrays of curves stay compact.
  std::string text = "{\n";
  for (auto entry = all.begin(); entry != all.end(); ++entry) {
    text += (entry == all.begin() ? "" : ",\n") + LabJson(entry.key()).dump() + ": ";
    if (!entry->is_object()) {
      text += entry->dump();
      continue;
    }
    text += "{\n";
    for (auto part = entry->begin(); part != entry->end(); ++part) {
      text += (part == entry->begin() ? "" : ",\n") + ("  " + LabJson(part.key()).dump()) + ": ";
      text += part.key() == "values" ? part->dump(2) : part->dump();
    }
    text += "\n}";
  }
  attempts.Try([&] { ReplaceFile(folder / "lab.json", text + "\n}\n"); });
  attempts.RethrowFirst();
}

ScaleEstimatorSettings EstimatorOf(const LabMethod& method) {
  ScaleEstimatorSettings settings;
  settings.weighs_turns = std::string_view(method.key) == "weighted";
  settings.odometry.scale.method = FindScaleMethod(method.key).value_or(ScaleMethod::kTurns);
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

// SPDX-License-Identifier: MIT
// The paper's Monte Carlo of the calibration (V-B 1, Fig. 9); prints it as JSON, angles in degrees.
// benchmarks/calibration_report runs it.
//   calibration_synthetic PICTURE [RUNS]
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"
#include "turnscale/figure/figure.h"
#include "turnscale/io/output_file.h"
#include "turnscale/laboratory/calibration_trials.h"

namespace turnscale {
namespace {

using Json = nlohmann::ordered_json;
using Angle = double YawPitchRoll::*;

constexpr std::array<double, 4> kNoise = {0.05, 0.2, 0.5, 1.0};
constexpr std::array<Angle, 3> kAngles = {&YawPitchRoll::yaw, &YawPitchRoll::pitch, &YawPitchRoll::roll};
constexpr std::array<const char*, 3> kNames = {"yaw", "pitch", "roll"};

struct Spread {
  double mean = 0;
  double sigma = 0;
  double least = 0;
  double most = 0;
};

Spread SpreadOf(const std::vector<CalibrationTrial>& trials, YawPitchRoll CalibrationTrial::*which, Angle angle) {
  Spread spread;
  const auto count = static_cast<double>(trials.size());
  for (const CalibrationTrial& trial : trials) {
    const double value = trial.*which.*angle * kDegreesPerRadian;
    spread.mean += value / count;
    spread.least = std::min(spread.least, value);
    spread.most = std::max(spread.most, value);
  }
  double squares = 0;
  for (const CalibrationTrial& trial : trials) {
    squares += std::pow(trial.*which.*angle * kDegreesPerRadian - spread.mean, 2);
  }
  spread.sigma = std::sqrt(squares / (count - 1));
  return spread;
}

double RootMeanSquare(const std::vector<CalibrationTrial>& trials, YawPitchRoll CalibrationTrial::*which, Angle angle) {
  double squares = 0;
  for (const CalibrationTrial& trial : trials) squares += std::pow(trial.*which.*angle * kDegreesPerRadian, 2);
  return std::sqrt(squares / static_cast<double>(trials.size()));
}

// Both halves of Fig. 9.
class Picture {
 public:
  Picture() {
    panels_[0].title = "(a) linear only";
    panels_[1].title = "(b) after the refinement";
    for (PlotPanel& panel : panels_) {
      panel.x = PlotRange{0.4, 3.6};
      panel.y_label = "error [deg]";
      panel.x_names = {{1, "yaw (the paper's pitch)"}, {2, "pitch (about x)"}, {3, "roll (about z)"}};
      panel.lines.push_back({{{0.4, 0}, {3.6, 0}}, "", "#777", 1.2, "6 4"});
    }
  }

  void Add(size_t level, size_t angle, const Spread& linear, const Spread& refined) {
    constexpr std::array<const char*, 4> kColors = {"#bbdefb", "#64b5f6", "#1976d2", "#0d3c78"};
    const double x = 1 + static_cast<double>(angle) + 0.2 * (static_cast<double>(level) - 1.5);
    const std::string label = fmt::format("noise {:g} deg", kNoise[level]);
    const auto box = [&](const Spread& spread) {
      return PlotBox{x, 0.16, spread.mean, spread.sigma, spread.least, spread.most, label, kColors[level]};
    };
    panels_[0].boxes.push_back(box(linear));
    panels_[1].boxes.push_back(box(refined));
  }

  std::string Svg(int runs) const {
    Figure figure;
    figure.title = "Calibration of the camera-to-vehicle rotation (the paper's Fig. 9)";
    figure.note = fmt::format("Boxes: mean and one standard deviation; whiskers: range of {} runs.", runs);
    figure.panel_width = 640;
    figure.panel_height = 230;
    figure.panels = {panels_[0], panels_[1]};
    return FigureSvg(figure);
  }

 private:
  std::array<PlotPanel, 2> panels_;
};

Json Rows(double direction_share, int runs, std::uint64_t seed, Picture& picture) {
  Json rows = Json::array();
  for (size_t level = 0; level < kNoise.size(); ++level) {
    CalibrationTrials trials;
    trials.drive = PaperCalibrationDrive();
    trials.rotation_noise = kNoise[level] / kDegreesPerRadian;
    trials.direction_share = direction_share;
    trials.runs = runs;
    trials.seed = seed + level;
    const auto ours = RunCalibrationTrials(trials);
    CalibrationTrials of_paper = trials;
    of_paper.calibration.refinement.travel = TravelModel::kFree;
    of_paper.calibration.refinement.weigh_by_spread = false;
    of_paper.steps.duration = 1 / trials.drive.rate_hz;
    const auto paper = RunCalibrationTrials(of_paper);
    const YawPitchRoll bound = CramerRaoBound(trials);
    for (size_t i = 0; i < kAngles.size(); ++i) {
      const Spread linear = SpreadOf(paper, &CalibrationTrial::linear, kAngles[i]);
      const Spread refined = SpreadOf(ours, &CalibrationTrial::refined, kAngles[i]);
      const Spread free = SpreadOf(paper, &CalibrationTrial::refined, kAngles[i]);
      rows.push_back(
          {{"noise", kNoise[level]},
           {"angle", kNames[i]},
           {"linear_mean", linear.mean},
           {"linear_spread", linear.sigma},
           {"mean", refined.mean},
           {"standard_errors", refined.mean / (refined.sigma / std::sqrt(static_cast<double>(runs)))},
           {"spread", refined.sigma},
           {"over_bound", refined.sigma / (bound.*kAngles[i] * kDegreesPerRadian)},
           {"stated_over_spread", RootMeanSquare(ours, &CalibrationTrial::sigma, kAngles[i]) / refined.sigma},
           {"paper_mean", free.mean},
           {"paper_spread", free.sigma}});
      picture.Add(level, i, linear, refined);
    }
  }
  return rows;
}

}  // namespace
}  // namespace turnscale

int main(int argc, char** argv) {
  const auto runs = argc == 3 ? turnscale::ParseNumber<int>(argv[2]) : 100;
  if (argc < 2 || argc > 3 || !runs || *runs < 2) {
    std::fputs("usage: calibration_synthetic PICTURE [RUNS]\n", stderr);
    return 2;
  }
  try {
    turnscale::Picture picture;
    turnscale::Picture unused;
    turnscale::Json all;
    all["runs"] = *runs;
    all["same"] = turnscale::Rows(1, *runs, 100, picture);
    all["third"] = turnscale::Rows(1.0 / 3, *runs, 200, unused);
    turnscale::ReplaceFile(argv[1], picture.Svg(*runs));
    std::puts(all.dump(1).c_str());
  } catch (const turnscale::InputError& error) {
    std::fprintf(stderr, "calibration_synthetic: %s\n", error.what());
    return 2;
  }
}

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

// A box of Fig. 9: one sigma, the mean, and the range.
std::string Box(double x, double middle, const Spread& spread, const char* color) {
  constexpr double kPixelsPerDegree = 40;
  const auto y = [&](double value) { return middle - kPixelsPerDegree * value; };
  return fmt::format(
      "<path d=\"M{0:.1f},{1:.1f}V{2:.1f}\" stroke=\"#333\"/><rect x=\"{3:.1f}\" y=\"{4:.1f}\" width=\"22\" "
      "height=\"{5:.1f}\" fill=\"{6}\" fill-opacity=\"0.6\"/><path d=\"M{3:.1f},{7:.1f}h22\" stroke=\"#000\"/>\n",
      x, y(spread.least), y(spread.most), x - 11, y(spread.mean + spread.sigma), 2 * kPixelsPerDegree * spread.sigma,
      color, y(spread.mean));
}

// Both halves of the figure.
class Picture {
 public:
  void Add(size_t level, size_t angle, const Spread& linear, const Spread& refined) {
    constexpr std::array<const char*, 4> kColors = {"#90caf9", "#42a5f5", "#1565c0", "#0d2f5c"};
    const double x = 90 + 220 * static_cast<double>(angle) + 40 * static_cast<double>(level);
    boxes_ += Box(x, kLinear, linear, kColors[level]) + Box(x, kRefined, refined, kColors[level]);
  }

  std::string Svg(int runs) const {
    std::string svg =
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 760 560\" width=\"760\" height=\"560\">\n"
        "<style>text{font-family:sans-serif;font-size:13px;fill:#333}</style><rect width=\"100%\" height=\"100%\" "
        "fill=\"#fff\"/>\n";
    svg += boxes_;
    const std::array<const char*, 3> names = {"yaw (the paper's pitch)", "pitch (about x)", "roll (about z)"};
    for (size_t i = 0; i < names.size(); ++i) {
      for (const int middle : {kLinear, kRefined}) {
        svg += fmt::format(
            "<path d=\"M{0},{1}h190\" stroke=\"#888\" stroke-dasharray=\"5 4\"/><text x=\"{0}\" y=\"{2}\">{3}</text>\n",
            65 + 220 * i, middle, middle - 118, names[i]);
      }
    }
    return svg + fmt::format(
                     "<text x=\"24\" y=\"18\">(a) linear only: error, deg (a degree is 40 units); rotation noise 0.05, "
                     "0.2, 0.5, 1 deg from left to right</text><text x=\"24\" y=\"290\">(b) after the refinement; box: "
                     "one sigma, line: mean, whisker: range of {} runs</text></svg>\n",
                     runs);
  }

 private:
  static constexpr int kLinear = 150;
  static constexpr int kRefined = 420;
  std::string boxes_;
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

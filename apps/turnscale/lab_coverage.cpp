// SPDX-License-Identifier: MIT
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>

#include "lab_experiments.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/scale/scale_evidence.h"

namespace turnscale {
namespace {

constexpr double kPixelNoiseOfCoverage = 1;

// How often the truth is within what an estimator states.
struct Coverage {
  int stated = 0;     // runs with a sigma
  double within = 0;  // share of them within one sigma
  double within_two = 0;
  double mean = 0;  // of the errors over their sigmas
  double rms = 0;
};

Coverage CoverageOf(const std::vector<ScaleTrial>& runs, std::vector<StatedError> ScaleTrial::*which) {
  Coverage coverage;
  for (const ScaleTrial& run : runs) {
    const StatedError& stated = (run.*which).front();
    if (!std::isfinite(stated.sigma)) continue;
    const double deviation = stated.error / stated.sigma;
    ++coverage.stated;
    coverage.within += std::abs(deviation) <= 1 ? 1 : 0;
    coverage.within_two += std::abs(deviation) <= 2 ? 1 : 0;
    coverage.mean += deviation;
    coverage.rms += deviation * deviation;
  }
  if (coverage.stated == 0) return coverage;
  for (double* sum : {&coverage.within, &coverage.within_two, &coverage.mean, &coverage.rms}) *sum /= coverage.stated;
  coverage.rms = std::sqrt(coverage.rms);
  return coverage;
}

LabJson CoverageJson(const Coverage& coverage) {
  return {{"runs", coverage.stated},
          {"within_one_percent", Rounded(100 * coverage.within)},
          {"within_two_percent", Rounded(100 * coverage.within_two)},
          {"mean", Rounded(coverage.mean)},
          {"rms", Rounded(coverage.rms)}};
}

std::string CoverageLine(const std::string& what, const Coverage& coverage) {
  return fmt::format(
      "coverage  {:<10} {:4} runs, {:3.0f} % within one sigma, {:3.0f} % within two; deviations: mean {:+.2f}, RMS "
      "{:.2f}",
      what, coverage.stated, 100 * coverage.within, 100 * coverage.within_two, coverage.mean, coverage.rms);
}

}  // namespace

LabResult LabCoverage(const LabSettings& settings) {
  const CarPrior car;
  ScaleEstimatorSettings estimator = EstimatorOf(kMethods.front());
  estimator.odometry.vehicle.lever_arm_sigma = car.lever_arm_sigma;
  estimator.odometry.vehicle.side_slip = car.side_slip;
  estimator.odometry.vehicle.side_slip_sigma = car.side_slip_sigma;
  ScaleTrials trials = TrialsOf(settings, SlippingDrive(car.side_slip), {estimator}, settings.runs);
  trials.drive.pixel_noise = kPixelNoiseOfCoverage;
  trials.told_wrong = {car.lever_arm_sigma, car.side_slip_sigma, car.yaw_sigma};
  const std::vector<ScaleTrial> runs = RunScaleTrials(trials);
  if (runs.empty()) return {};
  LabResult result;
  result.values = {{"runs", settings.runs},
                   {"pixel_noise", kPixelNoiseOfCoverage},
                   {"lever_arm_sigma_m", car.lever_arm_sigma},
                   {"side_slip_sigma", car.side_slip_sigma},
                   {"yaw_sigma_deg", car.yaw_sigma * kDegreesPerRadian}};
  for (const auto& [key, label, which] : {std::tuple{"length", "path", &ScaleTrial::length},
                                          std::tuple{"side_slip", "side slip", &ScaleTrial::side_slip}}) {
    const Coverage coverage = CoverageOf(runs, which);
    result.values[key] = CoverageJson(coverage);
    result.lines.push_back(CoverageLine(label, coverage));
  }
  return result;
}

}  // namespace turnscale

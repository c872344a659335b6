// SPDX-License-Identifier: MIT
#include "turnscale/scale/image_stabilisation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "turnscale/base/check_part.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/base/robust_weights.h"
#include "turnscale/base/square.h"
#include "turnscale/kinematics/pooled_line.h"
#include "turnscale/scale/turn_test.h"

namespace turnscale {
namespace {

constexpr int kSmoothingReweightings = 20;
constexpr double kSmoothingHuber = 1.5;  // robust standard deviations
constexpr std::size_t kFewestSteps = 8;  // to fit a variance to
constexpr double kMostScaleError = 0.5;  // that stabilisation causes, relative

// A step whose lateral displacement may show smoothing.
struct SmoothedStep {
  double by_variance = 0;   // derivative of the lateral displacement by V, odometry units per s^2
  double residual = 0;      // of the lateral displacement, odometry units
  double rate = 0;          // yaw rate, rad/s
  double acceleration = 0;  // yaw acceleration, rad/s^2
  double duration = 0;      // s
};

double YawRate(const VehicleStep& step) { return step.motion.psi / step.duration; }

// What the model of the car leaves of the lateral displacement of a step, to second order in the lag: the images show
// the yaw that the car had this much earlier.
double LateralResidual(const VehicleStep& step, double acceleration, const DriveState& state) {
  const double scale = std::exp(state[kLogScale]);
  const double lever_arm = std::exp(state[kLogLeverArm]) / scale - state[kSlip] * scale * step.signed_square_speed();
  const double turned_since = state[kLag] * acceleration * step.duration;
  return step.lateral() - lever_arm * (step.swing() + turned_since) -
         state[kLag] * step.signed_speed() * (step.swing() + 0.5 * turned_since) -
         state[kRollHeight] / scale * step.roll - state[kDirection] * step.forward();
}

std::vector<SmoothedStep> SmoothedSteps(std::span<const VehicleStep> steps, const std::vector<PathSegment>& segments,
                                        const std::vector<ScaleBelief>& states) {
  const auto is_timed = [](const VehicleStep& step) { return step.shows_kinematics() && step.duration > 0; };
  std::vector<SmoothedStep> smoothed;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const int last = std::min(segments[k].last, static_cast<int>(steps.size()) - 2);
    for (int i = std::max(segments[k].first, 1); i <= last; ++i) {
      const VehicleStep& before = steps[i - 1];
      const VehicleStep& step = steps[i];
      const VehicleStep& after = steps[i + 1];
      if (!is_timed(before) || !is_timed(step) || !is_timed(after)) continue;
      const double seconds = 0.5 * before.duration + step.duration + 0.5 * after.duration;
      const double acceleration = (YawRate(after) - YawRate(before)) / seconds;
      smoothed.push_back({.by_variance = -0.5 * step.forward() * acceleration,
                          .residual = LateralResidual(step, acceleration, states[k].mean),
                          .rate = YawRate(step),
                          .acceleration = acceleration,
                          .duration = step.duration});
    }
  }
  return smoothed;
}

double ScaleError(double variance, const std::vector<SmoothedStep>& steps) {
  double accelerations = 0;
  double rates = 0;
  for (const SmoothedStep& step : steps) {
    accelerations += Square(step.acceleration) * step.duration;
    rates += Square(step.rate) * step.duration;
  }
  return rates > 0 ? 0.5 * variance * accelerations / rates : 0;
}

}  // namespace

void StabilisationOptions::Check() const {
  Require(min_lag_deviation > 0, "min_lag_deviation: has to be positive");
  Require(min_lag_deviation_with_less_scatter > 0 && min_lag_deviation_with_less_scatter <= min_lag_deviation,
          "min_lag_deviation_with_less_scatter: has to be above 0 and at most min_lag_deviation");
  Require(min_reduction_significance > 0, "min_reduction_significance: has to be positive");
  Require(min_scale_change >= 0, "min_scale_change: must not be negative");
  Require(lag_sigma > 0 && lag_sigma < 10, "lag_sigma: has to be above 0 and below 10 s");
  Require(min_lag_turns >= 0, "min_lag_turns: must not be negative");
  Require(max_lag_sigma > 0, "max_lag_sigma: has to be positive");
  Require(min_smoothing > 0, "min_smoothing: has to be positive");
  Require(min_smoothing_deviation > 0, "min_smoothing_deviation: has to be positive");
}

bool LagCounts(const SmoothedDrive& without, const SmoothedDrive& with, const StabilisationOptions& options) {
  if (!with.converged) return false;
  const SmoothedScale& before = without.smoothed;
  const SmoothedScale& after = with.smoothed;
  const ScaleBelief& last = after.segments.back();
  const double sigma = InflationOf(after.chi_squared, after.degrees_of_freedom) * last.Sigma(kLag);
  const bool scatters_less = before.degrees_of_freedom == after.degrees_of_freedom &&
                             ReductionSignificance(before.chi_squared, after.chi_squared,
                                                   after.degrees_of_freedom - 1) > options.min_reduction_significance;
  const double least = scatters_less ? options.min_lag_deviation_with_less_scatter : options.min_lag_deviation;
  if (!(sigma < options.max_lag_sigma && std::abs(last.mean[kLag]) > least * sigma)) return false;
  const double change = last.mean[kLogScale] - before.segments.back().mean[kLogScale];
  return std::abs(change) > options.min_scale_change;
}

std::optional<ImageSmoothing> FindImageSmoothing(std::span<const VehicleStep> all_steps,
                                                 const std::vector<PathSegment>& segments,
                                                 const std::vector<ScaleBelief>& states, double sigma_theta,
                                                 const StabilisationOptions& options) {
  const std::vector<SmoothedStep> steps = SmoothedSteps(all_steps, segments, states);
  if (steps.size() < kFewestSteps) return std::nullopt;
  const double noise_floor = LateralNoise(all_steps, sigma_theta);
  ImageSmoothing smoothing;
  std::vector<double> weights(steps.size(), 1.0);
  for (int round = 0; round < kSmoothingReweightings; ++round) {
    double information = 0;
    double sum = 0;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      information += weights[i] * Square(steps[i].by_variance);
      sum += weights[i] * steps[i].by_variance * steps[i].residual;
    }
    if (!(information > 0)) return std::nullopt;
    smoothing.variance = sum / information;
    std::vector<double> off;
    for (const SmoothedStep& step : steps) off.push_back(step.residual - smoothing.variance * step.by_variance);
    const double spread = std::max(RobustSigma(off), noise_floor);
    smoothing.variance_sigma = spread / std::sqrt(information);
    for (std::size_t i = 0; i < steps.size(); ++i) weights[i] = HuberWeight(off[i], kSmoothingHuber * spread);
  }
  const double least =
      std::max(Square(options.min_smoothing), options.min_smoothing_deviation * smoothing.variance_sigma);
  if (!(smoothing.variance > least)) return std::nullopt;
  smoothing.scale_error = ScaleError(smoothing.variance, steps);
  // Where times or poses are wrong, yaw accelerations are, and look like any smoothing.
  if (!(smoothing.scale_error < kMostScaleError)) return std::nullopt;
  return smoothing;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/speed_smoother.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include <Eigen/Core>
#include <Eigen/LU>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Position, speed, acceleration.
struct CarState {
  Vector3d mean = Vector3d::Zero();
  Matrix3d covariance = Matrix3d::Zero();
};

// Standard deviations of a position that are tried, metres: from an ideal simulator to a poor camera.
constexpr std::array kNoises = {0.0005, 0.001, 0.002, 0.004, 0.008, 0.016, 0.032, 0.064, 0.128};
constexpr double kOutlier = 3;  // standard deviations
// Before the first reading: any speed and acceleration of a car.
constexpr double kFirstSpeedSigma = 30;
constexpr double kFirstAccelerationSigma = 3;

Matrix3d Transition(double seconds) {
  Matrix3d transition = Matrix3d::Identity();
  transition(0, 1) = transition(1, 2) = seconds;
  transition(0, 2) = 0.5 * seconds * seconds;
  return transition;
}

Matrix3d WalkOf(double acceleration_walk, double t) {
  const double t2 = t * t;
  const double t3 = t2 * t;
  Matrix3d walk;
  walk << t3 * t2 / 20, t2 * t2 / 8, t3 / 6,  //
      t2 * t2 / 8, t3 / 3, t2 / 2,            //
      t3 / 6, t2 / 2, t;
  return acceleration_walk * acceleration_walk * walk;
}

class Filter {
 public:
  Filter(const std::vector<PathReading>& readings, const SpeedSmootherOptions& options, double noise)
      : readings_(readings), options_(options), variance_(noise * noise) {}

  // The state at each reading, from the readings so far. Returns the log-likelihood.
  double Run(std::vector<CarState>* predicted, std::vector<CarState>* filtered) {
    CarState state;
    state.mean = {readings_.front().position, 0, 0};
    state.covariance =
        Vector3d(variance_, kFirstSpeedSigma * kFirstSpeedSigma, kFirstAccelerationSigma * kFirstAccelerationSigma)
            .asDiagonal();
    double likelihood = 0;
    double unmeasured = 0;  // metres since the last measured reading
    for (size_t i = 0; i < readings_.size(); ++i) {
      if (i > 0) {
        const double seconds = readings_[i].time - readings_[i - 1].time;
        if (!(readings_[i - 1].measured && readings_[i].measured)) unmeasured += state.mean[1] * seconds;
        Predict(seconds, state);
      }
      // The error of a gap is one for the whole of it.
      if (readings_[i].measured) {
        const double gap_sigma = options_.gap_sigma * std::exchange(unmeasured, 0.0);
        state.covariance(0, 0) += gap_sigma * gap_sigma;
      }
      if (predicted) predicted->push_back(state);
      if (readings_[i].measured && i > 0) likelihood += Update(readings_[i].position, state);
      if (filtered) filtered->push_back(state);
    }
    return likelihood;
  }

 private:
  void Predict(double seconds, CarState& state) const {
    const Matrix3d transition = Transition(seconds);
    state.mean = transition * state.mean;
    state.covariance =
        transition * state.covariance * transition.transpose() + WalkOf(options_.acceleration_walk, seconds);
  }

  double Update(double position, CarState& state) const {
    const double innovation = position - state.mean[0];
    double variance = state.covariance(0, 0) + variance_;
    const double deviation = std::abs(innovation) / std::sqrt(variance);
    const double likelihood =
        -0.5 * (std::min(deviation * deviation, 2 * kOutlier * deviation - kOutlier * kOutlier) + std::log(variance));
    // Down-weighted more than Huber's function does: a jump of the path is no speed.
    if (deviation > kOutlier) variance += variance_ * (std::pow(deviation / kOutlier, 2) - 1);
    const Vector3d gain = state.covariance.col(0) / variance;
    state.mean += gain * innovation;
    state.covariance -= gain * state.covariance.row(0);
    state.covariance = 0.5 * (state.covariance + state.covariance.transpose()).eval();
    return likelihood;
  }

  const std::vector<PathReading>& readings_;
  const SpeedSmootherOptions& options_;
  double variance_;
};

double MostLikelyNoise(const std::vector<PathReading>& readings, const SpeedSmootherOptions& options) {
  double best = kNoises.front();
  double highest = -std::numeric_limits<double>::infinity();
  for (const double noise : kNoises) {
    const double likelihood = Filter(readings, options, noise).Run(nullptr, nullptr);
    if (likelihood <= highest) continue;
    highest = likelihood;
    best = noise;
  }
  return best;
}

}  // namespace

std::optional<SpeedReading> SpeedAt(const std::vector<SpeedReading>& readings, double time) {
  constexpr double kSame = 1e-6;  // seconds
  const auto reading = std::ranges::lower_bound(readings, time - kSame, {}, &SpeedReading::time);
  return reading != readings.end() && reading->time < time + kSame ? std::optional(*reading) : std::nullopt;
}

std::vector<SpeedReading> SmoothSpeed(const std::vector<PathReading>& readings, const SpeedSmootherOptions& options) {
  constexpr int kLeast = 3;
  Ensure(readings.empty() || readings.front().measured, "the first reading of a path is a measured one");
  if (std::count_if(readings.begin(), readings.end(), [](const auto& r) { return r.measured; }) < kLeast) return {};
  std::vector<CarState> predicted;
  std::vector<CarState> smoothed;
  Filter(readings, options, MostLikelyNoise(readings, options)).Run(&predicted, &smoothed);
  for (size_t i = readings.size() - 1; i-- > 0;) {
    const Matrix3d transition = Transition(readings[i + 1].time - readings[i].time);
    const Matrix3d gain = smoothed[i].covariance * transition.transpose() * predicted[i + 1].covariance.inverse();
    smoothed[i].mean += gain * (smoothed[i + 1].mean - predicted[i + 1].mean);
    smoothed[i].covariance += gain * (smoothed[i + 1].covariance - predicted[i + 1].covariance) * gain.transpose();
  }
  std::vector<SpeedReading> speeds;
  speeds.reserve(readings.size());
  for (size_t i = 0; i < readings.size(); ++i)
    speeds.push_back({readings[i].time, smoothed[i].mean[1], std::sqrt(std::max(0.0, smoothed[i].covariance(1, 1)))});
  return speeds;
}

}  // namespace turnscale

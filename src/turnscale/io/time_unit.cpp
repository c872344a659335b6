// SPDX-License-Identifier: MIT
#include "turnscale/io/time_unit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "turnscale/base/quantiles.h"

namespace turnscale {
namespace {

constexpr std::array kUnits = {1e-3, 1e-6, 1e-9};  // s
constexpr double kLatestSeconds = 1e11;            // three thousand years
constexpr double kLongestSeconds = 1000;           // between poses

// 0 where there is no step.
double MedianStep(const std::vector<double>& times) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  return Median(std::move(steps));
}

// Since 1970, as most clocks count.
bool IsOfThisCentury(double seconds) { return seconds > 9.4e8 && seconds < 4.2e9; }

}  // namespace

double SecondsPerUnit(const std::vector<double>& times) {
  const double step = MedianStep(times);
  if (times.empty() || (times.back() <= kLatestSeconds && step <= kLongestSeconds)) return 1;
  // A clock that counts nanoseconds since its start may show microseconds of this century; the step tells.
  for (const double unit : kUnits)
    if (IsOfThisCentury(unit * times.back()) && unit * step <= 10) return unit;
  const auto distance = [&](double unit) { return std::abs(std::log10(unit * step / 0.1)); };
  return *std::min_element(kUnits.begin(), kUnits.end(), [&](double a, double b) { return distance(a) < distance(b); });
}

std::vector<double> InSeconds(std::vector<double> times) {
  const double unit = SecondsPerUnit(times);
  for (double& time : times) time *= unit;
  return times;
}

}  // namespace turnscale

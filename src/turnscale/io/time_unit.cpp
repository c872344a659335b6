// SPDX-License-Identifier: MIT
#include "turnscale/io/time_unit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/frame_interval.h"
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

// Between images, and poses of keyframes.
bool IsUsualStep(double seconds) { return seconds > 5e-4 && seconds < 1.5; }

}  // namespace

double SecondsPerUnit(const std::vector<double>& times) {
  const double step = MedianStep(times);
  if (times.empty() || (times.back() <= kLatestSeconds && step <= kLongestSeconds)) return 1;
  const auto rank = [&](double unit) {
    return 2 * (step == 0 || IsUsualStep(unit * step)) + IsOfThisCentury(unit * times.back());
  };
  const auto distance = [&](double unit) { return step > 0 ? std::abs(std::log10(unit * step / 0.1)) : 0.0; };
  return *std::ranges::max_element(kUnits, {}, [&](double unit) { return std::pair(rank(unit), -distance(unit)); });
}

std::vector<double> InSeconds(std::vector<double> times) {
  const double unit = SecondsPerUnit(times);
  for (double& time : times) time *= unit;
  return times;
}

void RefuseSparseTimes(const std::string& name, const std::vector<double>& seconds, const std::string& remedy) {
  const double step = MedianStep(seconds);
  if (step > kLongestFrameInterval)
    throw InputError(
        fmt::format("{}: half of the times are {:.0f} s apart or more; are they milliseconds, or numbers of frames? {}",
                    name, step, remedy));
}

bool AreNanoseconds(const std::vector<double>& times) { return times.size() < 2 || 1e-9 * MedianStep(times) > 1e-4; }

}  // namespace turnscale

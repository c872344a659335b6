// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/pooled_scale.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/scale_line.h"

namespace turnscale {
namespace {

/// Where a weight falls below this the step disagrees rather than scatters.
constexpr double kInlierWeight = 0.1;

PooledScaleResult NoScale(std::string reason) { return {std::nullopt, std::move(reason)}; }

std::string Text(const char* format, double a, double b) {
  char text[200];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

std::vector<ScaleLinePoint> LinePoints(const std::vector<TurningStep>& steps, double side_slip) {
  std::vector<ScaleLinePoint> points;
  points.reserve(steps.size());
  for (const TurningStep& step : steps) {
    const double half = 0.5 * step.motion.psi;
    const double speed = side_slip > 0 ? step.motion.step / step.dt : 0.0;
    points.push_back(
        {2.0 * std::sin(half), step.motion.step * std::sin(step.motion.theta - half), side_slip * speed * speed});
  }
  return points;
}

/// Sideways noise (units) that the direction's noise makes in a step of ordinary length.
double NoiseFloor(const std::vector<TurningStep>& steps, double sigma_theta) {
  double sum = 0;
  for (const TurningStep& step : steps) sum += step.motion.step * step.motion.step;
  return sigma_theta * std::sqrt(sum / static_cast<double>(steps.size()));
}

bool AllFinite(const std::vector<TurningStep>& steps) {
  return std::all_of(steps.begin(), steps.end(), [](const TurningStep& s) {
    return std::isfinite(s.motion.psi) && std::isfinite(s.motion.theta) && std::isfinite(s.motion.step) &&
           s.motion.step >= 0;
  });
}

bool AllTimed(const std::vector<TurningStep>& steps) {
  return std::all_of(steps.begin(), steps.end(), [](const TurningStep& s) { return s.dt > 0; });
}

}  // namespace

void PooledScaleOptions::Check() const {
  const auto require = [](bool good, const std::string& what) {
    if (!good) throw InputError("pooled scale: " + what);
  };
  require(std::isfinite(sigma_theta) && sigma_theta > 0, "sigma_theta must be positive");
  require(std::isfinite(robust_threshold) && robust_threshold > 0, "robust_threshold must be positive");
  require(min_inliers >= 1, "min_inliers must be at least 1");
  require(std::isfinite(min_angle) && min_angle >= 0, "min_angle must not be negative");
  require(std::isfinite(min_lever_share) && min_lever_share >= 0, "min_lever_share must not be negative");
  require(max_relative_sigma > 0, "max_relative_sigma must be positive");
}

PooledScaleResult PoolScale(const std::vector<TurningStep>& steps, const LeverArm& lever_arm,
                            const PooledScaleOptions& options) {
  lever_arm.Check();
  options.Check();
  if (steps.empty()) return NoScale("no steps");
  if (!AllFinite(steps)) return NoScale("a step is not a number");
  if (lever_arm.side_slip > 0 && !AllTimed(steps)) return NoScale("side slip needs the time of every step");
  const double noise_floor = NoiseFloor(steps, options.sigma_theta);
  if (noise_floor == 0) return NoScale("the camera stands still");

  const std::vector<ScaleLinePoint> points = LinePoints(steps, lever_arm.side_slip);
  const ScaleLine line = options.method == ScaleMethod::kPooledLine
                             ? FitScaleLine(points, lever_arm.length, noise_floor, options.robust_threshold)
                             : MedianScale(points, lever_arm.length);
  if (!std::isfinite(line.scale) || line.scale <= 0) {
    return NoScale("the camera does not swing outwards as its lever arm demands");
  }

  PooledScale scale{line.scale, line.sigma, 0, 0};
  double inlier_angle = 0;
  double xy = 0;
  double xx = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    xy += line.weight[i] * points[i].x * points[i].y;
    xx += line.weight[i] * points[i].x * points[i].x;
    if (line.weight[i] < kInlierWeight) continue;
    ++scale.inliers;
    inlier_angle += std::abs(steps[i].motion.psi);
  }
  scale.effective_lever_arm = line.scale * xy / xx;

  const int n = static_cast<int>(steps.size());
  if (scale.inliers < std::max(options.min_inliers, (n + 1) / 2)) {
    return NoScale(Text("only %.0f of %.0f steps agree", scale.inliers, n));
  }
  if (inlier_angle < options.min_angle) {
    return NoScale(Text("the agreeing steps turn by %.1f deg, less than %.1f", inlier_angle * kDegreesPerRadian,
                        options.min_angle * kDegreesPerRadian));
  }
  if (scale.effective_lever_arm < options.min_lever_share * lever_arm.length) {
    return NoScale(
        Text("side slip leaves an effective lever arm of %.2f m of %.2f", scale.effective_lever_arm, lever_arm.length));
  }
  if (scale.sigma > options.max_relative_sigma * scale.metres_per_unit) {
    return NoScale(Text("scale uncertain by %.0f %%, more than %.0f", 100 * scale.sigma / scale.metres_per_unit,
                        100 * options.max_relative_sigma));
  }
  return {scale, {}};
}

std::optional<double> ObservedLeverArm(const std::vector<TurningStep>& steps, double metres_per_unit,
                                       const PooledScaleOptions& options) {
  options.Check();
  if (steps.empty() || !AllFinite(steps)) return std::nullopt;
  const double noise_floor = NoiseFloor(steps, options.sigma_theta);
  if (noise_floor == 0) return std::nullopt;
  // A lever arm of 1 m without slip turns the line's scale into metres of lever arm per unit.
  const ScaleLine line = FitScaleLine(LinePoints(steps, 0), 1.0, noise_floor, options.robust_threshold);
  if (!std::isfinite(line.scale) || line.scale <= 0) return std::nullopt;
  return metres_per_unit / line.scale;
}

}  // namespace turnscale

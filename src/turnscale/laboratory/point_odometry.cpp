// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/point_odometry.h"

#include <cmath>

#include "turnscale/base/error.h"
#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/mapping/map_scaling.h"
#include "turnscale/mapping/window_problem.h"

namespace turnscale {
namespace {

constexpr int kIterations = 20;
// Started at the truth, a step that gains less moves nothing by a noticeable part of its sigma.
constexpr double kCostTolerance = 1e-4;

}  // namespace

Map PointOdometry(const ScaleDrive& drive) {
  Map map = drive.truth;
  WindowProblem problem = MakeWindowProblem(map, {0, 1}, drive.pixel_noise);
  BundleOptions options;
  options.max_iterations = kIterations;
  options.huber_threshold = 0;  // the noise is Gaussian
  options.relative_cost_tolerance = kCostTolerance;
  const BundleSummary summary = AdjustBundle(options, problem.bundle);
  if (!summary.converged) throw NumericalError("the synthetic drive's bundle adjustment: " + summary.message);
  WriteBack(problem, map);
  return map;
}

void LoseScale(double loss, int frames, Map& map) {
  std::vector<double> factors;
  for (const Keyframe& keyframe : map.keyframes)
    factors.push_back(std::pow(1 - loss, static_cast<double>(keyframe.frame) / frames));
  ScaleMap(factors, 0, map);
}

}  // namespace turnscale

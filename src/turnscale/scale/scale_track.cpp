// SPDX-License-Identifier: MIT
#include "turnscale/scale/scale_track.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace turnscale {
namespace {

// Length of the path up to each pose, odometry units. Poses within a step lie evenly along it.
std::vector<double> LengthsUpTo(int poses, const std::vector<VehicleStep>& steps) {
  std::vector<double> lengths(poses, 0);
  double length = 0;
  for (const VehicleStep& step : steps) {
    for (int i = step.first + 1; i <= step.last; ++i)
      lengths[i] = length + step.driven() * (i - step.first) / (step.last - step.first);
    length += step.driven();
  }
  for (int i = steps.back().last + 1; i < poses; ++i) lengths[i] = length;
  return lengths;
}

}  // namespace

std::vector<PoseScale> ScaleTrack(int poses, const std::vector<VehicleStep>& steps, const ScaleEstimate& estimate) {
  const std::vector<PathSegment>& segments = estimate.segments;
  const std::vector<double> lengths = LengthsUpTo(poses, steps);
  const auto begins = [&](std::size_t k, int pose) {
    return segments[k].gap_sigma > 0 ? pose >= steps[segments[k].first].last : segments[k].middle <= lengths[pose];
  };
  std::vector<PoseScale> scales;
  scales.reserve(poses);
  std::size_t next = 0;  // first segment whose middle, or the gap before which, is still ahead
  for (int i = 0; i < poses; ++i) {
    while (next < segments.size() && begins(next, i)) ++next;
    const std::size_t before = next == 0 ? 0 : next - 1;
    const std::size_t after = std::min(next, segments.size() - 1);
    double ratio = 0;
    if (after != before && segments[after].gap_sigma == 0) {
      const double from = segments[before].middle;
      ratio = std::clamp((lengths[i] - from) / (segments[after].middle - from), 0.0, 1.0);
    }
    const auto between = [&](double a, double b) { return (1 - ratio) * a + ratio * b; };
    const ScaleBelief& a = estimate.smoothed[before];
    const ScaleBelief& b = estimate.smoothed[after];
    scales.push_back({std::exp(between(a.mean[kLogScale], b.mean[kLogScale])), between(a.sigma(), b.sigma())});
  }
  for (const VehicleStep& step : steps)
    if (step.after_gap) scales[step.last].after_gap = true;
  for (std::size_t k = 0; k < segments.size(); ++k)
    for (int i = steps[segments[k].first].first + 1; i <= steps[segments[k].last].last; ++i)
      scales[i].from_road = estimate.from_road[k] != 0;
  return scales;
}

std::vector<Eigen::Vector3d> MetricPositions(const std::vector<Eigen::Vector3d>& positions,
                                             const std::vector<PoseScale>& scales) {
  std::vector<Eigen::Vector3d> metric;
  metric.reserve(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (i == 0) {
      metric.push_back(scales[0].metres_per_unit * positions[0]);
      continue;
    }
    const double before = scales[i - 1].metres_per_unit;
    const double scale = scales[i].after_gap ? before : 0.5 * (before + scales[i].metres_per_unit);
    metric.push_back(metric.back() + scale * (positions[i] - positions[i - 1]));
  }
  return metric;
}

}  // namespace turnscale

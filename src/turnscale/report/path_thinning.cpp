// SPDX-License-Identifier: MIT
#include "turnscale/report/path_thinning.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace turnscale {
namespace {

// Length, turning and duration of a step.
std::array<double, 3> Extent(const StampedPose& from, const StampedPose& to) {
  return {(to.world_from_camera.translation - from.world_from_camera.translation).norm(),
          from.world_from_camera.rotation.angularDistance(to.world_from_camera.rotation), to.time - from.time};
}

}  // namespace

std::vector<int> ThinPath(const Trajectory& trajectory, int most, const std::vector<int>& kept) {
  const int count = static_cast<int>(trajectory.size());
  std::vector<int> places;
  if (count <= most) {
    places.resize(count);
    std::iota(places.begin(), places.end(), 0);
    return places;
  }
  std::array<double, 3> total{};
  for (int i = 1; i < count; ++i) {
    const std::array<double, 3> step = Extent(trajectory[i - 1], trajectory[i]);
    for (size_t k = 0; k < step.size(); ++k) total[k] += step[k];
  }
  places = {0, count - 1};
  places.insert(places.end(), kept.begin(), kept.end());
  double passed = 0;
  double next = 0;
  for (int i = 1; i < count; ++i) {
    const std::array<double, 3> step = Extent(trajectory[i - 1], trajectory[i]);
    for (size_t k = 0; k < step.size(); ++k) passed += total[k] > 0 ? step[k] / total[k] / step.size() : 0;
    if (passed < next) continue;
    places.push_back(i);
    next = passed + 1.0 / most;
  }
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places;
}

}  // namespace turnscale

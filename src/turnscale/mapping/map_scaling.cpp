// SPDX-License-Identifier: MIT
#include "turnscale/mapping/map_scaling.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace turnscale {

std::vector<Eigen::Vector3d> KeyframeCentres(const Map& map, int first) {
  std::vector<Eigen::Vector3d> centres;
  centres.reserve(map.keyframes.size() - first);
  for (size_t k = first; k < map.keyframes.size(); ++k) centres.push_back(Centre(map.keyframes[k]));
  return centres;
}

void SetKeyframeCentres(const std::vector<Eigen::Vector3d>& centres, Map& map) {
  for (std::size_t k = 0; k < centres.size(); ++k) {
    RigidTransform& camera_from_world = map.keyframes[k].camera_from_world;
    camera_from_world.translation = -(camera_from_world.rotation * centres[k]);
  }
}

std::vector<double> StepFactors(const std::vector<Eigen::Vector3d>& centres, const std::vector<TurnScale>& turns,
                                const std::vector<int>& gaps) {
  std::vector<double> factors(centres.size(), turns.back().factor);
  std::fill_n(factors.begin(), turns.front().first_step, turns.front().factor);
  for (const TurnScale& turn : turns) {
    for (int j = turn.first_step; j <= turn.last_step; ++j) factors[j] = turn.factor;
  }
  for (std::size_t i = 1; i < turns.size(); ++i) {
    const int first = turns[i - 1].last_step + 1;
    const int end = turns[i].first_step;
    const auto gap = std::ranges::find_if(gaps, [&](int j) { return j >= first && j < end; });
    if (gap != gaps.end()) {
      // What lies before a gap shares nothing with the next turn: its scale is the previous one's. The bridged step is
      // predicted, in the unit before it.
      std::fill(factors.begin() + first, factors.begin() + *gap + 1, turns[i - 1].factor);
      std::fill(factors.begin() + *gap + 1, factors.begin() + end, turns[i].factor);
      continue;
    }
    double path = 0;
    for (int j = first; j < end; ++j) path += (centres[j] - centres[j - 1]).norm();
    const double growth = std::log(turns[i].factor / turns[i - 1].factor);
    double travelled = 0;
    for (int j = first; j < end; ++j) {
      const double step = (centres[j] - centres[j - 1]).norm();
      const double share = path > 0 ? (travelled + 0.5 * step) / path : 0.5;
      factors[j] = turns[i - 1].factor * std::exp(share * growth);
      travelled += step;
    }
  }
  return factors;
}

std::vector<Eigen::Vector3d> ScaleSteps(const std::vector<Eigen::Vector3d>& centres,
                                        const std::vector<double>& step_factors) {
  std::vector<Eigen::Vector3d> scaled = centres;
  if (centres.size() > 1) scaled[0] *= step_factors[1];
  for (std::size_t j = 1; j < centres.size(); ++j) {
    scaled[j] = scaled[j - 1] + step_factors[j] * (centres[j] - centres[j - 1]);
  }
  return scaled;
}

std::vector<double> KeyframeFactors(const std::vector<Eigen::Vector3d>& before,
                                    const std::vector<Eigen::Vector3d>& after, int first,
                                    const std::vector<double>& fallback) {
  const int last = static_cast<int>(before.size()) - 1;
  std::vector<double> factors(before.size(), 1.0);
  for (int k = first; k <= last; ++k) {
    double path_before = 0;
    double path_after = 0;
    for (int j = std::max(first + 1, k - 1); j <= std::min(last, k + 2); ++j) {
      path_before += (before[j] - before[j - 1]).norm();
      path_after += (after[j] - after[j - 1]).norm();
    }
    const double own = fallback[std::min(k + 1, last)];
    factors[k] = path_before > 0 && path_after > 0 ? path_after / path_before : own;
  }
  return factors;
}

int ClosestObserver(const Landmark& landmark, const std::vector<Eigen::Vector3d>& centres) {
  const auto distance = [&](const LandmarkObservation& seen) {
    return (landmark.position - centres[seen.keyframe]).squaredNorm();
  };
  return std::ranges::min_element(landmark.observations, {}, distance)->keyframe;
}

std::vector<int> LandmarksInUse(const Map& map) {
  std::vector<int> in_use;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    if (map.landmarks[i].valid && !map.landmarks[i].observations.empty()) in_use.push_back(static_cast<int>(i));
  }
  return in_use;
}

void CarryLandmarks(const std::vector<Eigen::Vector3d>& before, const std::vector<Eigen::Vector3d>& after, int first,
                    const std::vector<double>& keyframe_factors, const std::vector<int>& landmarks, Map& map) {
  for (const int index : landmarks) {
    Landmark& landmark = map.landmarks[index];
    const int k = ClosestObserver(landmark, before);
    if (k < first) continue;
    landmark.position = after[k] + keyframe_factors[k] * (landmark.position - before[k]);
  }
}

void ScaleMap(const std::vector<double>& step_factors, Map& map) {
  const std::vector<Eigen::Vector3d> before = KeyframeCentres(map);
  const std::vector<Eigen::Vector3d> after = ScaleSteps(before, step_factors);
  const std::vector<double> factors = KeyframeFactors(before, after, 0, step_factors);
  CarryLandmarks(before, after, 0, factors, LandmarksInUse(map), map);
  SetKeyframeCentres(after, map);
}

}  // namespace turnscale

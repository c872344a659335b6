// SPDX-License-Identifier: MIT
#include "turnscale/mapping/recovery_problem.h"

#include <cstddef>

#include "turnscale/mapping/map_scaling.h"

namespace turnscale {
namespace {

constexpr int kNoCamera = -1;

void AddCamera(const Map& map, int keyframe, bool fixed, RecoveryProblem& problem, std::vector<int>& camera_of) {
  camera_of[keyframe] = static_cast<int>(problem.keyframe.size());
  problem.keyframe.push_back(keyframe);
  problem.points_of_camera.push_back(0);
  problem.bundle.camera_from_world.push_back(map.keyframes[keyframe].camera_from_world);
  problem.bundle.camera_is_fixed.push_back(fixed ? 1 : 0);
}

/// How often a landmark was seen up to the end of a range, and how often of that within it.
struct Views {
  int all = 0;
  int within = 0;
};

Views CountViews(const Landmark& landmark, const KeyframeRange& range) {
  Views views;
  for (const LandmarkObservation& seen : landmark.observations) {
    if (seen.keyframe > range.last) continue;
    ++views.all;
    if (seen.keyframe >= range.first) ++views.within;
  }
  return views;
}

}  // namespace

std::vector<KeyframeRange> SplitAtGaps(const Map& map) {
  std::vector<KeyframeRange> ranges;
  const int end = CountKeyframes(map);
  for (int k = 0; k < end; ++k) {
    if (k == 0 || map.keyframes[k].after_gap) ranges.push_back({k, k});
    ranges.back().last = k;
  }
  return ranges;
}

RecoveryProblem MakeRecoveryProblem(const Map& map, const KeyframeRange& range, double pixel_sigma) {
  RecoveryProblem problem;
  problem.bundle.pinhole = map.camera.pinhole;
  std::vector<int> camera_of(map.keyframes.size(), kNoCamera);
  for (int k = range.first; k <= range.last; ++k) AddCamera(map, k, k == range.first, problem, camera_of);
  for (const int index : LandmarksInUse(map)) {
    const Landmark& landmark = map.landmarks[index];
    const Views views = CountViews(landmark, range);
    if (views.within == 0 || views.all < 2) {
      problem.left_out.push_back(index);
      continue;
    }
    const int point = static_cast<int>(problem.landmark.size());
    problem.landmark.push_back(index);
    problem.bundle.points.push_back(landmark.position);
    for (const LandmarkObservation& seen : landmark.observations) {
      if (seen.keyframe > range.last) continue;
      if (camera_of[seen.keyframe] == kNoCamera) AddCamera(map, seen.keyframe, true, problem, camera_of);
      const int camera = camera_of[seen.keyframe];
      problem.bundle.observations.push_back({camera, point, seen.pixel, pixel_sigma});
      ++problem.points_of_camera[camera];
    }
  }
  return problem;
}

void HoldStep(int step, double distance, const KeyframeRange& range, RecoveryProblem& problem) {
  problem.bundle.distances.push_back({step - 1 - range.first, step - range.first, distance});
}

void MeasureStep(int step, double distance, double sigma, const KeyframeRange& range, RecoveryProblem& problem) {
  problem.bundle.measured_distances.push_back({{step - 1 - range.first, step - range.first, distance}, sigma});
}

void WriteBackLandmarks(const RecoveryProblem& problem, Map& map) {
  for (std::size_t i = 0; i < problem.landmark.size(); ++i) {
    map.landmarks[problem.landmark[i]].position = problem.bundle.points[i];
  }
}

}  // namespace turnscale

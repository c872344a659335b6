// SPDX-License-Identifier: MIT
#include "turnscale/mapping/map.h"

#include <algorithm>
#include <utility>

#include <opencv2/core/utility.hpp>

#include "turnscale/geometry/rotation.h"

namespace turnscale {

double TurnBetween(const Map& map, int from, int to) {
  return RotationAngle(map.keyframes[to].camera_from_world.rotation *
                       map.keyframes[from].camera_from_world.rotation.conjugate());
}

std::vector<int> LandmarksSeen(const Map& map, int first, int last) {
  std::vector<char> is_seen(map.landmarks.size(), 0);
  for (int k = first; k <= last; ++k)
    for (const KeyframeObservation& seen : map.keyframes[k].observations) is_seen[seen.landmark] = 1;
  std::vector<int> landmarks;
  for (size_t i = 0; i < is_seen.size(); ++i)
    if (is_seen[i] != 0 && map.landmarks[i].valid) landmarks.push_back(static_cast<int>(i));
  return landmarks;
}

void AddObservation(Map& map, int keyframe, int landmark, const Eigen::Vector2d& pixel) {
  map.keyframes[keyframe].observations.push_back({landmark, pixel});
  map.landmarks[landmark].observations.push_back({keyframe, pixel});
}

void RemoveObservation(Map& map, int keyframe, int landmark) {
  std::erase_if(map.keyframes[keyframe].observations,
                [&](const KeyframeObservation& seen) { return seen.landmark == landmark; });
  std::erase_if(map.landmarks[landmark].observations,
                [&](const LandmarkObservation& seen) { return seen.keyframe == keyframe; });
}

void CopyPixelsToLandmarks(Map& map) {
  std::vector<size_t> done(map.landmarks.size(), 0);
  for (const Keyframe& keyframe : map.keyframes)
    for (const KeyframeObservation& seen : keyframe.observations)
      map.landmarks[seen.landmark].observations[done[seen.landmark]++].pixel = seen.pixel;
}

void CorrectLens(Map& map, double radial_correction) {
  const double before = std::exchange(map.camera.radial_correction, radial_correction);
  cv::parallel_for_(cv::Range(0, CountKeyframes(map)), [&](const cv::Range& range) {
    for (int k = range.start; k < range.end; ++k)
      for (KeyframeObservation& seen : map.keyframes[k].observations)
        seen.pixel = ChangeRadialCorrection(map.camera.pinhole, before, radial_correction, seen.pixel);
  });
  CopyPixelsToLandmarks(map);
}

void RemoveLandmark(Map& map, int landmark) {
  for (const LandmarkObservation& seen : map.landmarks[landmark].observations)
    std::erase_if(map.keyframes[seen.keyframe].observations,
                  [&](const KeyframeObservation& other) { return other.landmark == landmark; });
  map.landmarks[landmark].observations.clear();
  map.landmarks[landmark].valid = false;
}

}  // namespace turnscale

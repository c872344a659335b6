// SPDX-License-Identifier: MIT
#include "turnscale/mapping/map.h"

#include <algorithm>

#include "turnscale/geometry/rotation.h"

namespace turnscale {

double TurnBetween(const Map& map, int from, int to) {
  return RotationAngle(map.keyframes[to].camera_from_world.rotation *
                       map.keyframes[from].camera_from_world.rotation.conjugate());
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

void RemoveLandmark(Map& map, int landmark) {
  for (const LandmarkObservation& seen : map.landmarks[landmark].observations)
    std::erase_if(map.keyframes[seen.keyframe].observations,
                  [&](const KeyframeObservation& other) { return other.landmark == landmark; });
  map.landmarks[landmark].observations.clear();
  map.landmarks[landmark].valid = false;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/mapping/landmarks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/geometry/triangulation.h"

namespace turnscale {
namespace {

constexpr size_t kFewestSightings = 2;

CameraRay RayOf(const Map& map, const LandmarkObservation& seen) {
  return {map.keyframes[seen.keyframe].camera_from_world, map.camera.pinhole.Ray(seen.pixel)};
}

// Depth from the two keyframes that are farthest apart in time: they hold the widest parallax of a forward motion.
std::optional<Eigen::Vector3d> TriangulateOne(const LandmarkOptions& options, const Map& map, int index) {
  const Landmark& landmark = map.landmarks[index];
  const std::array<CameraRay, 2> rays = {RayOf(map, landmark.observations.front()),
                                         RayOf(map, landmark.observations.back())};
  const std::optional<Eigen::Vector3d> x = Triangulate(rays);
  if (!x) return std::nullopt;
  const double angle = ParallaxAngle(rays[0].camera_from_world, rays[1].camera_from_world, *x);
  const double least =
      std::max(options.min_parallax_deg / kDegreesPerRadian, options.min_parallax / map.camera.pinhole.fx);
  if (angle < least) return std::nullopt;
  return x;
}

// That a tenth of the landmarks with a depth are nearer than; 0 if they are too few to tell. The distance of far ones
// is not certain.
double NearDistance(const std::vector<int>& landmarks, const RigidTransform& camera_from_world, const Map& map) {
  constexpr size_t kFewest = 10;
  constexpr double kNearest = 0.1;
  std::vector<double> distances;
  for (const int index : landmarks)
    if (map.landmarks[index].valid) distances.push_back((camera_from_world * map.landmarks[index].position).norm());
  return distances.size() < kFewest ? 0.0 : Quantile(std::move(distances), kNearest);
}

}  // namespace

void LandmarkOptions::Check() const {
  if (!(min_parallax_deg > 0)) throw InputError("min_parallax_deg: has to be positive");
  if (!(min_parallax >= 0)) throw InputError("min_parallax: must not be negative");
  if (!(max_reprojection_error > 0)) throw InputError("max_reprojection_error: has to be positive");
  if (!(min_distance_share >= 0 && min_distance_share < 1))
    throw InputError("min_distance_share: has to be from 0 to below 1");
}

double ReprojectionError(const Pinhole& pinhole, const RigidTransform& camera_from_world, const Eigen::Vector3d& point,
                         const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d x = camera_from_world * point;
  return x.z() > 0 ? (pinhole.Project(x) - pixel).norm() : HUGE_VAL;
}

double ReprojectionError(const Map& map, int landmark, const LandmarkObservation& seen) {
  return ReprojectionError(map.camera.pinhole, map.keyframes[seen.keyframe].camera_from_world,
                           map.landmarks[landmark].position, seen.pixel);
}

void TriangulateLandmarks(const LandmarkOptions& options, const std::vector<int>& landmarks, Map& map) {
  const RigidTransform& latest_from_world = map.keyframes.back().camera_from_world;
  const double least_distance = options.min_distance_share * NearDistance(landmarks, latest_from_world, map);
  for (const int index : landmarks) {
    Landmark& landmark = map.landmarks[index];
    if (landmark.valid || landmark.observations.size() < kFewestSightings) continue;
    const std::optional<Eigen::Vector3d> x = TriangulateOne(options, map, index);
    if (!x || (latest_from_world * *x).norm() < least_distance) continue;
    landmark.position = *x;
    landmark.valid = std::ranges::all_of(landmark.observations, [&](const LandmarkObservation& seen) {
      return ReprojectionError(map, index, seen) <= options.max_reprojection_error;
    });
  }
}

std::vector<int> CullLandmarks(const LandmarkOptions& options, const std::vector<int>& landmarks, int latest_keyframe,
                               Map& map) {
  std::vector<int> lost;
  for (const int index : landmarks) {
    Landmark& landmark = map.landmarks[index];
    if (!landmark.valid) continue;
    bool seen_latest = false;
    bool keeps_latest = false;
    for (size_t i = 0; i < landmark.observations.size();) {
      const LandmarkObservation seen = landmark.observations[i];
      const bool agrees = ReprojectionError(map, index, seen) <= options.max_reprojection_error;
      if (seen.keyframe == latest_keyframe) {
        seen_latest = true;
        keeps_latest = agrees;
      }
      if (agrees)
        ++i;
      else
        RemoveObservation(map, seen.keyframe, index);
    }
    if (landmark.observations.size() < kFewestSightings) {
      RemoveLandmark(map, index);
      lost.push_back(index);
    } else if (seen_latest && !keeps_latest) {
      lost.push_back(index);
    }
  }
  return lost;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/export/geo_path.h"

#include <cmath>

#include "turnscale/base/error.h"
#include "turnscale/geometry/level_frame.h"

namespace turnscale {

std::vector<LevelPlace> LevelPath(const ResultFolder& results, const std::string& name) {
  const Trajectory poses = results.Poses();
  if (poses.empty()) throw InputError(name + ": the run has no path");
  if (!results.metric)
    throw InputError(
        name +
        ": the path is not in metres; run the drive again with --lever-arm or --camera-height, or give the "
        "--report folder of turnscale rescale");
  const Eigen::Quaterniond level_from_world = LevelFromWorld(poses, results.vehicle_from_body);
  const Eigen::Vector3d origin = poses.front().world_from_camera.translation;
  std::vector<LevelPlace> path;
  for (const FrameResult& frame : results.frames) {
    if (!frame.world_from_camera) continue;
    path.push_back({frame.time, level_from_world * (frame.world_from_camera->translation - origin),
                    SpeedAt(results.speeds, frame.time), frame.scale_sigma, frame.frame});
  }
  return path;
}

Eigen::Vector3d EastNorthUp(const Eigen::Vector3d& level, double heading) {
  const double sine = std::sin(heading);
  const double cosine = std::cos(heading);
  return {cosine * level.x() + sine * level.y(), cosine * level.y() - sine * level.x(), level.z()};
}

std::vector<GeoPlace> PlaceOnEarth(const std::vector<LevelPlace>& path, const Placement& placement, double interval) {
  const GeoFrame frame(placement.origin);
  std::vector<GeoPlace> places;
  constexpr double kSlack = 1e-6;  // seconds
  for (size_t i = 0; i < path.size(); ++i) {
    const LevelPlace& place = path[i];
    if (!places.empty() && i + 1 < path.size() && place.time < places.back().time + interval - kSlack) continue;
    const Eigen::Vector3d position = EastNorthUp(placement.tilt * place.position, placement.heading);
    places.push_back({place.time, frame.FromLocal(position), place.speed, place.sigma});
  }
  return places;
}

}  // namespace turnscale

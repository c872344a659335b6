// SPDX-License-Identifier: MIT
#include "turnscale/odometry/refined_drive.h"

#include <cstddef>
#include <utility>

#include "turnscale/mapping/map_scaling.h"
#include "turnscale/odometry/drive_steps.h"

namespace turnscale {

std::vector<FrameResult> RefinedFramesOf(const FrameHistory& history, const Map& map, const MountCalibration& mount,
                                         const RefinedScale& refined) {
  std::vector<FrameResult> frames = history.Refined(map, refined.path);
  const std::vector<int> keyframes = history.Keyframes();
  int keyframe = -1;
  for (std::size_t i = frames.size(); i-- > 0;) {
    // From the end, since frames before the first keyframe go with it.
    FrameResult& frame = frames[i];
    if (keyframes[i] >= 0) keyframe = keyframes[i];
    if (keyframe < 0) continue;
    frame.vehicle_from_camera = mount.At(keyframe, frame.frame);
    frame.turning = refined.keyframes[keyframe].turning;
    frame.scale_sigma = refined.keyframes[keyframe].sigma;
    frame.scale_state = refined.keyframes[keyframe].state;
    if (!frame.keyframe || keyframe == 0 || map.keyframes[keyframe].after_gap) continue;
    const TurningMotion motion = StepMotion(map, keyframe - 1, mount);
    frame.psi = motion.psi;
    frame.theta = motion.theta;
  }
  return frames;
}

MapPoints RefinedPointsOf(const MapArchive& archive, const Map& map, const MetricPath& path) {
  MapPoints points;
  points.cameras = path.centres;
  points.landmarks.reserve(archive.landmarks());
  std::vector<char> done(archive.landmarks(), 0);
  const auto add = [&](const Map& part, int first_keyframe) {
    const std::vector<Eigen::Vector3d> centres = KeyframeCentres(part);
    for (const Landmark& landmark : part.landmarks) {
      if (!landmark.valid || landmark.observations.empty()) continue;
      if (landmark.archived_as >= 0 && std::exchange(done[landmark.archived_as], 1) != 0) continue;
      const int keyframe = first_keyframe + ClosestObserver(landmark, centres);
      points.landmarks.push_back(path.InMetres(map, keyframe, landmark.position).cast<float>());
    }
  };
  // From the end: of a landmark's places in several blocks the latest counts.
  add(map, 0);
  std::vector<int> ends = archive.BlockEnds();
  for (; !ends.empty(); ends.pop_back()) {
    const int first = ends.size() > 1 ? ends[ends.size() - 2] : 0;
    add(archive.Load(first, ends.back(), map).map, first);
  }
  return points;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/mapping/rolling_shutter.h"

#include <algorithm>
#include <optional>

#include <opencv2/core/utility.hpp>

#include "turnscale/bundle/reprojection.h"

namespace turnscale {

Eigen::Vector2d RowMotion(const Map& map, int keyframe, const Eigen::Vector3d& position, const Eigen::Vector2d& pixel) {
  const int last = CountKeyframes(map) - 1;
  const int next = std::min(keyframe + 1, last);
  const Keyframe& before = map.keyframes[map.keyframes[keyframe].after_gap ? keyframe : std::max(keyframe - 1, 0)];
  const Keyframe& after = map.keyframes[map.keyframes[next].after_gap ? keyframe : next];
  const Eigen::Vector3d x = map.keyframes[keyframe].camera_from_world * position;
  const CameraModel& camera = map.camera;
  if (camera.height == 0 || !(after.time > before.time) || !IsInFront(x)) return Eigen::Vector2d::Zero();
  const Eigen::Vector3d speed =
      (after.camera_from_world * position - before.camera_from_world * position) / (after.time - before.time);
  const Eigen::Vector2d along(camera.read_direction.x, camera.read_direction.y);
  const Eigen::Vector2d size(camera.width, camera.height);
  const Eigen::Vector2d middle = 0.5 * (size - Eigen::Vector2d::Ones());
  const double share = along.dot(pixel - middle) / along.cwiseAbs().dot(size);
  return share * (ProjectionJacobian(camera.pinhole, x) * speed);
}

void CorrectRows(Map& map) {
  cv::parallel_for_(cv::Range(0, CountKeyframes(map)), [&](const cv::Range& range) {
    for (int k = range.start; k < range.end; ++k)
      for (KeyframeObservation& seen : map.keyframes[k].observations) {
        const Landmark& landmark = map.landmarks[seen.landmark];
        if (!landmark.valid) continue;
        const std::optional<Eigen::Vector2d> distorted = map.camera.Project(map.camera.pinhole.Ray(seen.pixel));
        if (distorted) seen.pixel -= map.camera.readout * RowMotion(map, k, landmark.position, *distorted);
      }
  });
  CopyPixelsToLandmarks(map);
}

}  // namespace turnscale

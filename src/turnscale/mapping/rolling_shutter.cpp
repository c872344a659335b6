// SPDX-License-Identifier: MIT
#include "turnscale/mapping/rolling_shutter.h"

#include <cmath>
#include <optional>

#include <opencv2/core/utility.hpp>

#include "turnscale/bundle/reprojection.h"

namespace turnscale {
namespace {

// Of a point in the camera's frame at a keyframe, per second.
Eigen::Vector3d SpeedInCamera(const Map& map, int keyframe, const Eigen::Vector3d& position) {
  const Keyframe& now = map.keyframes[keyframe];
  const Eigen::Vector3d x = now.camera_from_world * position;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weights = 0;
  // The slope of a parabola through three keyframes: that over the shorter interval counts more.
  const auto add = [&](const Keyframe& other) {
    const double seconds = other.time - now.time;
    if (seconds == 0) return;
    const double weight = 1 / std::abs(seconds);
    sum += weight * (other.camera_from_world * position - x) / seconds;
    weights += weight;
  };
  if (keyframe > 0 && !now.after_gap) add(map.keyframes[keyframe - 1]);
  if (keyframe + 1 < CountKeyframes(map) && !map.keyframes[keyframe + 1].after_gap) add(map.keyframes[keyframe + 1]);
  return weights > 0 ? Eigen::Vector3d(sum / weights) : sum;
}

// For how much of the readout the row of a pixel waits after the middle one; below 0 before it.
double ShareOfReadout(const CameraModel& camera, const ReadDirection& direction, const Eigen::Vector2d& pixel) {
  if (camera.width == 0 || camera.height == 0) return 0;
  const Eigen::Vector2d along(direction.x, direction.y);
  const Eigen::Vector2d size(camera.width, camera.height);
  const Eigen::Vector2d middle = 0.5 * (size - Eigen::Vector2d::Ones());
  return along.dot(pixel - middle) / along.cwiseAbs().dot(size);
}

}  // namespace

Eigen::Vector2d RowMotion(const Map& map, int keyframe, const Eigen::Vector3d& position, const Eigen::Vector2d& pixel,
                          const ReadDirection& direction) {
  const Eigen::Vector3d x = map.keyframes[keyframe].camera_from_world * position;
  if (!IsInFront(x)) return Eigen::Vector2d::Zero();
  return ShareOfReadout(map.camera, direction, pixel) *
         (ProjectionJacobian(map.camera.pinhole, x) * SpeedInCamera(map, keyframe, position));
}

void CorrectRows(Map& map) {
  const CameraModel& camera = map.camera;
  if (camera.readout == 0) return;
  cv::parallel_for_(cv::Range(0, CountKeyframes(map)), [&](const cv::Range& range) {
    for (int k = range.start; k < range.end; ++k)
      for (KeyframeObservation& seen : map.keyframes[k].observations) {
        const Landmark& landmark = map.landmarks[seen.landmark];
        const std::optional<Eigen::Vector2d> distorted = camera.Project(camera.pinhole.Ray(seen.pixel));
        if (!landmark.valid || !distorted) continue;
        const double waited = camera.readout * ShareOfReadout(camera, camera.read_direction, *distorted);
        const Eigen::Vector3d x = map.keyframes[k].camera_from_world * landmark.position;
        const Eigen::Vector3d x_then = x + waited * SpeedInCamera(map, k, landmark.position);
        if (IsInFront(x) && IsInFront(x_then)) seen.pixel -= camera.pinhole.Project(x_then) - camera.pinhole.Project(x);
      }
  });
  CopyPixelsToLandmarks(map);
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/odometry/map_start.h"

#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include "turnscale/base/quantiles.h"
#include "turnscale/mapping/pose_estimation.h"
#include "turnscale/odometry/image_tracking.h"
#include "turnscale/odometry/repeated_image.h"

namespace turnscale {
namespace {

constexpr double kNearQuarter = 0.25;

// What a frame that waited for the map sees of its landmarks.
std::vector<PointSighting> SightingsIn(const Map& map, const WaitingFrame& frame, int first_landmark) {
  std::vector<PointSighting> sightings;
  for (std::size_t i = 0; i < frame.features.size(); ++i) {
    const Landmark& landmark = map.landmarks[first_landmark + frame.features[i]];
    if (landmark.valid) sightings.push_back({landmark.position, frame.pixels[i]});
  }
  return sightings;
}

// Whether the image of `waiting` is that of `before` once more; `interval`: since the image before, seconds.
bool Repeats(const RepeatOptions& options, const MotionModel& motion_model, const Map& map, const WaitingFrame& before,
             const WaitingFrame& waiting, double interval, int first_landmark) {
  // Whether all pixels are the same is not known.
  if (waiting.time - before.time > options.max_seconds || interval > options.max_interval) return false;
  const RigidTransform predicted = motion_model.Predict(waiting.time);
  std::vector<LandmarkMotion> motion;
  std::size_t i = 0;
  for (std::size_t k = 0; k < waiting.features.size(); ++k) {
    // The features of `waiting` are among those of `before`, in the same order.
    while (before.features[i] != waiting.features[k]) ++i;
    const Landmark& landmark = map.landmarks[first_landmark + waiting.features[k]];
    const Eigen::Vector3d x = predicted * landmark.position;
    if (landmark.valid && x.z() > 0) motion.push_back({before.pixels[i], map.pinhole.Project(x), waiting.pixels[k]});
  }
  return IsRepeated(options, MedianMotion(motion));
}

}  // namespace

UnitGuess UnitAfterGap(const TrackingOptions& options, const Map& map, const MotionModel& motion,
                       const InitialMap& start) {
  // A map that has just started knows the depth of near points only. What has none is farther than the nearest quarter.
  const Keyframe& last = map.keyframes.back();
  std::vector<double> depths;
  for (const KeyframeObservation& seen : last.observations) {
    const Landmark& landmark = map.landmarks[seen.landmark];
    depths.push_back(landmark.valid ? (last.camera_from_world * landmark.position).z() : HUGE_VAL);
  }
  std::vector<double> new_depths;
  for (const int feature : start.frames.back().features)
    new_depths.push_back(start.has_point[feature] != 0 ? (start.second_from_first * start.points[feature]).z()
                                                       : HUGE_VAL);
  const double depth = depths.empty() ? HUGE_VAL : Quantile(std::move(depths), kNearQuarter);
  const double new_depth = Quantile(std::move(new_depths), kNearQuarter);
  UnitGuess from_depth;
  if (std::isfinite(depth) && std::isfinite(new_depth)) from_depth = {depth / new_depth, options.depth_sigma};
  const double first = start.frames.front().time;
  const double second = start.frames.back().time;
  UnitGuess from_speed;
  for (const PastSpeed& past : motion.PastSpeeds()) {
    const double sigma = motion.SpeedSigma(past, 0.5 * (first + second), std::isfinite(depth) ? depth : 0.0);
    if (!(sigma < from_speed.sigma)) continue;
    from_speed = {past.speed * (second - first) / start.second_from_first.translation.norm(), sigma};
  }
  return Combine(from_depth, from_speed);
}

AddedStart AddStart(const InitialMap& start, const StartPlace& place, Map& map) {
  const WaitingFrame& first = start.frames.front();
  const WaitingFrame& second = start.frames.back();
  const double unit = place.unit.unit;
  RigidTransform second_from_first = start.second_from_first;
  second_from_first.translation *= unit;

  AddedStart added{static_cast<int>(map.keyframes.size()), static_cast<int>(map.landmarks.size()), {}};
  map.keyframes.push_back({first.frame, first.time, place.first_from_world, {}, place.after_gap, place.unit.sigma});
  map.keyframes.push_back({second.frame, second.time, second_from_first * place.first_from_world, {}, false});
  const RigidTransform world_from_first = place.first_from_world.inverse();
  for (std::size_t i = 0; i < first.features.size(); ++i) {
    map.landmarks.push_back({world_from_first * (unit * start.points[i]), start.has_point[i] != 0, {}});
    AddObservation(map, added.keyframe, added.first_landmark + static_cast<int>(i), first.pixels[i]);
  }
  const auto reference = std::make_shared<const cv::Mat>(start.first_image);
  for (std::size_t i = 0; i < second.features.size(); ++i) {
    const int landmark = added.first_landmark + second.features[i];
    AddObservation(map, added.keyframe + 1, landmark, second.pixels[i]);
    added.tracks.push_back({landmark, start.second_pixels[i], second.pixels[i], second.pixels[i], reference,
                            start.first_pixels[second.features[i]], added.keyframe, added.keyframe + 1});
  }
  return added;
}

std::vector<LocatedFrame> LocateWaitingFrames(const OdometryOptions& options, const CameraModel& camera,
                                              const InitialMap& start, const Map& map, int keyframe, int first_landmark,
                                              MotionModel& motion) {
  const WaitingFrame& second = start.frames.back();
  const RigidTransform& first_pose = map.keyframes[keyframe].camera_from_world;
  const RigidTransform& second_pose = map.keyframes[keyframe + 1].camera_from_world;
  std::vector<LocatedFrame> located;
  const WaitingFrame* moved = nullptr;  // the latest that is no repeat
  double last_time = start.frames.front().time;
  for (const WaitingFrame& waiting : start.frames) {
    const bool is_second = &waiting == &second;
    FrameResult result;
    result.frame = waiting.frame;
    result.time = waiting.time;
    result.state = TrackingState::kRepeated;
    result.tracked = static_cast<int>(waiting.features.size());
    const double interval = waiting.time - std::exchange(last_time, waiting.time);
    if (moved && Repeats(options.repeats, motion, map, *moved, waiting, interval, first_landmark)) {
      if (!is_second) located.push_back({result, motion.Predict(waiting.time)});
      continue;
    }
    const PoseEstimate estimate = EstimatePose(options.pose, camera.pinhole, SightingsIn(map, waiting, first_landmark),
                                               moved ? motion.last() : first_pose);
    const RigidTransform pose = is_second ? second_pose : estimate.camera_from_world;
    result.state = IsBelievable(options.tracking, estimate) ? TrackingState::kTracked : TrackingState::kBridged;
    result.inliers = estimate.inliers;
    result.keyframe = !moved;
    if (!is_second) located.push_back({result, result.keyframe ? first_pose : pose});
    if (!moved) {
      motion.Restart(waiting.time, pose);
    } else if (is_second || result.state == TrackingState::kTracked) {
      motion.Update(waiting.time, pose);
    } else {
      continue;
    }
    moved = &waiting;
  }
  return located;
}

}  // namespace turnscale

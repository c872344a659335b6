// SPDX-License-Identifier: MIT
#include "turnscale/odometry/map_start.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/geometry/rotation.h"
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
    if (landmark.valid) sightings.push_back({landmark.position, frame.undistorted[i]});
  }
  return sightings;
}

// Whether the image of `waiting` is that of `before` once more; `interval`: since the image before, seconds.
bool Repeats(const RepeatOptions& options, const MotionModel& motion_model, const Map& map, const WaitingFrame& before,
             const WaitingFrame& waiting, double interval, int first_landmark) {
  const RigidTransform predicted = motion_model.Predict(waiting.time);
  std::vector<LandmarkMotion> motion;
  std::size_t i = 0;
  for (std::size_t k = 0; k < waiting.features.size(); ++k) {
    // The features of `waiting` are among those of `before`, in the same order.
    while (before.features[i] != waiting.features[k]) ++i;
    const Landmark& landmark = map.landmarks[first_landmark + waiting.features[k]];
    const Eigen::Vector3d x = predicted * landmark.position;
    if (landmark.valid && x.z() > 0)
      motion.push_back({before.undistorted[i], map.camera.pinhole.Project(x), waiting.undistorted[k]});
  }
  return IsRepeated(options, {.since_measured = waiting.time - before.time, .interval = interval},
                    MedianMotion(motion));
}

}  // namespace

UnitGuess UnitAfterGap(const TrackingOptions& options, const Map& map, const MotionModel& motion,
                       const InitialMap& start) {
  // A map that has just started knows the depth of near points only. What has none is farther than the nearest quarter.
  const Keyframe& last = map.keyframes.back();
  std::vector<double> depths;
  std::vector<double> known_depths;
  for (const KeyframeObservation& seen : last.observations) {
    const Landmark& landmark = map.landmarks[seen.landmark];
    if (landmark.valid) known_depths.push_back((last.camera_from_world * landmark.position).z());
    depths.push_back(landmark.valid ? known_depths.back() : HUGE_VAL);
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
  // With few depths, nothing tells whether the speed is more than the noise of a car that stands.
  constexpr std::size_t kFewestDepths = 10;
  const bool has_depths = known_depths.size() >= kFewestDepths;
  const double known_depth = has_depths ? Quantile(std::move(known_depths), kNearQuarter) : HUGE_VAL;
  const double scene_depth = std::min(depth, known_depth);
  for (const PastSpeed& past : motion.PastSpeeds()) {
    const double sigma = motion.SpeedSigma(past, 0.5 * (first + second), scene_depth);
    if (!(sigma < from_speed.sigma)) continue;
    from_speed = {past.speed * (second - first) / start.second_from_first.translation.norm(), sigma};
  }
  return Combine(from_depth, from_speed);
}

bool BeginsAtStandstill(const StaticRegionOptions& options, const InitialMap& start) {
  // Of a car that drives, even slowly, and behind a large dashboard.
  constexpr double kMoment = 0.2;  // seconds
  constexpr double kMostThatMoves = 0.1;
  const WaitingFrame& first = start.frames.front();
  // The second view has moved, or there would be no start.
  for (std::size_t i = 1; i + 1 < start.frames.size(); ++i) {
    const WaitingFrame& frame = start.frames[i];
    if (frame.time - first.time < kMoment) continue;
    double moved = 0;
    for (std::size_t k = 0; k < frame.features.size(); ++k)
      moved += (frame.undistorted[k] - first.undistorted[frame.features[k]]).norm() > options.max_motion ? 1 : 0;
    return moved < kMostThatMoves * static_cast<double>(frame.features.size());
  }
  return false;
}

PredictedStart PredictStart(const MotionModel& motion, const InitialMap& start,
                            const std::optional<GapRotation>& measured, std::optional<double> metres_per_unit) {
  const double time = start.frames.front().time;
  const auto turn = [&](const Eigen::Quaterniond& rotation) {
    return motion.vertical().dot(VectorFromRotation(rotation));
  };
  const double rate = turn(start.second_from_first.rotation) / (start.frames.back().time - time);
  if (!measured)
    return {motion.PredictAcross(time, rate, std::nullopt), motion.TurnSigmaAcross(time, rate, metres_per_unit)};
  const RigidTransform predicted = motion.PredictAcross(time, rate, turn(measured->after_from_before));
  const Eigen::Quaterniond rotation = measured->after_from_before * motion.last().rotation;
  return {{rotation, -(rotation * predicted.inverse().translation)}, measured->sigma, true};
}

AddedStart AddStart(const InitialMap& start, const StartPlace& place, Map& map) {
  Ensure(start.radial_correction == map.camera.radial_correction, "a start has the radial correction of the map");
  const WaitingFrame& first = start.frames.front();
  const WaitingFrame& second = start.frames.back();
  const double unit = place.unit.unit;
  RigidTransform second_from_first = start.second_from_first;
  second_from_first.translation *= unit;

  AddedStart added{
      .keyframe = CountKeyframes(map), .first_landmark = static_cast<int>(map.landmarks.size()), .tracks = {}};
  map.keyframes.push_back({.frame = first.frame,
                           .time = first.time,
                           .camera_from_world = place.predicted.first_from_world,
                           .observations = {},
                           .after_gap = place.after_gap,
                           .gap_sigma = place.unit.sigma,
                           .gap_turn_sigma = place.predicted.turn_sigma,
                           .gap_turn_is_measured = place.predicted.turn_is_measured,
                           .contrast_left = place.contrast_left});
  map.keyframes.push_back({.frame = second.frame,
                           .time = second.time,
                           .camera_from_world = second_from_first * place.predicted.first_from_world,
                           .observations = {}});
  const RigidTransform world_from_first = place.predicted.first_from_world.inverse();
  for (std::size_t i = 0; i < first.features.size(); ++i) {
    map.landmarks.push_back({world_from_first * (unit * start.points[i]), start.has_point[i] != 0, {}});
    AddObservation(map, added.keyframe, added.first_landmark + static_cast<int>(i), first.undistorted[i]);
  }
  const auto reference = std::make_shared<const cv::Mat>(start.first_image);
  for (std::size_t i = 0; i < second.features.size(); ++i) {
    const int landmark = added.first_landmark + second.features[i];
    AddObservation(map, added.keyframe + 1, landmark, second.undistorted[i]);
    added.tracks.push_back({.landmark = landmark,
                            .pixel = start.second_pixels[i],
                            .undistorted = second.undistorted[i],
                            .in_keyframe = second.undistorted[i],
                            .reference_image = reference,
                            .reference_pixel = start.first_pixels[second.features[i]],
                            .reference_keyframe = added.keyframe,
                            .last_keyframe = added.keyframe + 1});
  }
  return added;
}

std::vector<LocatedFrame> LocateWaitingFrames(const OdometryOptions& options, const InitialMap& start,
                                              const AddedStart& added, const Map& map, MotionModel& motion) {
  Ensure(start.frames.size() >= 2, "a map starts from two views");
  const auto estimate = [&](const WaitingFrame& frame, const RigidTransform& initial) {
    return EstimatePose(options.pose, map.camera.pinhole, SightingsIn(map, frame, added.first_landmark), initial);
  };
  const auto result_of = [](const WaitingFrame& frame, TrackingState state, int inliers) {
    FrameResult result;
    result.frame = frame.frame;
    result.time = frame.time;
    result.state = state;
    result.tracked = static_cast<int>(frame.features.size());
    result.inliers = inliers;
    return result;
  };
  const auto state_of = [&](const PoseEstimate& pose) {
    return IsBelievable(options.tracking, pose) ? TrackingState::kTracked : TrackingState::kBridged;
  };
  const WaitingFrame* moved = &start.frames.front();  // the latest one whose pose was measured
  const auto repeats = [&](std::size_t i) {
    const double interval = start.frames[i].time - start.frames[i - 1].time;
    return Repeats(options.repeats, motion, map, *moved, start.frames[i], interval, added.first_landmark);
  };

  const RigidTransform& first_pose = map.keyframes[added.keyframe].camera_from_world;
  const PoseEstimate first = estimate(*moved, first_pose);
  std::vector<LocatedFrame> located{{result_of(*moved, state_of(first), first.inliers), first_pose}};
  located.back().result.keyframe = true;
  motion.Restart(moved->time, first.camera_from_world);
  const std::size_t second = start.frames.size() - 1;
  for (std::size_t i = 1; i < second; ++i) {
    const WaitingFrame& frame = start.frames[i];
    if (repeats(i)) {
      located.push_back({result_of(frame, TrackingState::kRepeated, 0), motion.Predict(frame.time)});
      continue;
    }
    const PoseEstimate pose = estimate(frame, motion.last());
    const TrackingState state = state_of(pose);
    located.push_back({result_of(frame, state, pose.inliers), pose.camera_from_world});
    // A pose that is not believable is no motion.
    if (state != TrackingState::kTracked) continue;
    motion.Update(frame.time, pose.camera_from_world);
    moved = &frame;
  }
  if (!repeats(second)) motion.Update(start.frames[second].time, map.keyframes[added.keyframe + 1].camera_from_world);
  return located;
}

}  // namespace turnscale

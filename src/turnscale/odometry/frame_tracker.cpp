// SPDX-License-Identifier: MIT
#include "turnscale/odometry/frame_tracker.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <unordered_set>
#include <utility>

#include "turnscale/base/quantiles.h"
#include "turnscale/features/corners.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/image_tracking.h"

namespace turnscale {
namespace {

// Whether a landmark without a depth, now at `undistorted`, is none of the scene: it has always been there, although
// the camera's motion moves whatever is there.
bool StandsStill(const StaticRegionOptions& options, const Map& map, const Landmark& landmark,
                 const Eigen::Vector2d& undistorted, const RigidTransform& camera_from_world) {
  return HasStayed(landmark, undistorted, options.max_motion) &&
         std::ranges::any_of(landmark.observations, [&](const LandmarkObservation& seen) {
           const RigidTransform& then_from_world = map.keyframes[seen.keyframe].camera_from_world;
           return LeastSceneMotion(map.camera.pinhole, camera_from_world * then_from_world.inverse(), seen.pixel) >=
                  options.min_expected_motion;
         });
}

}  // namespace

void FrameTracker::Start(const FlowImage& image, std::vector<FeatureTrack> tracks, int landmarks) {
  last_image_ = image;
  tracks_ = std::move(tracks);
  lost_tracks_.clear();
  last_image_time_.reset();
  last_interval_.reset();
  sampled_.reset();
  stands_since_.reset();
  has_stood_ = false;
  landmarks_in_keyframe_ = landmarks;
  features_in_keyframe_ = static_cast<int>(tracks_.size());
}

bool FrameTracker::ShowsSamePixels(const FlowImage& image) const { return HaveSamePixels(latest_gray(), image.gray); }

bool FrameTracker::IsRepeat(const Map& map, const FlowImage& image, const RigidTransform& predicted,
                            const ImageTiming& timing) const {
  return IsRepeated(options_.repeats, options_.alignment, map,
                    {.first = latest_gray(),
                     .tracks = sampled_ ? sampled_->tracks : tracks_,
                     .second = image.gray,
                     .predicted_from_world = predicted,
                     .timing = timing});
}

TrackedFrame FrameTracker::Track(const Map& map, const cv::Mat& mask, FlowImage& image, const MotionModel& motion,
                                 const RigidTransform& predicted, double time) {
  const TrackingOptions& limits = options_.tracking;
  const RigidTransform last_from_world = sampled_ ? sampled_->last_from_world : motion.last();
  const ImageStep step{.last_image = last_image_,
                       .last_from_world = last_from_world,
                       .last_time = last_image_time_.value_or(motion.last_measured_time()),
                       .tracks = tracks_,
                       .lost_tracks = lost_tracks_,
                       .motion = motion,
                       .has_stood = HasStood(),
                       .image = image,
                       .time = time};
  std::optional<TrackedPose> sample;
  if (last_image_time_ && time - *last_image_time_ < limits.sampled_interval)
    sample = TrackSample(options_, map, mask, step, predicted);
  if (!sample && image.pyramid.empty()) BuildPyramid(options_.flow, image);
  TrackedPose tracked = sample ? *std::move(sample) : TrackImage(options_, map, mask, step, predicted);
  TrackedFrame frame{.tracked = static_cast<int>(tracked.tracks.found.size()),
                     .inliers = tracked.estimate.inliers,
                     .is_sampled = tracked.is_sampled};
  if (!IsBelievable(limits, tracked.estimate)) return frame;
  frame.camera_from_world = tracked.estimate.camera_from_world;
  if (tracked.is_sampled) {
    sampled_ = {image.gray, std::move(tracked.tracks.found), last_from_world};
    return frame;
  }
  sampled_.reset();
  tracks_ = std::move(tracked.tracks.found);
  if (FollowsGap(time)) {
    DropWithoutDepth(map);
  } else if (last_image_time_) {
    last_interval_ = time - *last_image_time_;
  }
  lost_tracks_ = std::move(tracked.tracks.lost);
  last_image_ = image;
  last_image_time_ = time;
  NoticeStanding(map, tracked.estimate.inliers, time);
  return frame;
}

bool FrameTracker::FollowsGap(double time) const {
  // The next image of a video at a low rate follows no gap.
  constexpr double kMuchLonger = 3;
  if (!last_image_time_ || !last_interval_) return false;
  const double interval = time - *last_image_time_;
  return interval > options_.tracking.max_lost_seconds && interval > kMuchLonger * *last_interval_;
}

void FrameTracker::DropWithoutDepth(const Map& map) {
  std::erase_if(tracks_, [&](const FeatureTrack& track) { return !map.landmarks[track.landmark].valid; });
}

std::vector<ObservedMotion> FrameTracker::DropStatic(const Map& map, const RigidTransform& camera_from_world) {
  const StaticRegionOptions& options = options_.static_regions;
  std::vector<ObservedMotion> motion;
  std::erase_if(tracks_, [&](const FeatureTrack& track) {
    const Landmark& landmark = map.landmarks[track.landmark];
    const bool stands_still =
        !landmark.valid && StandsStill(options, map, landmark, track.undistorted, camera_from_world);
    const bool has_moved =
        track.in_keyframe && (track.undistorted - *track.in_keyframe).norm() > 3 * options.max_motion;
    if (stands_still || has_moved) motion.push_back({track.pixel, stands_still});
    return stands_still;
  });
  return motion;
}

void FrameTracker::NoticeStanding(const Map& map, int inliers, double time) {
  // A high quantile, as landmarks straight ahead of a moving car hardly move in the image.
  constexpr double kMost = 0.75;
  constexpr size_t kFewest = 10;
  // So many times the least motion is more than the errors of the few landmarks that are left in sight.
  constexpr double kClearly = 5;
  constexpr double kLeastSeconds = 1;
  const KeyframeOptions& limits = options_.keyframes;
  std::vector<double> motion;
  for (const FeatureTrack& track : tracks_)
    if (track.in_keyframe && map.landmarks[track.landmark].valid)
      motion.push_back((track.undistorted - *track.in_keyframe).norm());
  const double most = motion.size() < kFewest ? HUGE_VAL : Quantile(std::move(motion), kMost);
  const bool sees_enough = inliers >= limits.min_tracked_share * landmarks_in_keyframe_;
  if (most >= kClearly * limits.min_motion || (sees_enough && most >= limits.min_motion))
    stands_since_.reset();
  else if (sees_enough && !stands_since_)
    stands_since_ = time;
  has_stood_ = stands_since_ && time - *stands_since_ >= kLeastSeconds;
}

bool FrameTracker::NeedsKeyframe(const Map& map, const TrackedFrame& frame) const {
  if (HasStood() || frame.is_sampled) return false;
  const KeyframeOptions& limits = options_.keyframes;
  if (frame.inliers < limits.min_tracked_share * landmarks_in_keyframe_) return true;
  const Eigen::Quaterniond turn =
      frame.camera_from_world->rotation * map.keyframes.back().camera_from_world.rotation.conjugate();
  if (RotationAngle(turn) * kDegreesPerRadian > limits.min_rotation_deg) return true;
  std::vector<double> parallax;
  for (const FeatureTrack& track : tracks_) {
    if (!track.in_keyframe) continue;
    const Eigen::Vector3d rotated = turn * map.camera.pinhole.Ray(*track.in_keyframe);
    const Eigen::Vector3d seen = map.camera.pinhole.Ray(track.undistorted);
    parallax.push_back(std::atan2(rotated.cross(seen).norm(), rotated.dot(seen)));
  }
  if (parallax.empty() || static_cast<double>(parallax.size()) < limits.min_followed_share * features_in_keyframe_)
    return true;
  return Median(std::move(parallax)) * kDegreesPerRadian > limits.min_parallax_deg;
}

void FrameTracker::Replenish(const FlowImage& image, const cv::Mat& mask, const std::vector<cv::KeyPoint>& candidates,
                             Map& map) {
  landmarks_in_keyframe_ = static_cast<int>(
      std::ranges::count_if(tracks_, [&](const FeatureTrack& track) { return map.landmarks[track.landmark].valid; }));
  for (FeatureTrack& track : tracks_) {
    track.in_keyframe = track.undistorted;
    track.last_keyframe = CountKeyframes(map) - 1;
  }
  for (FeatureTrack& track : lost_tracks_) track.in_keyframe.reset();
  const auto reference = std::make_shared<const cv::Mat>(image.gray);
  RenewReferences(map, reference);
  DetectNewFeatures(reference, mask, candidates, map);
  features_in_keyframe_ = static_cast<int>(tracks_.size());
}

void FrameTracker::RenewReferences(const Map& map, const std::shared_ptr<const cv::Mat>& image) {
  const int keyframe = CountKeyframes(map) - 1;
  const double limit = options_.keyframes.max_growth * options_.keyframes.max_growth;
  const auto has_grown = [&](const FeatureTrack& track) {
    if (!map.landmarks[track.landmark].valid) return false;
    const std::optional<Eigen::Matrix2d> current_from_reference =
        CurrentFromReference(map, track, map.keyframes[keyframe].camera_from_world);
    return current_from_reference && current_from_reference->determinant() >= limit;
  };
  for (FeatureTrack& track : tracks_) {
    const bool is_old = keyframe - track.reference_keyframe >= options_.keyframes.max_reference_age;
    if (!is_old && !has_grown(track)) continue;
    track.reference_image = image;
    track.reference_pixel = track.pixel;
    track.reference_keyframe = keyframe;
  }
}

void FrameTracker::DetectNewFeatures(const std::shared_ptr<const cv::Mat>& image, const cv::Mat& mask,
                                     const std::vector<cv::KeyPoint>& candidates, Map& map) {
  const int keyframe = CountKeyframes(map) - 1;
  for (const cv::Point2f& corner : DetectCorners(options_.corners, *image, candidates, PixelsOf(tracks_), mask)) {
    const std::optional<Eigen::Vector2d> undistorted = map.camera.Undistort({corner.x, corner.y});
    if (!undistorted) continue;
    const int landmark = static_cast<int>(map.landmarks.size());
    map.landmarks.push_back({});
    AddObservation(map, keyframe, landmark, *undistorted);
    tracks_.push_back({.landmark = landmark,
                       .pixel = corner,
                       .undistorted = *undistorted,
                       .in_keyframe = *undistorted,
                       .reference_image = image,
                       .reference_pixel = corner,
                       .reference_keyframe = keyframe,
                       .last_keyframe = keyframe});
  }
}

std::vector<std::vector<FeatureTrack>*> FrameTracker::AllTracks() {
  std::vector<std::vector<FeatureTrack>*> all = {&tracks_, &lost_tracks_};
  if (sampled_) all.push_back(&sampled_->tracks);
  return all;
}

void FrameTracker::Drop(const std::vector<int>& landmarks) {
  const std::unordered_set<int> ended(landmarks.begin(), landmarks.end());
  for (std::vector<FeatureTrack>* tracks : AllTracks())
    std::erase_if(*tracks, [&](const FeatureTrack& track) { return ended.contains(track.landmark); });
}

void FrameTracker::Reindex(const std::vector<int>& new_index) {
  for (std::vector<FeatureTrack>* tracks : AllTracks()) {
    for (FeatureTrack& track : *tracks) track.landmark = new_index[track.landmark];
    std::erase_if(*tracks, [](const FeatureTrack& track) { return track.landmark < 0; });
  }
}

void FrameTracker::Rescale(double factor) {
  for (std::vector<FeatureTrack>* tracks : AllTracks())
    for (FeatureTrack& track : *tracks) {
      track.parallax_base *= factor;
      if (track.parallax) *track.parallax /= factor;
    }
}

void FrameTracker::Correct(const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& corrected) {
  for (std::vector<FeatureTrack>* tracks : AllTracks())
    for (FeatureTrack& track : *tracks) {
      track.undistorted = corrected(track.undistorted);
      if (track.in_keyframe) track.in_keyframe = corrected(*track.in_keyframe);
    }
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/odometry/frame_tracker.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include <opencv2/core/utility.hpp>

#include "turnscale/base/quantiles.h"
#include "turnscale/features/corners.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/pose_search.h"
#include "turnscale/odometry/repeated_image.h"

namespace turnscale {
namespace {

// Tracks that contradict the pose count as lost: mistracked, or on moving objects.
PoseEstimate EstimateFramePose(const PoseEstimationOptions& options, const Map& map, const RigidTransform& predicted,
                               FollowedTracks& tracks) {
  std::vector<PointSighting> sightings;
  for (const FeatureTrack& track : tracks.found)
    if (map.landmarks[track.landmark].valid)
      sightings.push_back({map.landmarks[track.landmark].position, track.undistorted});
  PoseEstimate estimate = EstimatePose(options, map.pinhole, sightings, predicted);
  size_t sighting = 0;
  std::erase_if(tracks.found, [&](const FeatureTrack& track) {
    const bool wrong = map.landmarks[track.landmark].valid && estimate.inlier[sighting++] == 0;
    if (wrong) tracks.lost.push_back(track);
    return wrong;
  });
  return estimate;
}

// Whether a landmark without a depth, now at `pixel`, is none of the scene: it has always been at this pixel, although
// the camera's motion moves whatever is there.
bool StandsStill(const StaticRegionOptions& options, const Map& map, const Landmark& landmark,
                 const Eigen::Vector2d& pixel, const RigidTransform& camera_from_world) {
  return HasStayed(landmark, pixel, options.max_motion) &&
         std::ranges::any_of(landmark.observations, [&](const LandmarkObservation& seen) {
           const RigidTransform& then_from_world = map.keyframes[seen.keyframe].camera_from_world;
           return LeastSceneMotion(map.pinhole, camera_from_world * then_from_world.inverse(), seen.pixel) >=
                  options.min_expected_motion;
         });
}

// Landmarks that are tracked from the predicted pose. They give the pose from which all others are searched, within a
// few pixels.
constexpr size_t kPoseSample = 120;
constexpr int kLeastOfPoseSample = 50;
constexpr double kLeastShareOfSample = 0.6;
// Halvings of the image that cover the error of most predictions.
constexpr int kSampleLevels = 1;

// Interval of two images, seconds, after which tracking that has lost many landmarks is repeated by a wide search: that
// of four images a second is longer, that of five is not, however time stamps are rounded.
constexpr double kLongInterval = 0.225;

// Growth of an area since the last image from which on a patch is compared at half the size.
constexpr double kMuchLarger = 2.25;

// Where an image shows a landmark by what it looks like in the last one, of which the pose is known, too.
std::optional<Eigen::Vector2d> PixelByLastImage(const PatchAlignmentOptions& options, const Map& map,
                                                const CameraModel& camera, int landmark, const cv::Mat& last_image,
                                                const Eigen::Vector2d& last_pixel, const RigidTransform& last,
                                                const FlowImage& image, const RigidTransform& camera_from_world) {
  const std::optional<cv::Point2f> guess = PixelOf(map, camera, landmark, camera_from_world);
  const std::optional<Eigen::Matrix2d> current_from_last =
      CurrentFromReference(camera, map.landmarks[landmark].position, last, camera_from_world);
  if (!guess || !current_from_last) return std::nullopt;
  const double growth = current_from_last->determinant();
  if (!(growth > 0)) return std::nullopt;
  // What has grown is not as sharp in the last image: it is compared at half the size.
  const int level = growth > kMuchLarger && image.pyramid.size() > 1 ? 1 : 0;
  const double size = 1 << level;
  const std::optional<Eigen::Vector2d> pixel =
      AlignPatch(options, last_image, last_pixel, size * current_from_last->inverse(), image.pyramid[level],
                 Eigen::Vector2d(guess->x, guess->y) / size);
  if (!pixel) return std::nullopt;
  return size * *pixel;
}

}  // namespace

bool IsBelievable(const TrackingOptions& options, const PoseEstimate& estimate) {
  return estimate.inliers >= options.min_inliers &&
         estimate.inliers >= options.min_inlier_share * static_cast<double>(estimate.inlier.size());
}

void FrameTracker::Start(const FlowImage& image, std::vector<FeatureTrack> tracks, int landmarks) {
  last_image_ = image;
  tracks_ = std::move(tracks);
  lost_tracks_.clear();
  stands_since_.reset();
  landmarks_in_keyframe_ = landmarks;
  features_in_keyframe_ = static_cast<int>(tracks_.size());
}

bool FrameTracker::IsRepeat(const Map& map, const CameraModel& camera, const FlowImage& image,
                            const RigidTransform& predicted, double interval) const {
  return IsRepeated(options_.repeats, options_.alignment, map, camera, last_image_.gray, image.gray, tracks_, predicted,
                    interval);
}

TrackedFrame FrameTracker::Track(const Map& map, const CameraModel& camera, const FlowImage& image,
                                 const MotionModel& motion, const RigidTransform& predicted, double time) {
  const FlowImage before = MatchBrightness(options_.flow, last_image_, image);
  auto [followed, estimate] = TrackFrom(map, camera, before, image, motion.last(), predicted);
  if (!IsBelievable(options_.tracking, estimate)) {
    for (const RigidTransform& other : motion.OtherPredictions(time)) {
      std::tie(followed, estimate) = TrackFrom(map, camera, before, image, motion.last(), other);
      if (IsBelievable(options_.tracking, estimate)) break;
    }
  }
  // What passes in front of a camera that stands may have hidden nearly all that the last image showed.
  if (!IsBelievable(options_.tracking, estimate) && HasStood()) {
    followed = FollowFrom(map, camera, before, image, motion.last(), motion.last());
    estimate = EstimateFramePose(options_.pose, map, motion.last(), followed);
  }
  std::optional<RigidTransform> searched;
  if (!IsBelievable(options_.tracking, estimate))
    searched = SearchPose(map, camera, last_image_, image, tracks_, motion, time);
  else if (LacksLandmarks(map, estimate, time - motion.time()))
    searched = SearchPose(map, camera, last_image_, motion.last(), image, tracks_, estimate.camera_from_world);
  if (searched) {
    auto [found, by_search] = TrackFromSearched(map, camera, before, image, motion.last(), *searched);
    const bool is_better = !IsBelievable(options_.tracking, estimate) || by_search.inliers > estimate.inliers;
    if (is_better && IsBelievable(options_.tracking, by_search)) {
      followed = std::move(found);
      estimate = std::move(by_search);
    }
  }
  TrackedFrame frame{static_cast<int>(followed.found.size()), estimate.inliers, std::nullopt};
  if (!IsBelievable(options_.tracking, estimate)) return frame;
  tracks_ = std::move(followed.found);
  lost_tracks_ = std::move(followed.lost);
  last_image_ = image;
  NoticeStanding(map, estimate.inliers, time);
  frame.camera_from_world = estimate.camera_from_world;
  return frame;
}

bool FrameTracker::LacksLandmarks(const Map& map, const PoseEstimate& estimate, double seconds) const {
  if (seconds < kLongInterval) return false;
  const auto with_depth =
      std::ranges::count_if(tracks_, [&](const FeatureTrack& track) { return map.landmarks[track.landmark].valid; });
  return estimate.inliers < kLeastShareOfSample * static_cast<double>(with_depth);
}

std::pair<FollowedTracks, PoseEstimate> FrameTracker::TrackFromSearched(const Map& map, const CameraModel& camera,
                                                                        const FlowImage& before, const FlowImage& image,
                                                                        const RigidTransform& last,
                                                                        const RigidTransform& searched) const {
  FollowedTracks followed = FollowFrom(map, camera, before, image, last, searched);
  AlignWithLastImage(map, camera, image, last, searched, followed);
  DropMasked(followed);
  PoseEstimate estimate = EstimateFramePose(options_.pose, map, searched, followed);
  return {std::move(followed), std::move(estimate)};
}

void FrameTracker::AlignWithLastImage(const Map& map, const CameraModel& camera, const FlowImage& image,
                                      const RigidTransform& last, const RigidTransform& camera_from_world,
                                      FollowedTracks& tracks) const {
  std::unordered_map<int, Eigen::Vector2d> in_last_image;
  for (const FeatureTrack& track : tracks_)
    if (map.landmarks[track.landmark].valid) in_last_image[track.landmark] = {track.pixel.x, track.pixel.y};
  std::vector<FeatureTrack> lost = std::exchange(tracks.lost, {});
  for (FeatureTrack& track : lost) {
    const auto before = in_last_image.find(track.landmark);
    const std::optional<Eigen::Vector2d> pixel =
        before == in_last_image.end()
            ? std::nullopt
            : PixelByLastImage(options_.alignment, map, camera, track.landmark, last_image_.gray, before->second, last,
                               image, camera_from_world);
    const std::optional<Eigen::Vector2d> undistorted = pixel ? camera.Undistort(*pixel) : std::nullopt;
    if (undistorted) {
      track.pixel = {static_cast<float>(pixel->x()), static_cast<float>(pixel->y())};
      track.undistorted = *undistorted;
    }
    (undistorted ? tracks.found : tracks.lost).push_back(std::move(track));
  }
}

std::pair<FollowedTracks, PoseEstimate> FrameTracker::TrackFrom(const Map& map, const CameraModel& camera,
                                                                const FlowImage& before, const FlowImage& image,
                                                                const RigidTransform& last,
                                                                const RigidTransform& predicted) const {
  std::optional<RigidTransform> pose = PoseOfSample(map, camera, before, image, last, predicted, kSampleLevels);
  if (!pose) pose = PoseOfSample(map, camera, before, image, last, predicted, std::nullopt);
  if (pose) {
    FollowedTracks followed = FollowFrom(map, camera, before, image, last, *pose);
    PoseEstimate estimate = EstimateFramePose(options_.pose, map, *pose, followed);
    if (IsBelievable(options_.tracking, estimate)) return {std::move(followed), std::move(estimate)};
  }
  const std::vector<cv::Point2f> guesses = PredictPixels(map, camera, tracks_, last, predicted);
  FollowedTracks followed = FollowTracks(options_.flow, map, camera, before, image, tracks_, guesses);
  DropMasked(followed);
  PoseEstimate estimate = EstimateFramePose(options_.pose, map, predicted, followed);
  if (IsBelievable(options_.tracking, estimate)) {
    AlignWithMap(map, camera, image, estimate.camera_from_world, followed);
    DropMasked(followed);
    estimate = EstimateFramePose(options_.pose, map, estimate.camera_from_world, followed);
  }
  return {std::move(followed), std::move(estimate)};
}

std::optional<RigidTransform> FrameTracker::PoseOfSample(const Map& map, const CameraModel& camera,
                                                         const FlowImage& before, const FlowImage& image,
                                                         const RigidTransform& last, const RigidTransform& predicted,
                                                         std::optional<int> levels) const {
  std::vector<FeatureTrack> sample;
  for (const FeatureTrack* track : SampleWithDepth(map, tracks_, kPoseSample)) sample.push_back(*track);
  if (sample.size() < kLeastOfPoseSample) return std::nullopt;
  FollowedTracks followed = FollowTracks(options_.flow, map, camera, before, image, sample,
                                         PredictPixels(map, camera, sample, last, predicted), levels);
  DropMasked(followed);
  const PoseEstimate estimate = EstimateFramePose(options_.pose, map, predicted, followed);
  if (estimate.inliers < kLeastOfPoseSample ||
      estimate.inliers < kLeastShareOfSample * static_cast<double>(sample.size()))
    return std::nullopt;
  return estimate.camera_from_world;
}

FollowedTracks FrameTracker::FollowFrom(const Map& map, const CameraModel& camera, const FlowImage& before,
                                        const FlowImage& image, const RigidTransform& last,
                                        const RigidTransform& camera_from_world) const {
  std::vector<FeatureTrack> with_depth;
  std::vector<FeatureTrack> without_depth;
  with_depth.reserve(tracks_.size() + lost_tracks_.size());
  without_depth.reserve(tracks_.size());
  for (const FeatureTrack& track : tracks_)
    (map.landmarks[track.landmark].valid ? with_depth : without_depth).push_back(track);
  FollowedTracks followed =
      FollowWithoutDepth(options_.flow, map, camera, before, image, without_depth, last, camera_from_world);
  with_depth.insert(with_depth.end(), lost_tracks_.begin(), lost_tracks_.end());
  SearchByMap(map, camera, image, camera_from_world, std::move(with_depth), followed);
  DropMasked(followed);
  return followed;
}

void FrameTracker::SearchByMap(const Map& map, const CameraModel& camera, const FlowImage& image,
                               const RigidTransform& camera_from_world, std::vector<FeatureTrack> missing,
                               FollowedTracks& tracks) const {
  const int oldest = static_cast<int>(map.keyframes.size()) - options_.tracking.memory_keyframes;
  std::erase_if(missing, [&](const FeatureTrack& track) {
    return !map.landmarks[track.landmark].valid || track.last_keyframe < oldest;
  });
  std::vector<std::optional<cv::Point2f>> guesses(missing.size());
  cv::parallel_for_(cv::Range(0, static_cast<int>(missing.size())), [&](const cv::Range& range) {
    for (int i = range.start; i < range.end; ++i)
      guesses[i] = PixelOf(map, camera, missing[i].landmark, camera_from_world);
  });
  const std::vector<uchar> found =
      AlignTracks(options_.alignment, map, camera, image.gray, camera_from_world, guesses, missing);
  tracks.found.reserve(tracks.found.size() + missing.size());
  for (size_t i = 0; i < missing.size(); ++i)
    (found[i] != 0 ? tracks.found : tracks.lost).push_back(std::move(missing[i]));
}

void FrameTracker::DropMasked(FollowedTracks& tracks) const {
  if (mask_.empty()) return;
  // Lost, not ended: what a bonnet covers may come back beside it.
  const auto masked = std::stable_partition(tracks.found.begin(), tracks.found.end(),
                                            [&](const FeatureTrack& track) { return IsKept(mask_, track.pixel); });
  std::move(masked, tracks.found.end(), std::back_inserter(tracks.lost));
  tracks.found.erase(masked, tracks.found.end());
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

void FrameTracker::AlignWithMap(const Map& map, const CameraModel& camera, const FlowImage& image,
                                const RigidTransform& camera_from_world, FollowedTracks& tracks) const {
  const auto has_depth = [&](const FeatureTrack& track) { return map.landmarks[track.landmark].valid; };
  std::vector<std::optional<cv::Point2f>> guesses;
  for (const FeatureTrack& track : tracks.found)
    guesses.push_back(has_depth(track) ? std::optional(track.pixel) : std::nullopt);
  const std::vector<uchar> same =
      AlignTracks(options_.alignment, map, camera, image.gray, camera_from_world, guesses, tracks.found);

  // Search again for lost landmarks, at their predicted pixels.
  std::vector<FeatureTrack> missing = lost_tracks_;
  std::ranges::move(tracks.lost, std::back_inserter(missing));
  FollowedTracks aligned;
  for (size_t i = 0; i < tracks.found.size(); ++i)
    (has_depth(tracks.found[i]) && same[i] == 0 ? missing : aligned.found).push_back(std::move(tracks.found[i]));
  SearchByMap(map, camera, image, camera_from_world, std::move(missing), aligned);
  tracks = std::move(aligned);
}

void FrameTracker::NoticeStanding(const Map& map, int inliers, double time) {
  // A high quantile, as landmarks straight ahead of a moving car hardly move in the image.
  constexpr double kMost = 0.75;
  constexpr size_t kFewest = 10;
  // So many times the least motion is more than the errors of the few landmarks that are left in sight.
  constexpr double kClearly = 5;
  const KeyframeOptions& limits = options_.keyframes;
  last_time_ = time;
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
}

bool FrameTracker::HasStood() const {
  constexpr double kLeastSeconds = 1;
  return stands_since_ && last_time_ - *stands_since_ >= kLeastSeconds;
}

bool FrameTracker::NeedsKeyframe(const Map& map, const TrackedFrame& frame) const {
  if (HasStood()) return false;
  const KeyframeOptions& limits = options_.keyframes;
  if (frame.inliers < limits.min_tracked_share * landmarks_in_keyframe_) return true;
  const Eigen::Quaterniond turn =
      frame.camera_from_world->rotation * map.keyframes.back().camera_from_world.rotation.conjugate();
  if (RotationAngle(turn) * kDegreesPerRadian > limits.min_rotation_deg) return true;
  std::vector<double> parallax;
  for (const FeatureTrack& track : tracks_) {
    if (!track.in_keyframe) continue;
    const Eigen::Vector3d rotated = turn * map.pinhole.Ray(*track.in_keyframe);
    const Eigen::Vector3d seen = map.pinhole.Ray(track.undistorted);
    parallax.push_back(std::atan2(rotated.cross(seen).norm(), rotated.dot(seen)));
  }
  if (parallax.empty() || static_cast<double>(parallax.size()) < limits.min_followed_share * features_in_keyframe_)
    return true;
  return Median(std::move(parallax)) * kDegreesPerRadian > limits.min_parallax_deg;
}

void FrameTracker::Replenish(const CameraModel& camera, const FlowImage& image,
                             const std::vector<cv::KeyPoint>& candidates, Map& map) {
  landmarks_in_keyframe_ = static_cast<int>(
      std::ranges::count_if(tracks_, [&](const FeatureTrack& track) { return map.landmarks[track.landmark].valid; }));
  for (FeatureTrack& track : tracks_) {
    track.in_keyframe = track.undistorted;
    track.last_keyframe = static_cast<int>(map.keyframes.size()) - 1;
  }
  for (FeatureTrack& track : lost_tracks_) track.in_keyframe.reset();
  const auto reference = std::make_shared<const cv::Mat>(image.gray);
  RenewReferences(map, camera, reference);
  DetectNewFeatures(camera, reference, candidates, map);
  features_in_keyframe_ = static_cast<int>(tracks_.size());
}

void FrameTracker::RenewReferences(const Map& map, const CameraModel& camera,
                                   const std::shared_ptr<const cv::Mat>& image) {
  const int keyframe = static_cast<int>(map.keyframes.size()) - 1;
  const double limit = options_.keyframes.max_growth * options_.keyframes.max_growth;
  const auto has_grown = [&](const FeatureTrack& track) {
    if (!map.landmarks[track.landmark].valid) return false;
    const std::optional<Eigen::Matrix2d> current_from_reference =
        CurrentFromReference(map, camera, track, map.keyframes[keyframe].camera_from_world);
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

void FrameTracker::DetectNewFeatures(const CameraModel& camera, const std::shared_ptr<const cv::Mat>& image,
                                     const std::vector<cv::KeyPoint>& candidates, Map& map) {
  const int keyframe = static_cast<int>(map.keyframes.size()) - 1;
  for (const cv::Point2f& corner : DetectCorners(options_.corners, *image, candidates, PixelsOf(tracks_), mask_)) {
    const std::optional<Eigen::Vector2d> undistorted = camera.Undistort({corner.x, corner.y});
    if (!undistorted) continue;
    const int landmark = static_cast<int>(map.landmarks.size());
    map.landmarks.push_back({});
    AddObservation(map, keyframe, landmark, *undistorted);
    tracks_.push_back({landmark, corner, *undistorted, *undistorted, image, corner, keyframe, keyframe});
  }
}

void FrameTracker::Drop(const std::vector<int>& landmarks) {
  const std::unordered_set<int> ended(landmarks.begin(), landmarks.end());
  for (std::vector<FeatureTrack>* tracks : {&tracks_, &lost_tracks_})
    std::erase_if(*tracks, [&](const FeatureTrack& track) { return ended.contains(track.landmark); });
}

void FrameTracker::Reindex(const std::vector<int>& new_index) {
  for (std::vector<FeatureTrack>* tracks : {&tracks_, &lost_tracks_}) {
    for (FeatureTrack& track : *tracks) track.landmark = new_index[track.landmark];
    std::erase_if(*tracks, [](const FeatureTrack& track) { return track.landmark < 0; });
  }
}

void FrameTracker::Correct(const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& corrected) {
  for (std::vector<FeatureTrack>* tracks : {&tracks_, &lost_tracks_})
    for (FeatureTrack& track : *tracks) {
      track.undistorted = corrected(track.undistorted);
      if (track.in_keyframe) track.in_keyframe = corrected(*track.in_keyframe);
    }
}

}  // namespace turnscale

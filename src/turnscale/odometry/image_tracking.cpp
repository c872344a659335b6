// SPDX-License-Identifier: MIT
#include "turnscale/odometry/image_tracking.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/LU>
#include <opencv2/core/utility.hpp>

#include "turnscale/features/patch_alignment.h"
#include "turnscale/odometry/image_mask.h"
#include "turnscale/odometry/pose_search.h"

namespace turnscale {
namespace {

// Landmarks that are tracked from the predicted pose. They give the pose from which all others are searched, within a
// few pixels, or that of an image of which only a sample is tracked.
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

// Tracks landmarks into the next image, from a pose that the caller assumes there.
class ImageTracker {
 public:
  ImageTracker(const OdometryOptions& options, const Map& map, const cv::Mat& mask, const ImageStep& step)
      : options_(options), map_(map), mask_(mask), step_(step), last_(step.last_from_world) {}

  bool IsBelievable(const TrackedPose& pose) const { return turnscale::IsBelievable(options_.tracking, pose.estimate); }

  // From a pose that may be off by many pixels.
  TrackedPose TrackFrom(const RigidTransform& predicted) const {
    std::optional<RigidTransform> pose = PoseOfSample(predicted, kSampleLevels);
    if (!pose) pose = PoseOfSample(predicted, std::nullopt);
    if (pose) {
      TrackedPose tracked = TrackNear(*pose);
      if (IsBelievable(tracked)) return tracked;
    }
    return TrackByFlow(predicted);
  }

  // A sample of the landmarks, by their reference views, from a pose that is correct within a few pixels; empty where
  // they do not agree. The errors of landmarks, which differ from one sample to another, are those of the last image
  // and cancel: the motion since then is measured.
  std::optional<TrackedPose> TrackSample(const RigidTransform& pose) const {
    std::vector<FeatureTrack> sample = Sample();
    const size_t wanted = sample.size();
    if (wanted < kLeastOfPoseSample) return std::nullopt;
    std::unordered_map<int, Eigen::Vector2d> residuals;
    for (const FeatureTrack& track : sample) {
      const Eigen::Vector3d in_last_image = last_ * map_.landmarks[track.landmark].position;
      residuals[track.landmark] = track.undistorted - map_.camera.pinhole.Project(in_last_image);
    }
    FollowedTracks tracks;
    SearchByMap(pose, std::move(sample), tracks);
    DropMasked(tracks);
    for (FeatureTrack& track : tracks.found) track.undistorted -= residuals.at(track.landmark);
    TrackedPose tracked = EstimateFrom(pose, std::move(tracks));
    if (!Agree(tracked.estimate, wanted) || !IsBelievable(tracked)) return std::nullopt;
    tracked.is_sampled = true;
    return tracked;
  }

  // From a pose that is correct within a few pixels.
  TrackedPose TrackNear(const RigidTransform& pose) const { return EstimateFrom(pose, FollowFrom(pose)); }

  // The same from the result of a wide search, between images with much motion: also landmarks that have come much
  // nearer.
  TrackedPose TrackSearched(const RigidTransform& pose) const {
    FollowedTracks followed = FollowFrom(pose);
    AlignWithLastImage(pose, followed);
    DropMasked(followed);
    return EstimateFrom(pose, std::move(followed));
  }

  // Searches all poses that the car may have reached.
  std::optional<RigidTransform> SearchAll() const { return SearchPose(map_, step_); }

  // Aligns a believable pose over a wider range if fewer landmarks agree with it than should: what has come nearer over
  // a long interval looks too different for optical flow.
  std::optional<RigidTransform> SearchNear(const TrackedPose& pose) const {
    if (step_.time - step_.last_time < kLongInterval) return std::nullopt;
    const auto with_depth =
        std::ranges::count_if(step_.tracks, [&](const FeatureTrack& track) { return HasDepth(track); });
    if (pose.estimate.inliers >= kLeastShareOfSample * static_cast<double>(with_depth)) return std::nullopt;
    return AlignPose(map_, step_, pose.estimate.camera_from_world);
  }

 private:
  std::vector<FeatureTrack> Sample() const {
    std::vector<FeatureTrack> sample;
    for (const FeatureTrack* track : SampleWithDepth(map_, step_.tracks, kPoseSample)) sample.push_back(*track);
    return sample;
  }

  // Enough of a sample of so many landmarks.
  static bool Agree(const PoseEstimate& estimate, size_t landmarks) {
    return estimate.inliers >= kLeastOfPoseSample &&
           estimate.inliers >= kLeastShareOfSample * static_cast<double>(landmarks);
  }

  const FlowImage& Before() const {
    if (!before_) before_ = MatchBrightness(options_.flow, step_.last_image, step_.image);
    return *before_;
  }

  bool HasDepth(const FeatureTrack& track) const { return map_.landmarks[track.landmark].valid; }

  TrackedPose EstimateFrom(const RigidTransform& initial, FollowedTracks tracks) const {
    std::vector<PointSighting> sightings;
    for (const FeatureTrack& track : tracks.found)
      if (HasDepth(track)) sightings.push_back({map_.landmarks[track.landmark].position, track.undistorted});
    PoseEstimate estimate = EstimatePose(options_.pose, map_.camera.pinhole, sightings, initial);
    size_t sighting = 0;
    std::erase_if(tracks.found, [&](const FeatureTrack& track) {
      const bool wrong = HasDepth(track) && estimate.inlier[sighting++] == 0;
      if (wrong) tracks.lost.push_back(track);
      return wrong;
    });
    return {std::move(tracks), std::move(estimate)};
  }

  // The pose by a sample of the landmarks, searched from this many halvings of the image on (empty: all); empty where
  // they do not agree.
  std::optional<RigidTransform> PoseOfSample(const RigidTransform& predicted, std::optional<int> levels) const {
    const std::vector<FeatureTrack> sample = Sample();
    if (sample.size() < kLeastOfPoseSample) return std::nullopt;
    const PoseEstimate estimate = EstimateFrom(predicted, Follow(sample, predicted, levels)).estimate;
    if (!Agree(estimate, sample.size())) return std::nullopt;
    return estimate.camera_from_world;
  }

  // All tracks by optical flow. Where that gives a pose, landmarks are then compared with their reference views.
  TrackedPose TrackByFlow(const RigidTransform& predicted) const {
    TrackedPose tracked = EstimateFrom(predicted, Follow(step_.tracks, predicted, std::nullopt));
    if (!IsBelievable(tracked)) return tracked;
    const RigidTransform pose = tracked.estimate.camera_from_world;
    return EstimateFrom(pose, AlignWithMap(pose, std::move(tracked.tracks)));
  }

  FollowedTracks Follow(const std::vector<FeatureTrack>& tracks, const RigidTransform& predicted,
                        std::optional<int> levels) const {
    FollowedTracks followed = FollowTracks(options_.flow, map_, Before(), step_.image, tracks,
                                           PredictPixels(map_, tracks, last_, predicted), levels);
    DropMasked(followed);
    return followed;
  }

  // Landmarks by their reference views, starting at their pixels by the pose, and tracks without a depth by optical
  // flow.
  FollowedTracks FollowFrom(const RigidTransform& pose) const {
    std::vector<FeatureTrack> with_depth;
    std::vector<FeatureTrack> without_depth;
    with_depth.reserve(step_.tracks.size() + step_.lost_tracks.size());
    without_depth.reserve(step_.tracks.size());
    for (const FeatureTrack& track : step_.tracks) (HasDepth(track) ? with_depth : without_depth).push_back(track);
    FollowedTracks followed =
        FollowWithoutDepth(options_.flow, map_, {Before(), last_}, {step_.image, pose}, without_depth);
    with_depth.insert(with_depth.end(), step_.lost_tracks.begin(), step_.lost_tracks.end());
    SearchByMap(pose, std::move(with_depth), followed);
    DropMasked(followed);
    return followed;
  }

  // Corrects tracks by their reference views, where they start at the pixels that optical flow has found. Lost ones
  // start at their pixels by the pose.
  FollowedTracks AlignWithMap(const RigidTransform& pose, FollowedTracks tracks) const {
    std::vector<std::optional<cv::Point2f>> guesses;
    for (const FeatureTrack& track : tracks.found)
      guesses.push_back(HasDepth(track) ? std::optional(track.pixel) : std::nullopt);
    const std::vector<uchar> same = AlignTracks(options_.alignment, map_, {step_.image, pose}, guesses, tracks.found);
    std::vector<FeatureTrack> missing = step_.lost_tracks;
    std::ranges::move(tracks.lost, std::back_inserter(missing));
    FollowedTracks aligned;
    for (size_t i = 0; i < tracks.found.size(); ++i)
      (HasDepth(tracks.found[i]) && same[i] == 0 ? missing : aligned.found).push_back(std::move(tracks.found[i]));
    SearchByMap(pose, std::move(missing), aligned);
    DropMasked(aligned);
    return aligned;
  }

  // Aligns landmarks with their reference views, starting at their pixels by the pose.
  void SearchByMap(const RigidTransform& pose, std::vector<FeatureTrack> missing, FollowedTracks& tracks) const {
    const int oldest = CountKeyframes(map_) - options_.tracking.memory_keyframes;
    std::erase_if(missing, [&](const FeatureTrack& track) { return !HasDepth(track) || track.last_keyframe < oldest; });
    std::vector<std::optional<cv::Point2f>> guesses(missing.size());
    cv::parallel_for_(cv::Range(0, static_cast<int>(missing.size())), [&](const cv::Range& range) {
      for (int i = range.start; i < range.end; ++i) guesses[i] = PixelOf(map_, missing[i].landmark, pose);
    });
    const std::vector<uchar> found = AlignTracks(options_.alignment, map_, {step_.image, pose}, guesses, missing);
    tracks.found.reserve(tracks.found.size() + missing.size());
    for (size_t i = 0; i < missing.size(); ++i)
      (found[i] != 0 ? tracks.found : tracks.lost).push_back(std::move(missing[i]));
  }

  // Compares lost landmarks with the last image, which shows them larger than their reference views do.
  void AlignWithLastImage(const RigidTransform& pose, FollowedTracks& tracks) const {
    std::unordered_map<int, Eigen::Vector2d> in_last_image;
    for (const FeatureTrack& track : step_.tracks)
      if (HasDepth(track)) in_last_image[track.landmark] = {track.pixel.x, track.pixel.y};
    std::vector<FeatureTrack> lost = std::exchange(tracks.lost, {});
    for (FeatureTrack& track : lost) {
      const auto before = in_last_image.find(track.landmark);
      const std::optional<Eigen::Vector2d> pixel =
          before == in_last_image.end() ? std::nullopt : PixelByLastImage(track.landmark, before->second, pose);
      const std::optional<Eigen::Vector2d> undistorted = pixel ? map_.camera.Undistort(*pixel) : std::nullopt;
      if (undistorted) {
        track.pixel = {static_cast<float>(pixel->x()), static_cast<float>(pixel->y())};
        track.undistorted = *undistorted;
      }
      (undistorted ? tracks.found : tracks.lost).push_back(std::move(track));
    }
  }

  // Where the next image shows a landmark, by what it looks like at its pixel in the last one.
  std::optional<Eigen::Vector2d> PixelByLastImage(int landmark, const Eigen::Vector2d& last_pixel,
                                                  const RigidTransform& pose) const {
    const std::optional<cv::Point2f> guess = PixelOf(map_, landmark, pose);
    const std::optional<Eigen::Matrix2d> current_from_last =
        CurrentFromReference(map_.camera, map_.landmarks[landmark].position, last_, pose);
    if (!guess || !current_from_last) return std::nullopt;
    const double growth = current_from_last->determinant();
    if (!(growth > 0)) return std::nullopt;
    // What has grown is not as sharp in the last image: it is compared at half the size.
    const int level = growth > kMuchLarger && step_.image.pyramid.size() > 1 ? 1 : 0;
    const double size = 1 << level;
    const std::optional<Eigen::Vector2d> pixel =
        AlignPatch(options_.alignment, step_.last_image.gray, last_pixel, size * current_from_last->inverse(),
                   step_.image.pyramid[level], Eigen::Vector2d(guess->x, guess->y) / size);
    if (!pixel) return std::nullopt;
    return size * *pixel;
  }

  void DropMasked(FollowedTracks& tracks) const {
    if (mask_.empty()) return;
    // Lost, not ended: what a bonnet covers may come back beside it.
    const auto masked = std::stable_partition(tracks.found.begin(), tracks.found.end(),
                                              [&](const FeatureTrack& track) { return IsKept(mask_, track.pixel); });
    std::move(masked, tracks.found.end(), std::back_inserter(tracks.lost));
    tracks.found.erase(masked, tracks.found.end());
  }

  const OdometryOptions& options_;
  const Map& map_;
  const cv::Mat& mask_;
  const ImageStep& step_;
  RigidTransform last_;  // the camera's pose in the last image
  mutable std::optional<FlowImage>
      before_;  // the last image, as bright as the next one; empty until optical flow is needed
};

}  // namespace

bool IsBelievable(const TrackingOptions& options, const PoseEstimate& estimate) {
  return estimate.inliers >= options.min_inliers && estimate.inlier_share >= options.min_inlier_share;
}

std::optional<TrackedPose> TrackSample(const OdometryOptions& options, const Map& map, const cv::Mat& mask,
                                       const ImageStep& step, const RigidTransform& predicted) {
  return ImageTracker(options, map, mask, step).TrackSample(predicted);
}

TrackedPose TrackImage(const OdometryOptions& options, const Map& map, const cv::Mat& mask, const ImageStep& step,
                       const RigidTransform& predicted) {
  const ImageTracker tracker(options, map, mask, step);
  TrackedPose tracked = tracker.TrackFrom(predicted);
  if (!tracker.IsBelievable(tracked)) {
    for (const RigidTransform& other : step.motion.OtherPredictions(step.time)) {
      tracked = tracker.TrackFrom(other);
      if (tracker.IsBelievable(tracked)) break;
    }
  }
  if (!tracker.IsBelievable(tracked) && step.has_stood) tracked = tracker.TrackNear(step.motion.last());

  const bool believable = tracker.IsBelievable(tracked);
  const std::optional<RigidTransform> searched = believable ? tracker.SearchNear(tracked) : tracker.SearchAll();
  if (!searched) return tracked;
  TrackedPose by_search = tracker.TrackSearched(*searched);
  const bool is_better = !believable || by_search.estimate.inlier_weight > tracked.estimate.inlier_weight;
  return is_better && tracker.IsBelievable(by_search) ? std::move(by_search) : std::move(tracked);
}

}  // namespace turnscale

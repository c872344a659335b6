// SPDX-License-Identifier: MIT
#include "turnscale/odometry/odometry.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/camera/radial_correction.h"
#include "turnscale/features/corners.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/landmarks.h"
#include "turnscale/mapping/local_bundle_adjustment.h"

namespace turnscale {
namespace {

// A correction that moves the pixels at a wide image's edge by a hundredth of a pixel.
constexpr double kLeastLensChange = 2e-5;

FrameResult NewResult(int frame, double time, TrackingState state) {
  FrameResult result;
  result.frame = frame;
  result.time = time;
  result.state = state;
  return result;
}

}  // namespace

Odometry::Odometry(const OdometryOptions& options, const CameraModel& camera)
    : options_((options.Check(), options)),
      camera_(camera),
      initializer_(options, camera),
      lens_(options.lens),
      scale_(options) {
  map_.pinhole = camera.pinhole;
  cv::setNumThreads(options.threads);
}

FrameResult Odometry::Process(const cv::Mat& gray, double time) {
  FrameResult result = NewResult(frames_++, time, TrackingState::kInitializing);
  CheckSize(gray);
  const FlowImage image = BuildFlowImage(options_.flow, gray);
  if (!mapping_) return Initialize(image, result);

  const RigidTransform predicted = motion_.Predict(time);
  const std::vector<cv::Point2f> guesses = PredictPixels(map_, camera_, tracks_, motion_.last(), predicted);
  FollowedTracks followed = FollowTracks(options_.flow, map_, camera_, last_image_, image, tracks_, guesses);
  PoseEstimate estimate = LocateFrame(predicted, followed);
  if (Believable(estimate)) {
    AlignWithMap(image, estimate.camera_from_world, followed);
    estimate = LocateFrame(estimate.camera_from_world, followed);
  }
  result.tracked = static_cast<int>(followed.found.size());
  result.inliers = estimate.inliers;
  if (!Believable(estimate)) return Bridge(predicted, result);

  tracks_ = std::move(followed.found);
  lost_tracks_ = std::move(followed.lost);
  last_image_ = image;
  lost_frames_ = 0;
  result.state = TrackingState::kTracked;
  motion_.Update(time, estimate.camera_from_world);
  if (!NeedsKeyframe(estimate.camera_from_world, estimate.inliers)) return Record(result, estimate.camera_from_world);
  AddKeyframe(image, estimate.camera_from_world, result);
  return Record(result, map_.keyframes.back().camera_from_world);
}

void Odometry::CheckSize(const cv::Mat& gray) {
  if (gray.type() != CV_8UC1) throw InputError("image: has to be 8-bit gray");
  if (camera_.width == 0) {
    // Not every camera file tells the size; the first image does.
    camera_.width = gray.cols;
    camera_.height = gray.rows;
    initializer_ = MapInitializer(options_, camera_);
  }
  if (gray.cols != camera_.width || gray.rows != camera_.height)
    throw InputError("image: is " + std::to_string(gray.cols) + "x" + std::to_string(gray.rows) +
                     ", the camera's are " + std::to_string(camera_.width) + "x" + std::to_string(camera_.height));
}

FrameResult Odometry::ProcessUnreadable(double time) {
  const FrameResult result = NewResult(frames_++, time, TrackingState::kUnreadable);
  if (map_.keyframes.empty()) {
    history_.AddWithoutPose(result);
    return result;
  }
  return Bridge(motion_.Predict(time), result);
}

void Odometry::Finish() {
  const ScaleUpdate update = scale_.Finish(map_);
  if (!update.factors.empty()) ApplyScale(update.factors);
}

FrameResult Odometry::Initialize(const FlowImage& image, FrameResult result) {
  const std::optional<InitialMap> start = initializer_.Add(image, result.frame, result.time);
  result.tracked = initializer_.tracked();
  if (!map_.keyframes.empty()) result = Bridge(motion_.Predict(result.time), result);
  if (map_.keyframes.empty()) history_.AddWithoutPose(result);
  if (!start) return result;
  StartMap(*start);
  last_image_ = image;
  result.state = TrackingState::kTracked;
  result.inliers = landmarks_in_keyframe_;
  result.keyframe = true;
  return Record(result, map_.keyframes.back().camera_from_world);
}

void Odometry::StartMap(const InitialMap& start) {
  const WaitingFrame& first = start.frames.front();
  const WaitingFrame& second = start.frames.back();
  const bool continues = !map_.keyframes.empty();
  // A map that goes on after a gap takes over where the motion model has arrived, at the speed it had.
  const RigidTransform first_from_world = continues ? motion_.Predict(first.time) : RigidTransform{};
  const double expected = motion_.speed() * (second.time - first.time);
  const double unit = continues && expected > 0 ? expected / start.second_from_first.translation.norm() : 1.0;
  RigidTransform second_from_first = start.second_from_first;
  second_from_first.translation *= unit;

  const int first_landmark = static_cast<int>(map_.landmarks.size());
  const int keyframe = static_cast<int>(map_.keyframes.size());
  map_.keyframes.push_back({first.frame, first.time, first_from_world, {}, continues});
  map_.keyframes.push_back({second.frame, second.time, second_from_first * first_from_world, {}, false});
  for (size_t i = 0; i < first.features.size(); ++i) {
    map_.landmarks.push_back({first_from_world.inverse() * (unit * start.points[i]), start.has_point[i] != 0, {}});
    AddObservation(map_, keyframe, first_landmark + static_cast<int>(i), first.pixels[i]);
  }
  tracks_.clear();
  lost_tracks_.clear();
  for (size_t i = 0; i < second.features.size(); ++i) {
    const int landmark = first_landmark + second.features[i];
    AddObservation(map_, keyframe + 1, landmark, second.pixels[i]);
    tracks_.push_back({landmark, start.second_pixels[i], second.pixels[i], second.pixels[i], start.first_image,
                       start.first_pixels[second.features[i]], keyframe, keyframe + 1});
  }
  mapping_ = true;
  lost_frames_ = 0;
  landmarks_in_keyframe_ = static_cast<int>(std::ranges::count(start.has_point, 1));
  LocateWaitingFrames(start, first_landmark, keyframe);
  for (const int added : {keyframe, keyframe + 1}) {
    // A gap ends a turn that was under way before it.
    const ScaleUpdate update = scale_.AddKeyframe(added, map_);
    if (!update.factors.empty()) ApplyScale(update.factors);
  }
  ++revision_;
}

void Odometry::LocateWaitingFrames(const InitialMap& start, int first_landmark, int keyframe) {
  RigidTransform pose = map_.keyframes[keyframe].camera_from_world;
  for (const WaitingFrame& waiting : start.frames) {
    std::vector<PointSighting> sightings;
    for (size_t i = 0; i < waiting.features.size(); ++i) {
      const Landmark& landmark = map_.landmarks[first_landmark + waiting.features[i]];
      if (landmark.valid) sightings.push_back({landmark.position, waiting.pixels[i]});
    }
    const PoseEstimate estimate = EstimatePose(options_.pose, camera_.pinhole, sightings, pose);
    const bool is_second = &waiting == &start.frames.back();
    pose = is_second ? map_.keyframes.back().camera_from_world : estimate.camera_from_world;
    motion_.Update(waiting.time, pose);
    if (is_second) break;
    FrameResult result = NewResult(waiting.frame, waiting.time, TrackingState::kTracked);
    result.tracked = static_cast<int>(waiting.features.size());
    result.inliers = estimate.inliers;
    result.keyframe = &waiting == &start.frames.front();
    Record(result, keyframe, result.keyframe ? map_.keyframes[keyframe].camera_from_world : pose);
  }
}

PoseEstimate Odometry::LocateFrame(const RigidTransform& predicted, FollowedTracks& tracks) const {
  std::vector<PointSighting> sightings;
  for (const FeatureTrack& track : tracks.found)
    if (map_.landmarks[track.landmark].valid)
      sightings.push_back({map_.landmarks[track.landmark].position, track.undistorted});
  PoseEstimate estimate = EstimatePose(options_.pose, camera_.pinhole, sightings, predicted);
  // What disagrees with the pose has slipped, or moves by itself.
  size_t sighting = 0;
  std::erase_if(tracks.found, [&](const FeatureTrack& track) {
    const bool wrong = map_.landmarks[track.landmark].valid && estimate.inlier[sighting++] == 0;
    if (wrong) tracks.lost.push_back(track);
    return wrong;
  });
  return estimate;
}

void Odometry::AlignWithMap(const FlowImage& image, const RigidTransform& camera_from_world,
                            FollowedTracks& tracks) const {
  std::vector<FeatureTrack> candidates = lost_tracks_;
  for (const FeatureTrack& track : tracks.lost) candidates.push_back(track);
  tracks.lost.clear();
  std::erase_if(tracks.found, [&](FeatureTrack& track) {
    if (!map_.landmarks[track.landmark].valid) return false;
    const bool same = AlignTrack(options_.alignment, map_, camera_, image.gray, camera_from_world, track.pixel, track);
    if (!same) candidates.push_back(track);
    return !same;
  });
  const int oldest = static_cast<int>(map_.keyframes.size()) - options_.tracking.memory_keyframes;
  for (FeatureTrack& track : candidates) {
    if (!map_.landmarks[track.landmark].valid || track.last_keyframe < oldest) continue;
    const std::optional<cv::Point2f> expected = PixelOf(map_, camera_, track.landmark, camera_from_world);
    const bool found =
        expected && AlignTrack(options_.alignment, map_, camera_, image.gray, camera_from_world, *expected, track);
    (found ? tracks.found : tracks.lost).push_back(track);
  }
}

bool Odometry::Believable(const PoseEstimate& estimate) const {
  return estimate.inliers >= options_.tracking.min_inliers &&
         estimate.inliers >= options_.tracking.min_inlier_share * static_cast<double>(estimate.inlier.size());
}

FrameResult Odometry::Bridge(const RigidTransform& predicted, FrameResult result) {
  if (result.state != TrackingState::kUnreadable) result.state = TrackingState::kBridged;
  if (mapping_ && ++lost_frames_ > options_.tracking.max_lost_frames) {
    mapping_ = false;
    initializer_ = MapInitializer(options_, camera_);
  }
  return Record(result, predicted);
}

bool Odometry::NeedsKeyframe(const RigidTransform& camera_from_world, int inliers) const {
  const KeyframeOptions& limits = options_.keyframes;
  if (inliers < limits.min_tracked_share * landmarks_in_keyframe_) return true;
  const Eigen::Quaterniond turn =
      camera_from_world.rotation * map_.keyframes.back().camera_from_world.rotation.conjugate();
  if (RotationAngle(turn) * kDegreesPerRadian > limits.min_rotation_deg) return true;
  std::vector<double> parallax;
  for (const FeatureTrack& track : tracks_) {
    if (!track.in_keyframe) continue;
    const Eigen::Vector3d rotated = turn * map_.pinhole.Ray(*track.in_keyframe);
    const Eigen::Vector3d seen = map_.pinhole.Ray(track.undistorted);
    parallax.push_back(std::atan2(rotated.cross(seen).norm(), rotated.dot(seen)));
  }
  if (parallax.empty()) return true;
  const auto middle = parallax.begin() + static_cast<std::ptrdiff_t>(parallax.size() / 2);
  std::nth_element(parallax.begin(), middle, parallax.end());
  return *middle * kDegreesPerRadian > limits.min_parallax_deg;
}

void Odometry::AddKeyframe(const FlowImage& image, const RigidTransform& camera_from_world, FrameResult& result) {
  const int keyframe = static_cast<int>(map_.keyframes.size());
  map_.keyframes.push_back({result.frame, result.time, camera_from_world, {}, false});
  std::vector<int> seen;
  for (const FeatureTrack& track : tracks_) {
    AddObservation(map_, keyframe, track.landmark, track.undistorted);
    seen.push_back(track.landmark);
  }
  TriangulateLandmarks(options_.landmarks, seen, map_);
  const LocalBundleResult adjusted = AdjustLocalWindow(options_.local_bundle, map_);
  const std::vector<int> lost = CullLandmarks(options_.landmarks, adjusted.landmarks, keyframe, map_);
  const std::unordered_set<int> ended(lost.begin(), lost.end());
  std::erase_if(tracks_, [&](const FeatureTrack& track) { return ended.contains(track.landmark); });
  RefineLens();
  motion_.Correct(map_.keyframes.back().camera_from_world, 1.0);

  ObserveScale(result);
  landmarks_in_keyframe_ = static_cast<int>(
      std::ranges::count_if(tracks_, [&](const FeatureTrack& track) { return map_.landmarks[track.landmark].valid; }));
  for (FeatureTrack& track : tracks_) {
    track.in_keyframe = track.undistorted;
    track.last_keyframe = keyframe;
  }
  for (FeatureTrack& track : lost_tracks_) track.in_keyframe.reset();
  RenewReferences(image);
  DetectNewFeatures(image);
  result.keyframe = true;
}

void Odometry::RefineLens() {
  const double applied = camera_.radial_correction;
  if (!lens_.Observe(map_, applied) || std::abs(lens_.correction() - applied) < kLeastLensChange) return;
  camera_.radial_correction = lens_.correction();
  const auto corrected = [&](const Eigen::Vector2d& pixel) {
    return CorrectRadially(map_.pinhole, camera_.radial_correction, UndoRadialCorrection(map_.pinhole, applied, pixel));
  };
  for (Keyframe& keyframe : map_.keyframes)
    for (KeyframeObservation& seen : keyframe.observations) seen.pixel = corrected(seen.pixel);
  for (Landmark& landmark : map_.landmarks)
    for (LandmarkObservation& seen : landmark.observations) seen.pixel = corrected(seen.pixel);
  for (std::vector<FeatureTrack>* tracks : {&tracks_, &lost_tracks_})
    for (FeatureTrack& track : *tracks) {
      track.undistorted = corrected(track.undistorted);
      if (track.in_keyframe) track.in_keyframe = corrected(*track.in_keyframe);
    }
  AdjustLocalWindow(options_.local_bundle, map_);
}

void Odometry::ObserveScale(FrameResult& result) {
  const ScaleUpdate update = scale_.AddKeyframe(static_cast<int>(map_.keyframes.size()) - 1, map_);
  result.psi = update.motion.psi;
  result.theta = update.motion.theta;
  if (!update.factors.empty()) ApplyScale(update.factors);
}

void Odometry::ApplyScale(const std::vector<double>& factors) {
  history_.Rescale(factors);
  motion_.Correct(map_.keyframes.back().camera_from_world, factors.back());
  ++revision_;
}

void Odometry::RenewReferences(const FlowImage& image) {
  const int keyframe = static_cast<int>(map_.keyframes.size()) - 1;
  for (FeatureTrack& track : tracks_) {
    if (!map_.landmarks[track.landmark].valid) continue;
    const std::optional<Eigen::Matrix2d> current_from_reference =
        CurrentFromReference(map_, camera_, track, map_.keyframes[keyframe].camera_from_world);
    const double limit = options_.keyframes.max_growth * options_.keyframes.max_growth;
    if (!current_from_reference || current_from_reference->determinant() < limit) continue;
    track.reference_image = image.gray;
    track.reference_pixel = track.pixel;
    track.reference_keyframe = keyframe;
  }
}

void Odometry::DetectNewFeatures(const FlowImage& image) {
  const int keyframe = static_cast<int>(map_.keyframes.size()) - 1;
  for (const cv::Point2f& corner : DetectCorners(options_.corners, image.gray, PixelsOf(tracks_))) {
    const std::optional<Eigen::Vector2d> undistorted = camera_.Undistort({corner.x, corner.y});
    if (!undistorted) continue;
    const int landmark = static_cast<int>(map_.landmarks.size());
    map_.landmarks.push_back({});
    AddObservation(map_, keyframe, landmark, *undistorted);
    tracks_.push_back({landmark, corner, *undistorted, *undistorted, image.gray, corner, keyframe, keyframe});
  }
}

FrameResult Odometry::Record(const FrameResult& result, const RigidTransform& camera_from_world) {
  return Record(result, static_cast<int>(map_.keyframes.size()) - 1, camera_from_world);
}

FrameResult Odometry::Record(FrameResult result, int keyframe, const RigidTransform& camera_from_world) {
  result.world_from_camera = camera_from_world.inverse();
  result.scale_state = scale_.state();
  result.scale_sigma = scale_.sigma();
  history_.Add(result, map_, keyframe, camera_from_world);
  return result;
}

std::vector<FrameResult> Odometry::RefinedFrames() const {
  std::vector<FrameResult> frames = history_.Refined(map_);
  scale_.Annotate(map_, history_.Keyframes(), frames);
  return frames;
}

std::vector<TurnResult> Odometry::Turns() const { return scale_.Turns(map_); }

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/odometry/odometry.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <opencv2/core/utility.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/frame_interval.h"
#include "turnscale/base/number_text.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/features/corners.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/landmarks.h"
#include "turnscale/mapping/local_bundle_adjustment.h"
#include "turnscale/mapping/map_scaling.h"
#include "turnscale/mapping/section_adjustment.h"
#include "turnscale/mapping/unit_variance.h"
#include "turnscale/odometry/constrained_turns.h"
#include "turnscale/odometry/map_start.h"
#include "turnscale/odometry/path_gaps.h"
#include "turnscale/odometry/refined_drive.h"

namespace turnscale {
namespace {

// A correction that moves the pixels at a wide image's edge by a fortieth of a pixel. Applying one takes up to 10 ms.
constexpr double kLeastLensChange = 5e-5;
// A change of the lens correction by which a turn's scale changes by some per cent: poses adjusted under another one
// are adjusted anew when the next turn ends.
constexpr double kStaleLensChange = 2e-3;
// Keyframes that go to the archive together, at least.
constexpr int kLeastArchived = 20;
// Landmarks of a few hundred keyframes, which is about what the map holds before it is archived. To move that many
// takes longer than a frame.
constexpr int kUsualLandmarks = 1 << 17;

// A turn in which static features show in several keyframes, degrees: if they were none, what stood still before was
// far away.
constexpr double kDecidingTurn = 10;

// Keyframes that follow one before it is judged how well landmarks determine the unit of length there.
constexpr int kKeyframesOfUnit = 10;

// Keyframes that are added between the start of work and the use of its results. In a turn, where they are close to one
// another, camera work takes about as long as two of them, a large window as four.
constexpr int kKeyframesOfCameraWork = 4;
constexpr int kKeyframesOfReadjustment = 6;

OdometryOptions Checked(OdometryOptions options, const CameraModel& camera) {
  options.Check();
  if ((camera.width == 0) != (camera.height == 0))
    throw InputError("camera: has a width or a height without the other");
  const Pinhole& pinhole = camera.pinhole;
  if (!(pinhole.fx > 0 && pinhole.fy > 0 && std::isfinite(pinhole.fx + pinhole.fy + pinhole.cx + pinhole.cy)))
    throw InputError("camera: fx and fy have to be above 0, and cx and cy finite, in pixels");
  // The radial correction grows with the tangent of the angle, which has no bound on a fisheye.
  if (camera.lens == LensModel::kEquidistant) options.lens.enabled = false;
  // Intrinsics estimated from a drive are not exact.
  if (camera.focal_sigma > 0) options.lens.accurate_share = 0;
  return options;
}

}  // namespace

Odometry::Odometry(const OdometryOptions& options, const CameraModel& camera)
    : options_(Checked(options, camera)),
      mask_(options_.static_regions),
      initializer_(std::in_place, options_, camera),
      tracker_(options_),
      motion_(options_.motion),
      lens_(options_.lens),
      calibration_check_(options_.calibration_check),
      road_(options_.road),
      scale_(options_) {
  map_.camera = camera;
  map_.landmarks.reserve(kUsualLandmarks);
  calibration_sigma_ = CalibrationSigma({}, camera);
}

FrameResult Odometry::Process(const cv::Mat& gray, double time) {
  Ensure(!finished_, "no frame follows Finish");
  CheckTime(time);
  CheckImage(gray);
  const double interval = time - seen_time_;
  FrameResult result = NewFrame(time, TrackingState::kInitializing);
  const FlowImage image = BuildFlowImage(options_.flow, gray);
  if (!mapping()) return Initialize(image, result);

  const RigidTransform predicted = motion_.Predict(time);
  if (time - motion_.time() <= options_.repeats.max_seconds &&
      tracker_.IsRepeat(map_, map_.camera, image, predicted, interval)) {
    result.state = TrackingState::kRepeated;
    seen_time_ = time;
    return MetricResult(result, predicted);
  }
  const TrackedFrame tracked = Track(image, predicted, result);
  if (!tracked.camera_from_world) return Bridge(predicted, result);
  if (!tracker_.NeedsKeyframe(map_, tracked)) return MetricResult(result, *tracked.camera_from_world);

  // They depend on the image alone, so that they are found while the map is adjusted.
  std::future<std::vector<cv::KeyPoint>> corners =
      InBackground([&] { return FindCandidates(options_.corners, image.gray, image.dark); });
  ApplyBackgroundWork();
  AddKeyframe(result);
  result.keyframe = true;
  // The road's observer reads only poses and gaps of keyframes, which adding features does not change.
  std::future<std::optional<MeasuredHeight>> height = InBackground([&] { return ObserveRoad(image); });
  tracker_.Replenish(map_.camera, image, corners.get(), map_);
  ObserveScale(height.get());
  const TurningMotion motion = StepMotion(map_, static_cast<int>(map_.keyframes.size()) - 2, mount());
  result.psi = motion.psi;
  result.theta = motion.theta;
  StartReadjustment();
  StartCameraWork();
  return MetricResult(result, map_.keyframes.back().camera_from_world);
}

void Odometry::CheckTime(double time) const {
  if (!std::isfinite(time)) throw InputError("time " + std::to_string(time) + " s: has to be a finite number");
  if (!(time > last_time_)) throw InputError("time " + std::to_string(time) + " s: has to be after the frame before");
  constexpr int kFewestFrames = 8;
  const double least_interval = std::min(least_interval_, time - last_time_);
  if (frames_ >= kFewestFrames && least_interval > kLongestFrameInterval)
    throw InputError("time " + std::to_string(time) + " s: all frames so far are " + NumberText(least_interval) +
                     " s apart or more; are the times milliseconds or nanoseconds? Give seconds");
}

void Odometry::CheckImage(const cv::Mat& gray) {
  // One that could not be read has the type of a gray one, and no size for the camera.
  if (gray.empty()) throw InputError("image: is empty; where an image cannot be read, call ProcessUnreadable");
  if (gray.type() != CV_8UC1) throw InputError("image: has to be 8-bit gray");
  if (map_.camera.width != 0 && gray.size() != cv::Size(map_.camera.width, map_.camera.height))
    throw InputError("image: is " + std::to_string(gray.cols) + "x" + std::to_string(gray.rows) + ", the camera has " +
                     std::to_string(map_.camera.width) + "x" + std::to_string(map_.camera.height));
  if (mask_.size() == gray.size()) return;
  mask_.SetSize(gray.size());
  // Not every camera file has the image size; the first image that fits the mask has it.
  map_.camera.width = gray.cols;
  map_.camera.height = gray.rows;
  ApplyMask();
  WaitForMap();
}

void Odometry::SetMask(const cv::Mat& mask) {
  Ensure(mask_.size().empty(), "a mask is set before the first image");
  if (mask.empty() || mask.type() != CV_8UC1) throw InputError("mask: has to be an 8-bit gray image");
  if (cv::countNonZero(mask) == 0) throw InputError("mask: leaves out all pixels");
  mask_.SetGiven(mask);
}

void Odometry::ApplyMask() { tracker_.SetMask(mask_.pixels()); }

void Odometry::WaitForMap() { initializer_.emplace(options_, map_.camera, mask_.pixels()); }

FrameResult Odometry::NewFrame(double time, TrackingState state) {
  least_interval_ = std::min(least_interval_, time - last_time_);
  last_time_ = time;
  FrameResult result;
  result.frame = frames_++;
  result.time = time;
  result.state = state;
  return result;
}

FrameResult Odometry::ProcessUnreadable(double time) {
  Ensure(!finished_, "no frame follows Finish");
  CheckTime(time);
  const FrameResult result = NewFrame(time, TrackingState::kUnreadable);
  if (map_.keyframes.empty()) {
    history_.AddWithoutPose(result);
    return result;
  }
  return Bridge(motion_.Predict(time), result);
}

void Odometry::Finish() {
  if (std::exchange(finished_, true) || map_.keyframes.empty()) return;
  Readjust();
  Archive(static_cast<int>(map_.keyframes.size()));
  if (is_upside_down()) scale_.ForgetHeights();
  AdjustWholeDrive();
  refined_ = Refined();
  const bool follows_turns = refined_->estimate && refined_->estimate->fell_back;
  if (options_.scale.method != ScaleMethod::kSmoothed || follows_turns) ConstrainTurnsOfDrive();
}

FrameResult Odometry::Initialize(const FlowImage& image, FrameResult result) {
  const std::optional<InitialMap> start = initializer_->Add(image, result.frame, result.time);
  result.tracked = initializer_->tracked();
  if (map_.keyframes.empty())
    history_.AddWithoutPose(result);
  else
    result = Bridge(motion_.Predict(result.time), result);
  if (!start) return result;
  // Replaces what the history has of this frame and of those that waited with it.
  StartMap(image, *start);
  ObserveRoad(image);  // shows nothing yet; the next keyframe is compared with it
  result.state = TrackingState::kTracked;
  result.inliers = start->CountPoints();
  result.keyframe = true;
  return MetricResult(result, map_.keyframes.back().camera_from_world);
}

void Odometry::StartMap(const FlowImage& image, const InitialMap& start) {
  const bool continues = !map_.keyframes.empty();
  StartPlace place;
  place.after_gap = continues;
  if (continues) {
    place.first_from_world = motion_.Predict(start.frames.front().time);
    place.unit = UnitAfterGap(options_.tracking, map_, motion_, start);
  }
  AddedStart added = AddStart(start, place, map_);
  tracker_.Start(image, std::move(added.tracks), start.CountPoints());
  mask_.LeaveOut(start.motion);
  start_in_doubt_ = start.has_still_features ? std::optional(added.keyframe) : std::nullopt;
  ApplyMask();
  initializer_.reset();
  lost_frames_ = 0;
  seen_time_ = start.frames.back().time;
  scale_.Add(map_);
  for (const LocatedFrame& frame :
       LocateWaitingFrames(options_, map_.camera, start, map_, added.keyframe, added.first_landmark, motion_))
    MetricResult(frame.result, added.keyframe, frame.camera_from_world);
}

TrackedFrame Odometry::Track(const FlowImage& image, const RigidTransform& predicted, FrameResult& result) {
  TrackedFrame tracked = tracker_.Track(map_, map_.camera, image, motion_, predicted, result.time);
  result.tracked = tracked.tracked;
  result.inliers = tracked.inliers;
  if (!tracked.camera_from_world) return tracked;
  result.state = TrackingState::kTracked;
  lost_frames_ = 0;
  seen_time_ = result.time;
  motion_.Update(result.time, *tracked.camera_from_world);
  return tracked;
}

FrameResult Odometry::Bridge(const RigidTransform& predicted, FrameResult result) {
  const bool is_unreadable = result.state == TrackingState::kUnreadable;
  if (!is_unreadable) result.state = TrackingState::kBridged;
  const TrackingOptions& limits = options_.tracking;
  const bool stood = mapping() && tracker_.HasStood();
  // Without an image the map is no more lost than where images are missing.
  if (mapping() && !is_unreadable) ++lost_frames_;
  const double patience = stood ? limits.max_hidden_seconds : limits.max_lost_seconds;
  const bool gives_up = mapping() && lost_frames_ >= limits.min_lost_frames && result.time - motion_.time() > patience;
  if (!gives_up) return MetricResult(result, stood ? motion_.last() : predicted);
  // No turn reaches across the gap: one that was under way is read from the map it belongs to. What is pending may
  // change the radial correction, under which the pixels that wait for the next map are undistorted.
  Readjust();
  // The noise of standing is no motion.
  if (stood) motion_.Stop();
  const RigidTransform last = motion_.Predict(result.time);
  WaitForMap();
  return MetricResult(result, last);
}

void Odometry::AddKeyframe(const FrameResult& result) {
  const RigidTransform camera_from_world = motion_.last();
  const int keyframe = static_cast<int>(map_.keyframes.size());
  mask_.Observe(tracker_.DropStatic(map_, camera_from_world));
  ApplyMask();
  map_.keyframes.push_back({result.frame, result.time, camera_from_world, {}, false});
  for (const FeatureTrack& track : tracker_.tracks()) AddObservation(map_, keyframe, track.landmark, track.undistorted);
  if (start_in_doubt_ && InDegrees(TurnBetween(map_, *start_in_doubt_, keyframe)) > kDecidingTurn)
    start_in_doubt_.reset();
  TriangulateLandmarks(options_.landmarks, LandmarksOfScene(), map_);
  const LocalBundleResult adjusted = AdjustLocalWindow(options_.local_bundle, map_);
  tracker_.Drop(CullLandmarks(options_.landmarks, adjusted.landmarks, keyframe, map_));
  JudgeUnits();
  motion_.Correct(map_.keyframes.back().camera_from_world, 1.0);
}

std::vector<int> Odometry::LandmarksOfScene() const {
  // Where parts of the image stand still, what has not moved so far may belong to them, even if its rays meet.
  const bool in_doubt = start_in_doubt_ || !mask_.pixels().empty();
  std::vector<int> landmarks;
  for (const FeatureTrack& track : tracker_.tracks()) {
    const Landmark& landmark = map_.landmarks[track.landmark];
    if (!in_doubt || !HasStayed(landmark, track.undistorted, options_.static_regions.max_motion))
      landmarks.push_back(track.landmark);
  }
  return landmarks;
}

void Odometry::JudgeUnits() {
  for (; unit_judged_ + kKeyframesOfUnit < static_cast<int>(map_.keyframes.size()); ++unit_judged_)
    map_.keyframes[unit_judged_].pixel_unit_variance = UnitVariance(map_, unit_judged_, kKeyframesOfUnit).value_or(0.0);
}

std::optional<MeasuredHeight> Odometry::ObserveRoad(const FlowImage& image) {
  return road_.Observe(map_, map_.camera, mount().current().vehicle_from_camera, image, mask_.pixels());
}

void Odometry::ObserveScale(const std::optional<MeasuredHeight>& height) {
  if (height) scale_.AddHeight(*height);
  const bool turn_ended = scale_.Add(map_);
  motion_.SetVertical(mount().current().vehicle_from_camera.conjugate() * Eigen::Vector3d::UnitY());
  const int not_readjusted = static_cast<int>(map_.keyframes.size() - lens_of_keyframe_.size());
  const bool many = !readjustment_.pending() && not_readjusted >= options_.turn_bundle.window / 2;
  readjustment_is_due_ = readjustment_is_due_ || turn_ended || many;
}

void Odometry::StartReadjustment() {
  // The archive takes its keyframes first: it renumbers the landmarks, by whose numbers the window is written back.
  if (!readjustment_is_due_ || readjustment_.pending() || archive_due_ > archive_.end()) return;
  readjustment_is_due_ = false;
  readjustment_.Start(static_cast<int>(map_.keyframes.size()) + kKeyframesOfReadjustment,
                      [options = options_.turn_bundle, work = NextReadjustment()]() mutable {
                        return Readjusted(options, std::move(work));
                      });
}

void Odometry::StartCameraWork() {
  if (camera_work_.pending()) return;
  std::optional<IntrinsicsProblem> refined = lens_.Window(map_);
  std::optional<IntrinsicsProblem> tested = calibration_check_.Window(map_);
  if (!refined && !tested) return;
  camera_work_.Start(static_cast<int>(map_.keyframes.size()) + kKeyframesOfCameraWork,
                     [this, refined = std::move(refined), tested = std::move(tested), camera = map_.camera]() mutable {
                       CameraWork work;
                       if (refined && lens_.Read(*refined)) {
                         work.lens_correction = lens_.correction();
                         camera.radial_correction = lens_.correction();
                       }
                       if (tested) calibration_check_.Read(*tested);
                       if (calibration_check_.windows() > 0)
                         work.calibration_sigma = CalibrationSigma(calibration_check_.Contradictions(camera), camera);
                       return work;
                     });
}

void Odometry::ApplyBackgroundWork() {
  const int keyframes = static_cast<int>(map_.keyframes.size());
  ArchiveNextPart();
  if (std::optional<ReadjustmentWork> readjusted = readjustment_.TakeIfDue(keyframes))
    ApplyReadjusted(*std::move(readjusted));
  const std::optional<CameraWork> work = camera_work_.TakeIfDue(keyframes);
  if (!work) return;
  if (work->calibration_sigma) calibration_sigma_ = *work->calibration_sigma;
  if (work->lens_correction && std::abs(*work->lens_correction - map_.camera.radial_correction) >= kLeastLensChange)
    CorrectLens(*work->lens_correction);
}

int Odometry::FirstToReadjust() const {
  const int keyframes = static_cast<int>(map_.keyframes.size());
  const auto is_up_to_date = [&](double correction) {
    return std::abs(correction - map_.camera.radial_correction) < kStaleLensChange;
  };
  const int oldest = std::max(archive_.end(), keyframes - options_.turn_bundle.window);
  const int readjusted = static_cast<int>(lens_of_keyframe_.size());
  if (oldest >= readjusted) return oldest;
  const auto first = std::find_if_not(lens_of_keyframe_.begin() + oldest, lens_of_keyframe_.end(), is_up_to_date);
  return static_cast<int>(first - lens_of_keyframe_.begin());
}

ReadjustmentWork Odometry::NextReadjustment() const {
  return WorkToReadjust(options_.turn_bundle, map_, mount(), FirstToReadjust());
}

void Odometry::ApplyReadjusted(ReadjustmentWork work) {
  const int keyframes = static_cast<int>(map_.keyframes.size());
  const int first = work.first;
  lens_of_keyframe_.resize(work.end, std::numeric_limits<double>::quiet_NaN());
  std::fill(lens_of_keyframe_.begin() + first, lens_of_keyframe_.end(), work.radial_correction);
  // Factors of length are means over two steps on either side.
  const int from = std::max(0, first - 2);
  const RigidTransform last_from_keyframe = LastFromKeyframe();
  const std::vector<Eigen::Vector3d> before = KeyframeCentres(map_, from);
  if (!work.window.landmarks.empty()) WriteBack(work.window, map_);
  FollowMap(from, KeyframeFactors(before, KeyframeCentres(map_, from), first - from, std::vector(before.size(), 1.0)),
            last_from_keyframe);
  const auto reach = [](const LocalBundleOptions& window) { return window.window + window.anchors; };
  const int last = keyframes - std::max({reach(options_.turn_bundle), reach(options_.local_bundle),
                                         options_.lens.window, options_.calibration_check.window, kKeyframesOfUnit});
  scale_.Reread(map_, std::move(work.mount), {.first = first, .end = work.end, .final_before = last});
  if (last - archive_.end() >= kLeastArchived) archive_due_ = last;
}

void Odometry::CorrectLens(double radial_correction) {
  const double before = map_.camera.radial_correction;
  turnscale::CorrectLens(map_, radial_correction);
  tracker_.Correct([&](const Eigen::Vector2d& pixel) {
    return ChangeRadialCorrection(map_.camera.pinhole, before, radial_correction, pixel);
  });
}

void Odometry::Readjust() {
  readjustment_is_due_ = false;
  readjustment_.Hurry();
  camera_work_.Hurry();
  ApplyBackgroundWork();
  ApplyReadjusted(Readjusted(options_.turn_bundle, NextReadjustment()));
}

void Odometry::ArchiveNextPart() {
  const int due = archive_due_ - archive_.end();
  if (due <= 0) return;
  const int parts = (due + MapArchive::kMostKeyframes - 1) / MapArchive::kMostKeyframes;
  Archive(archive_.end() + due / parts);
}

void Odometry::Archive(int last) {
  Ensure(!readjustment_.pending(), "landmarks are renumbered while a window is adjusted");
  tracker_.Reindex(archive_.Retire(last, map_));
}

void Odometry::AdjustWholeDrive() {
  // During the drive, earlier keyframes were fixed while later ones were adjusted. In long sections the scale drifts
  // less.
  const RigidTransform last_from_keyframe = LastFromKeyframe();
  const std::vector<Eigen::Vector3d> before = KeyframeCentres(map_);
  AdjustSections(options_.final_bundle, archive_, map_);
  FollowMap(0, KeyframeFactors(before, KeyframeCentres(map_), 0, std::vector(before.size(), 1.0)), last_from_keyframe);
  scale_.Reread(map_);
}

void Odometry::ConstrainTurnsOfDrive() {
  if (!refined_->estimate) return;
  const RigidTransform last_from_keyframe = LastFromKeyframe();
  ArchivedPart drive = archive_.Load(0, archive_.end(), map_);
  RefinedScale constrained = *refined_;
  const std::vector<double> factors = ConstrainTurns(options_, scale_.mount(), drive.map, constrained);
  archive_.Store(drive);
  refined_ = std::move(constrained);
  for (size_t k = 0; k < map_.keyframes.size(); ++k)
    map_.keyframes[k].camera_from_world = drive.map.keyframes[k].camera_from_world;
  FollowMap(0, factors, last_from_keyframe);
  // The recovered map has its predicted steps again.
  if (!factors.empty()) BridgeGapsOf(*refined_);
}

void Odometry::BridgeGapsOf(RefinedScale& refined) const {
  BridgeGaps(map_, history_.MeasuredEnds(map_), last_time_, refined);
}

RigidTransform Odometry::LastFromKeyframe() const {
  return motion_.last() * map_.keyframes.back().camera_from_world.inverse();
}

void Odometry::FollowMap(int first, const std::vector<double>& factors, RigidTransform last_from_keyframe) {
  if (factors.empty()) return;
  history_.Rescale(first, factors);
  road_.Rescale(factors.back());
  last_from_keyframe.translation *= factors.back();
  motion_.Correct(last_from_keyframe * map_.keyframes.back().camera_from_world, factors.back());
}

FrameResult Odometry::MetricResult(const FrameResult& result, const RigidTransform& camera_from_world) {
  return MetricResult(result, static_cast<int>(map_.keyframes.size()) - 1, camera_from_world);
}

FrameResult Odometry::MetricResult(FrameResult result, int keyframe, const RigidTransform& camera_from_world) {
  history_.Add(result, map_, keyframe, camera_from_world);
  result.world_from_camera = scale_.live_path().InMetres(map_, keyframe, camera_from_world.inverse());
  result.vehicle_from_camera = mount().current().vehicle_from_camera;
  result.scale_state = scale_.state();
  result.scale_sigma = std::hypot(scale_.sigma(), calibration_sigma_);
  return result;
}

ScaleState Odometry::scale_state() const { return refined_ ? StateAtEnd(*refined_) : scale_.state(); }

RefinedScale Odometry::Refined() const {
  if (refined_) return *refined_;
  camera_work_.Await();
  const std::vector<ParameterEstimate> contradictions = calibration_check_.Contradictions(map_.camera);
  RefinedScale refined = scale_.Refine(map_, !contradictions.empty());
  WidenForCalibration(contradictions, map_.camera, refined);
  refined.calibration_windows = calibration_check_.windows();
  BridgeGapsOf(refined);
  return refined;
}

std::vector<FrameResult> Odometry::RefinedFrames(const RefinedScale& refined) const {
  return RefinedFramesOf(history_, map_, mount(), refined);
}

MapPoints Odometry::RefinedMap(const RefinedScale& refined) const {
  return RefinedPointsOf(archive_, map_, refined.path);
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/odometry/odometry.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <optional>
#include <string>
#include <utility>

#include <opencv2/core/utility.hpp>

#include "turnscale/base/error.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/features/corners.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/landmarks.h"
#include "turnscale/mapping/local_bundle_adjustment.h"
#include "turnscale/mapping/map_scaling.h"
#include "turnscale/mapping/rolling_shutter.h"
#include "turnscale/mapping/section_adjustment.h"
#include "turnscale/odometry/constrained_turns.h"
#include "turnscale/odometry/drive_steps.h"
#include "turnscale/odometry/gap_rotation.h"
#include "turnscale/odometry/image_contrast.h"
#include "turnscale/odometry/map_start.h"
#include "turnscale/odometry/path_gaps.h"
#include "turnscale/odometry/refined_drive.h"

namespace turnscale {
namespace {

// Landmarks of a few hundred keyframes, which is about what the map holds before it is archived. To move that many
// takes longer than a frame.
constexpr int kUsualLandmarks = 1 << 17;

// A turn in which static features show in several keyframes, degrees: if they were none, what stood still before was
// far away.
constexpr double kDecidingTurn = 10;

// Of an image that shows nothing, gray levels.
constexpr double kNoContrast = 1;

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
      loss_(options_.tracking),
      upkeep_(options_),
      camera_refinement_(options_, camera),
      road_(options_.road),
      scale_(options_, camera.aspect_sigma) {
  map_.camera = camera;
  map_.landmarks.reserve(kUsualLandmarks);
}

FrameResult Odometry::Process(const cv::Mat& gray, double time) {
  Ensure(!finished_, "no frame follows Finish");
  frame_counter_.Check(time);
  CheckImage(gray);
  FrameResult result = NewFrame(time, TrackingState::kInitializing);
  if (waits_for_map()) return Initialize(BuildFlowImage(options_.flow, gray), result);
  FlowImage image = CopyFlowImage(options_.flow, gray);
  if (tracker_.ShowsSamePixels(image)) loss_.AddSamePixels(time);

  const RigidTransform predicted = motion_.Predict(time);
  const ImageTiming timing = {.since_measured = time - motion_.last_measured_time(),
                              .interval = time - loss_.last_seen_time()};
  if (tracker_.IsRepeat(map_, image, predicted, timing)) {
    result.state = TrackingState::kRepeated;
    loss_.AddRepeat(time);
    return MetricResult(result, predicted);
  }
  const TrackedFrame tracked = Track(image, predicted, result);
  if (!tracked.camera_from_world) return Bridge(predicted, result);
  if (!tracker_.NeedsKeyframe(map_, tracked)) return MetricResult(result, *tracked.camera_from_world);

  const std::optional<MeasuredHeight> height = ExtendMap(image, result);
  const bool turn_ended = ObserveScale(height, result);
  StartBackgroundWork(turn_ended);
  return MetricResult(result, map_.keyframes.back().camera_from_world);
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
  WaitForMap();
}

void Odometry::SetMask(const cv::Mat& mask) {
  Ensure(mask_.size().empty(), "a mask is set before the first image");
  if (mask.empty() || mask.type() != CV_8UC1) throw InputError("mask: has to be an 8-bit gray image");
  if (cv::countNonZero(mask) == 0) throw InputError("mask: leaves out all pixels");
  mask_.SetGiven(mask);
}

void Odometry::WaitForMap() {
  const bool is_given = options_.vehicle.camera_known || !options_.vehicle.calibrate_camera;
  const Mount& current = mount().current();
  // If the camera seems to look aside, a vehicle may have been taken for the scene, with whose direction of travel no
  // map would start any more.
  const bool is_known = is_given || (current.found && LooksAlong(current.vehicle_from_camera));
  const auto rotation = is_known ? std::optional(current.vehicle_from_camera) : std::nullopt;
  initializer_.emplace(options_, map_.camera, rotation);
}

FrameResult Odometry::NewFrame(double time, TrackingState state) {
  FrameResult result;
  result.frame = frame_counter_.Add(time);
  result.time = time;
  result.state = state;
  history_.AddWithoutPose(result);
  return result;
}

FrameResult Odometry::ProcessUnreadable(double time) {
  Ensure(!finished_, "no frame follows Finish");
  frame_counter_.Check(time);
  const FrameResult result = NewFrame(time, TrackingState::kUnreadable);
  loss_.AddUnreadable();
  return map_.keyframes.empty() ? result : Bridge(motion_.Predict(time), result);
}

void Odometry::Finish() {
  if (std::exchange(finished_, true) || map_.keyframes.empty()) return;
  TakeJump(mount_jumps_.End());
  ForgetFrozenEnd();
  Readjust();
  tracker_.Reindex(upkeep_.ArchiveAll(map_));
  if (is_upside_down()) scale_.ForgetHeights();
  const std::optional<ShutterReadout> readout = calibration_check().Readout(map_.camera);
  map_.camera.readout = readout ? readout->seconds : 0;
  if (readout) map_.camera.read_direction = readout->direction;
  AdjustWholeDrive();
  refined_ = Refined();
  const bool uses_single_turns = refined_->estimate && refined_->estimate->uses_single_turns;
  if (options_.scale.method != ScaleMethod::kSmoothed || uses_single_turns) ConstrainTurnsOfDrive();
}

FrameResult Odometry::Initialize(const FlowImage& image, FrameResult result) {
  const std::optional<InitialMap> start = initializer_->Add(image, mask_.pixels(), result.frame, result.time);
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

StartPlace Odometry::PlaceAfterGap(const InitialMap& start) const {
  const GapImages images = {.before = tracker_.latest_gray(),
                            .lost = loss_.first_lost(),
                            .after = start.first_image,
                            .earlier = turned_views_.Before(map_, motion_.last().rotation),
                            .car_stood = tracker_.HasStood() && BeginsAtStandstill(options_.static_regions, start)};
  const auto rotation =
      MeasureGapRotation(options_.gap_rotation, map_.camera, images, mask_.pixels(), mount().current());
  const bool is_metric = scale_.state() != ScaleState::kPending;
  const auto metres_per_unit = is_metric ? std::optional(scale_.live_path().metres_per_unit.back()) : std::nullopt;
  StartPlace place;
  place.after_gap = true;
  place.predicted = PredictStart(motion_, start, rotation, metres_per_unit);
  if (!images.lost.empty())
    place.contrast_left =
        ContrastOf(images.lost, mask_.pixels()) / std::max(ContrastOf(images.before, mask_.pixels()), kNoContrast);
  place.unit = UnitAfterGap(options_.tracking, map_, motion_, start);
  return place;
}

void Odometry::StartMap(const FlowImage& image, const InitialMap& start) {
  const StartPlace place = map_.keyframes.empty() ? StartPlace{} : PlaceAfterGap(start);
  const AddedStart added = AddStart(start, place, map_);
  tracker_.Start(image, added.tracks, start.CountPoints());
  mask_.LeaveOut(start.motion);
  turned_views_.Clear();
  start_in_doubt_ = start.has_still_features ? std::optional(added.keyframe) : std::nullopt;
  initializer_.reset();
  loss_.AddTracked(start.frames.back().time);
  scale_.Add(map_);
  for (const LocatedFrame& frame : LocateWaitingFrames(options_, start, added, map_, motion_))
    MetricResult(frame.result, added.keyframe, frame.camera_from_world);
}

TrackedFrame Odometry::Track(FlowImage& image, const RigidTransform& predicted, FrameResult& result) {
  TrackedFrame tracked = tracker_.Track(map_, mask_.pixels(), image, motion_, predicted, result.time);
  result.tracked = tracked.tracked;
  result.inliers = tracked.inliers;
  if (!tracked.camera_from_world) {
    loss_.AddLost(image.gray);
    return tracked;
  }
  result.state = TrackingState::kTracked;
  const bool after_repeats = loss_.AddTracked(result.time);
  ObserveMount(result, *tracked.camera_from_world);
  motion_.Update(result.time, *tracked.camera_from_world, after_repeats);
  return tracked;
}

void Odometry::ObserveMount(const FrameResult& result, const RigidTransform& camera_from_world) {
  TakeJump(mount_jumps_.Add(result.frame, result.time, motion_.last() * camera_from_world.inverse(),
                            mount().current().vehicle_from_camera.conjugate() * Eigen::Vector3d::UnitY()));
}

void Odometry::TakeJump(const std::optional<MountJump>& jump) {
  if (!jump) return;
  const auto keyframe = std::ranges::lower_bound(map_.keyframes, jump->first_frame, {}, &Keyframe::frame);
  scale_.AddJump(map_, static_cast<int>(keyframe - map_.keyframes.begin()), *jump);
  // Between images before and after it, the camera turns otherwise than the car.
  road_.Restart();
}

FrameResult Odometry::Bridge(const RigidTransform& predicted, FrameResult result) {
  if (result.state != TrackingState::kUnreadable) result.state = TrackingState::kBridged;
  if (waits_for_map()) return MetricResult(result, predicted);
  const bool stood = tracker_.HasStood();
  if (!loss_.GivesUp(motion_, stood, result.time)) return MetricResult(result, stood ? motion_.last() : predicted);
  GiveUpMap(result.time);
  return MetricResult(result, motion_.Predict(result.time));
}

void Odometry::GiveUpMap(double time) {
  // No turn reaches across the gap: one that was under way is read from the map it belongs to. What is pending may
  // change the radial correction, under which the pixels that wait for the next map are undistorted.
  TakeJump(mount_jumps_.End());
  Readjust();
  // The view does not come back: images that repeated the last one, or stood still, were frozen while the car drove on.
  const std::optional<double> frozen_since = FrozenSince(motion_, time);
  history_.ForgetMeasured(frozen_since.value_or(motion_.last_measured_time()));
  if (frozen_since) {
    motion_.GoOn();
  } else if (tracker_.HasStood()) {
    // The noise of standing is no motion.
    motion_.Stop();
  }
  WaitForMap();
}

void Odometry::ForgetFrozenEnd() {
  if (waits_for_map()) return;
  if (const auto since = loss_.FrozenAtEnd(motion_, frame_counter_.last_frame_time())) history_.ForgetMeasured(*since);
}

void Odometry::AddKeyframe(const FrameResult& result) {
  const RigidTransform camera_from_world = motion_.last();
  const int keyframe = CountKeyframes(map_);
  mask_.Observe(tracker_.DropStatic(map_, camera_from_world));
  map_.keyframes.push_back(
      {.frame = result.frame, .time = result.time, .camera_from_world = camera_from_world, .observations = {}});
  for (const FeatureTrack& track : tracker_.tracks()) AddObservation(map_, keyframe, track.landmark, track.undistorted);
  if (start_in_doubt_ && InDegrees(TurnBetween(map_, *start_in_doubt_, keyframe)) > kDecidingTurn)
    start_in_doubt_.reset();
  TriangulateLandmarks(options_.landmarks, LandmarksOfScene(), map_);
  const LocalBundleResult adjusted = AdjustLocalWindow(options_.local_bundle, map_);
  failed_adjustments_ += adjusted.failed ? 1 : 0;
  tracker_.Drop(CullLandmarks(options_.landmarks, adjusted.landmarks, keyframe, map_));
  upkeep_.JudgeUnits(map_);
  mount_jumps_.CorrectLast(camera_from_world * map_.keyframes.back().camera_from_world.inverse());
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

std::optional<MeasuredHeight> Odometry::ObserveRoad(const FlowImage& image) {
  return road_.Observe(map_, mount().current().vehicle_from_camera, image, mask_.pixels());
}

std::optional<MeasuredHeight> Odometry::ExtendMap(const FlowImage& image, FrameResult& result) {
  // Candidates for new features depend on the image alone: they are found while the map is adjusted.
  std::future<std::vector<cv::KeyPoint>> corners =
      InBackground([&] { return FindCandidates(options_.corners, image.gray, image.dark); });
  ApplyBackgroundWork();
  AddKeyframe(result);
  result.keyframe = true;
  // The road's observer reads only the camera, and poses and gaps of keyframes, which adding features does not change.
  std::future<std::optional<MeasuredHeight>> height = InBackground([&] { return ObserveRoad(image); });
  tracker_.Replenish(image, mask_.pixels(), corners.get(), map_);
  turned_views_.Add(map_, image.gray);
  return height.get();
}

bool Odometry::ObserveScale(const std::optional<MeasuredHeight>& height, FrameResult& result) {
  if (height) scale_.AddHeight(*height);
  const bool turn_ended = scale_.Add(map_);
  motion_.SetVertical(mount().current().vehicle_from_camera.conjugate() * Eigen::Vector3d::UnitY());
  const TurningMotion motion = StepMotion(map_, CountKeyframes(map_) - 2, mount());
  result.psi = motion.psi;
  result.theta = motion.theta;
  return turn_ended;
}

void Odometry::StartBackgroundWork(bool turn_ended) {
  upkeep_.StartReadjustmentIfDue(map_, mount(), turn_ended);
  camera_refinement_.StartIfDue(map_);
}

void Odometry::ApplyBackgroundWork() {
  if (const std::optional<std::vector<int>> new_index = upkeep_.ArchiveNextPart(map_)) tracker_.Reindex(*new_index);
  const RigidTransform last_from_keyframe = LastFromKeyframe();
  if (std::optional<AppliedReadjustment> applied = upkeep_.ApplyIfDue(map_))
    FollowReadjustment(*std::move(applied), last_from_keyframe);
  if (const std::optional<double> correction = camera_refinement_.TakeIfDue(map_)) CorrectLens(*correction);
}

void Odometry::FollowReadjustment(AppliedReadjustment applied, const RigidTransform& last_from_keyframe) {
  failed_adjustments_ += applied.failed ? 1 : 0;
  FollowMap(applied.keyframes.first, applied.factors, last_from_keyframe);
  scale_.Reread(map_, std::move(applied.mount), applied.keyframes);
}

void Odometry::CorrectLens(double radial_correction) {
  const double before = map_.camera.radial_correction;
  turnscale::CorrectLens(map_, radial_correction);
  tracker_.Correct([&](const Eigen::Vector2d& undistorted) {
    return ChangeRadialCorrection(map_.camera.pinhole, before, radial_correction, undistorted);
  });
}

void Odometry::Readjust() {
  upkeep_.Hurry();
  camera_refinement_.Hurry();
  ApplyBackgroundWork();
  const RigidTransform last_from_keyframe = LastFromKeyframe();
  FollowReadjustment(upkeep_.ReadjustNow(mount(), map_), last_from_keyframe);
}

void Odometry::AdjustWholeDrive() {
  // During the drive, earlier keyframes were fixed while later ones were adjusted. In long sections the scale drifts
  // less.
  const RigidTransform last_from_keyframe = LastFromKeyframe();
  const std::vector<Eigen::Vector3d> before = KeyframeCentres(map_);
  failed_adjustments_ += AdjustSections(options_.final_bundle, upkeep_.archive(), map_);
  FollowMap(0, KeyframeFactors(before, KeyframeCentres(map_), 0, std::vector(before.size(), 1.0)), last_from_keyframe);
  scale_.Reread(map_);
}

void Odometry::ConstrainTurnsOfDrive() {
  if (!refined_->estimate) return;
  const RigidTransform last_from_keyframe = LastFromKeyframe();
  MapArchive& archive = upkeep_.archive();
  ArchivedPart drive = archive.Load(0, archive.end(), map_);
  CorrectRows(drive.map);
  RefinedScale constrained = *refined_;
  const std::vector<double> factors = ConstrainTurns(options_, scale_.mount(), drive.map, constrained);
  if (const double difference = DifferenceFromInterpolated(map_, constrained, *refined_); difference > 0) {
    // As a fallback, the scale of each turn is kept, and interpolated between them.
    if (options_.scale.method == ScaleMethod::kSmoothed) return;
    constrained.estimate->length_sigma = std::hypot(constrained.estimate->length_sigma, difference);
  }
  archive.Store(drive);
  refined_ = std::move(constrained);
  for (size_t k = 0; k < map_.keyframes.size(); ++k)
    map_.keyframes[k].camera_from_world = drive.map.keyframes[k].camera_from_world;
  FollowMap(0, factors, last_from_keyframe);
  // The recovered map has its predicted steps again.
  if (!factors.empty()) BridgeGapsOf(*refined_);
}

void Odometry::BridgeGapsOf(RefinedScale& refined) const {
  BridgeGaps(map_, history_.MeasuredEnds(map_), frame_counter_.last_frame_time(), refined);
}

RigidTransform Odometry::LastFromKeyframe() const {
  return motion_.last() * map_.keyframes.back().camera_from_world.inverse();
}

void Odometry::FollowMap(int first, const std::vector<double>& factors, RigidTransform last_from_keyframe) {
  if (factors.empty()) return;
  history_.Rescale(first, factors);
  tracker_.Rescale(factors.back());
  mount_jumps_.Rescale(factors.back());
  road_.Rescale(factors.back());
  last_from_keyframe.translation *= factors.back();
  motion_.Correct(last_from_keyframe * map_.keyframes.back().camera_from_world, factors.back());
}

FrameResult Odometry::MetricResult(const FrameResult& result, const RigidTransform& camera_from_world) {
  return MetricResult(result, CountKeyframes(map_) - 1, camera_from_world);
}

FrameResult Odometry::MetricResult(FrameResult result, int keyframe, const RigidTransform& camera_from_world) {
  history_.Add(result, map_, keyframe, camera_from_world);
  result.world_from_camera = scale_.live_path().InMetres(map_, keyframe, camera_from_world.inverse());
  result.vehicle_from_camera = mount().current().vehicle_from_camera;
  result.scale_state = scale_.state();
  result.scale_sigma = std::hypot(scale_.sigma(), camera_refinement_.scale_sigma());
  return result;
}

ScaleState Odometry::scale_state() const { return refined_ ? StateAtEnd(*refined_) : scale_.state(); }

RefinedScale Odometry::Refined() const {
  if (refined_) return *refined_;
  const CalibrationCheck check = calibration_check();
  RefinedScale refined = scale_.Refine(map_, check.Verdict(map_.camera));
  WidenForCalibration(check.Contradictions(map_.camera), check.Doubts(map_.camera), map_.camera, refined);
  refined.calibration_windows = check.windows();
  refined.calibration_in_doubt = check.windows() > 0 && refined.contradicted_calibration.empty() &&
                                 (!refined.doubtful_calibration.empty() || !check.DeterminesFocalLength());
  refined.aspect_sigma = map_.camera.aspect_sigma;
  refined.contradicted_readout = check.ContradictedReadout(map_.camera);
  refined.readout = check.Readout(map_.camera);
  if (refined.readout) refined.readout->is_corrected = finished_ && map_.camera.readout != 0;
  BridgeGapsOf(refined);
  return refined;
}

std::vector<FrameResult> Odometry::RefinedFrames(const RefinedScale& refined) const {
  return RefinedFramesOf(history_, map_, mount(), refined);
}

MapPoints Odometry::RefinedMap(const RefinedScale& refined) const {
  return RefinedPointsOf(upkeep_.archive(), map_, refined.path);
}

}  // namespace turnscale

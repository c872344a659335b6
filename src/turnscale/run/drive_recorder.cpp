// SPDX-License-Identifier: MIT
#include "turnscale/run/drive_recorder.h"

#include <chrono>
#include <utility>

#include "turnscale/geometry/rotation.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/run/frame_warnings.h"
#include "turnscale/run/full_size.h"

namespace turnscale {
namespace {

CameraSummary CameraOf(const Odometry& odometry, const ImageScaling& scaling) {
  const CameraModel camera = scaling.Full(odometry.camera());
  CameraSummary summary = {.pinhole = camera.pinhole, .lens_model = camera.lens, .correction = {}};
  if (odometry.options().lens.enabled) summary.correction = {odometry.lens().correction(), odometry.lens().sigma()};
  return summary;
}

// Their angles are those of the final rotations, where these were found.
std::vector<MountMove> MovesOf(const MountCalibration& calibration) {
  const std::vector<Mount>& mounts = calibration.mounts();
  std::vector<MountMove> moves;
  for (std::size_t i = 1; i < mounts.size(); ++i) {
    MountMove move = mounts[i].move;
    if (mounts[i - 1].found && mounts[i].found) {
      const Eigen::Vector3d by =
          VectorFromRotation(mounts[i].vehicle_from_camera * mounts[i - 1].vehicle_from_camera.conjugate());
      move.by = {by.y(), by.x(), 0};
    }
    moves.push_back(move);
  }
  return moves;
}

MountSummary MountOf(const Odometry& odometry) {
  const MountCalibration& calibration = odometry.mount();
  MountSummary summary = {.estimate = {}, .jumps = calibration.jumps()};
  if (!odometry.options().vehicle.calibrate_camera) return summary;
  const Mount mount = calibration.current();
  summary.estimate = {.angles = YawPitchRollFromRotation(mount.vehicle_from_camera),
                      .sigma = mount.sigma,
                      .found = mount.found,
                      .moves = MovesOf(calibration),
                      .is_outdated = !mount.found && calibration.moves() > 0};
  return summary;
}

std::vector<MapRestart> RestartsOf(const Map& map) {
  std::vector<MapRestart> restarts;
  for (const Keyframe& keyframe : map.keyframes)
    if (keyframe.after_gap)
      restarts.push_back({keyframe.frame, keyframe.time, keyframe.gap_sigma, keyframe.gap_turn_sigma,
                          keyframe.gap_turn_is_measured, keyframe.contrast_left});
  return restarts;
}

}  // namespace

FrameResult DriveRecorder::Process(const cv::Mat& gray, double time) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  FrameResult result = odometry_.Process(gray, time);
  latencies_.push_back(std::chrono::duration<double>(Clock::now() - start).count());
  image_size_ = gray.size();
  Keep(result);
  if (!tracks_) seen_.Add(gray, time, result.tracked);
  blended_.Add(gray, time);
  double_.Add(gray, time, MovedPoints(result));
  return result;
}

std::vector<MovedPoint> DriveRecorder::MovedPoints(const FrameResult& result) {
  std::vector<MovedPoint> points;
  if (result.state == TrackingState::kRepeated) return points;
  std::unordered_map<int, TrackedPixel> pixels;
  if (result.state == TrackingState::kTracked) {
    for (const FeatureTrack& track : odometry_.tracks()) {
      pixels[track.landmark] = {track.pixel, track.reference_pixel};
      const auto before = last_pixels_.find(track.landmark);
      if (before != last_pixels_.end() && before->second.reference == track.reference_pixel)
        points.push_back({before->second.pixel, track.pixel});
    }
  }
  last_pixels_ = std::move(pixels);
  return points;
}

FrameResult DriveRecorder::ProcessUnreadable(double time, const std::string& problem) {
  FrameResult result = odometry_.ProcessUnreadable(time);
  unreadable_.push_back({result.frame, problem});
  last_pixels_.clear();
  Keep(result);
  return result;
}

void DriveRecorder::Keep(const FrameResult& result) {
  ++frames_;
  if (frames_ == 1) first_time_ = result.time;
  last_time_ = result.time;
  tracks_ = tracks_ || result.world_from_camera;
  if (result.state == TrackingState::kRepeated) repeated_.push_back(result.frame);
  if (!live_metric_from_ && result.world_from_camera && result.scale_state != ScaleState::kPending)
    live_metric_from_ = result.time;
  RecordRotation(result.frame, last_time_, odometry_.mount().current(), rotations_);
}

void DriveRecorder::Finish() {
  // The turns of the end may have told more of the rotation, also where the final adjustment fails.
  const auto record = [this] {
    if (frames_ > 0) RecordRotation(frames_ - 1, last_time_, odometry_.mount().current(), rotations_);
  };
  try {
    odometry_.Finish();
  } catch (...) {
    record();
    throw;
  }
  record();
}

std::vector<std::string> DriveRecorder::TakeMoveWarnings() {
  const MountCalibration& mount = odometry_.mount();
  std::vector<std::string> warnings;
  if (mount.moves() > moves_)
    warnings.push_back(CameraMovedWarning(frames_ - 1, mount.mounts().back().move, first_time_));
  moves_ = mount.moves();
  const std::vector<MountJump> jumps = mount.jumps();
  for (; jumps_ < jumps.size(); ++jumps_) warnings.push_back(CameraJumpWarning(jumps[jumps_], first_time_));
  return warnings;
}

RefinedResults DriveRecorder::Refined() const {
  RefinedScale scale = odometry_.Refined();
  std::optional<FrameBlending> blending = blended_.Find();
  if (!blending) blending = double_.Find();
  if (blending) {
    WidenScale(FrameBlending::kScaleSigma, scale);
    if (scale.estimate) scale.estimate->is_doubtful = true;
  }
  if (!odometry_.options().vehicle.camera_height) WidenForHeight(scale);
  std::vector<FrameResult> frames = odometry_.RefinedFrames(scale);
  for (ParameterEstimate& estimate : scale.contradicted_calibration) estimate = AtFullSize(scaling_, estimate);
  for (ParameterEstimate& estimate : scale.doubtful_calibration) estimate = AtFullSize(scaling_, estimate);
  return {std::move(frames), std::move(scale), blending};
}

DriveFacts DriveRecorder::Facts(const RunInput& given, const RunEnding& ending, const RefinedResults& results) const {
  const cv::Size size = scaling_.Full(image_size_);
  return {.given = given,
          .ending = ending,
          .images = {.width = size.width,
                     .height = size.height,
                     .unreadable = unreadable_,
                     .is_upside_down = odometry_.is_upside_down(),
                     .blending = results.blending},
          .camera = CameraOf(odometry_, scaling_),
          .mount = MountOf(odometry_),
          .vehicle = odometry_.options().vehicle,
          .method = odometry_.options().scale.method,
          .processed = frames_,
          .repeated = repeated_,
          .seen = seen_,
          .restarts = RestartsOf(odometry_.map()),
          .failed_adjustments = odometry_.failed_adjustments(),
          .live_metric_from = live_metric_from_};
}

RunSummary DriveRecorder::Summary(const RunInput& given, const RefinedResults& results, const RunEnding& ending) const {
  RunSummary summary = SummaryOf(Facts(given, ending, results), results.frames, results.scale);
  summary.cost = CostSince(started_);
  summary.cost.latency = LatencyOf(latencies_);
  return summary;
}

FrameResult ProcessFrame(const SourceFrame& frame, DriveRecorder& recorder, Progress& progress) {
  if (!frame.gray.empty()) return recorder.Process(frame.gray, frame.time);
  progress.Warn(SkippedWarning(frame.index, frame.problem));
  return recorder.ProcessUnreadable(frame.time, frame.problem);
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/run/drive_recorder.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/run/full_size.h"
#include "turnscale/run/view_change.h"

namespace turnscale {
namespace {

// What the odometry says of car and camera.
void DescribeSetting(const Odometry& odometry, const ImageScaling& scaling, RunSummary& summary) {
  const OdometryOptions& options = odometry.options();
  summary.vehicle = options.vehicle;
  summary.method = options.scale.method;
  const CameraModel camera = scaling.Full(odometry.camera());
  summary.pinhole = camera.pinhole;
  summary.lens_model = camera.lens;
  if (options.lens.enabled) summary.lens = {odometry.lens().correction(), odometry.lens().sigma()};
  const MountCalibration& calibration = odometry.mount();
  summary.camera_jumps = calibration.jumps();
  if (!options.vehicle.calibrate_camera) return;
  const Mount mount = calibration.current();
  summary.mount = {.angles = YawPitchRollFromRotation(mount.vehicle_from_camera),
                   .sigma = mount.sigma,
                   .found = mount.found,
                   .moves = calibration.moves(),
                   .is_outdated = !mount.found && calibration.moves() > 0};
}

std::vector<MapRestart> RestartsOf(const Map& map) {
  std::vector<MapRestart> restarts;
  for (const Keyframe& keyframe : map.keyframes)
    if (keyframe.after_gap) restarts.push_back({keyframe.frame, keyframe.time, keyframe.gap_sigma});
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
  if (mount.moves() > moves_) warnings.push_back(CameraMovedWarning(frames_ - 1));
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
  std::vector<FrameResult> frames = odometry_.RefinedFrames(scale);
  for (ParameterEstimate& estimate : scale.contradicted_calibration) estimate = AtFullSize(scaling_, estimate);
  return {std::move(frames), std::move(scale), blending};
}

RunSummary DriveRecorder::Summary(RunSummary summary, const RefinedResults& results) const {
  DescribeSetting(odometry_, scaling_, summary);
  const cv::Size size = scaling_.Full(image_size_);
  summary.image_width = size.width;
  summary.image_height = size.height;
  summary.live_metric_from = live_metric_from_;
  summary.unreadable = unreadable_;
  if (!unreadable_.empty()) summary.warnings.push_back(UnreadableText(unreadable_));
  summary.restarts = RestartsOf(odometry_.map());
  summary.scale_state = StateAtEnd(results.scale);
  summary.is_upside_down = odometry_.is_upside_down();
  summary.blending = results.blending;
  Summarize(results.frames, results.scale, summary);
  for (const FrozenPart& part : FindFrozenParts(results.frames, repeated_))
    summary.warnings.push_back(FrozenPartText(part, summary.first_time, summary.is_metric() ? "m" : "units"));
  if (tracks_) SummarizeBeginning(results.frames, seen_, summary);
  // Results that could not be computed have no frames.
  summary.frames = std::max(summary.frames, frames_);
  summary.cost = CostSince(started_);
  summary.cost.latency = LatencyOf(latencies_);
  return summary;
}

}  // namespace turnscale

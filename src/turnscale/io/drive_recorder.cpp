// SPDX-License-Identifier: MIT
#include "turnscale/io/drive_recorder.h"

#include <chrono>

namespace turnscale {

FrameResult DriveRecorder::Process(const cv::Mat& gray, double time) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  FrameResult result = odometry_.Process(gray, time);
  latencies_.push_back(std::chrono::duration<double>(Clock::now() - start).count());
  image_size_ = gray.size();
  Keep(result);
  if (!tracks_) seen_.Add(gray, time, result.tracked);
  return result;
}

FrameResult DriveRecorder::ProcessUnreadable(double time, const std::string& problem) {
  FrameResult result = odometry_.ProcessUnreadable(time);
  unreadable_.push_back({result.frame, problem});
  Keep(result);
  return result;
}

void DriveRecorder::Keep(const FrameResult& result) {
  ++frames_;
  last_time_ = result.time;
  tracks_ = tracks_ || result.world_from_camera;
  if (!live_metric_from_ && result.world_from_camera && result.scale_state != ScaleState::kPending)
    live_metric_from_ = result.time;
  RecordRotation(result.frame, result.time, odometry_.mount().current(), rotations_);
  camera_moved_ = odometry_.mount().moves() > moves_;
  moves_ = odometry_.mount().moves();
}

void DriveRecorder::Finish() {
  odometry_.Finish();
  // The turns of the end may have told more of it.
  if (frames_ > 0) RecordRotation(frames_ - 1, last_time_, odometry_.mount().current(), rotations_);
}

void DriveRecorder::Summarize(const std::vector<FrameResult>& frames, const RefinedScale& scale,
                              RunSummary& summary) const {
  summary.image_width = image_size_.width;
  summary.image_height = image_size_.height;
  summary.live_metric_from = live_metric_from_;
  summary.unreadable = unreadable_;
  turnscale::Summarize(odometry_, frames, scale, summary);
  if (tracks_) SummarizeBeginning(frames, seen_, summary);
  summary.cost = MeasureCost();
  summary.cost.latency = LatencyOf(latencies_);
}

}  // namespace turnscale

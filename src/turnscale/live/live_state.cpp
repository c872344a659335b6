// SPDX-License-Identifier: MIT
#include "turnscale/live/live_state.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "turnscale/image_file/image_encoder.h"
#include "turnscale/odometry/results.h"
#include "turnscale/report/report_data.h"

namespace turnscale {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr seconds kWatchedFor(3);            // after a viewer has asked
constexpr milliseconds kImageInterval(200);  // between two images
constexpr milliseconds kPathInterval(1000);  // between two states of the path
constexpr seconds kRateWindow(2);            // over which the frames are counted
constexpr int kPathPoints = 1500;
constexpr size_t kMostWarnings = 10;
constexpr int kImageWidth = 640;
constexpr int kImageQuality = 72;

// Speed between neighbours, negative in reverse: the path that is drawn has no other.
std::vector<SpeedReading> RoughSpeeds(const std::vector<FrameResult>& frames,
                                      const Eigen::Quaterniond& vehicle_from_camera) {
  const Eigen::Vector3d forward = vehicle_from_camera.conjugate() * Eigen::Vector3d::UnitZ();
  std::vector<SpeedReading> speeds;
  for (size_t i = 1; i < frames.size(); ++i) {
    const RigidTransform& pose = *frames[i].world_from_camera;
    const Eigen::Vector3d way = pose.translation - frames[i - 1].world_from_camera->translation;
    const double distance = std::copysign(way.norm(), way.dot(pose.rotation * forward));
    const double time = frames[i].time - frames[i - 1].time;
    if (time > 0) speeds.push_back({frames[i].time, distance / time, NAN});
  }
  return speeds;
}

}  // namespace

LiveState::LiveState(std::string title, std::string version, int frames, double first_time, std::string report,
                     milliseconds pause_kept)
    : title_(std::move(title)),
      version_(std::move(version)),
      frames_(frames),
      first_time_(first_time),
      report_(std::move(report)),
      pause_kept_(pause_kept) {}

void LiveState::SetPhase(const std::string& phase) {
  const std::lock_guard lock(mutex_);
  phase_ = phase;
}

void LiveState::Add(const cv::Mat& gray, const FrameResult& frame, const Odometry& odometry) {
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  latest_ = frame;
  ++frames_done_;
  done_at_.push_back(now);
  while (done_at_.size() > 2 && now - done_at_.front() > kRateWindow) done_at_.pop_front();
  keyframes_ = CountKeyframes(odometry.map());
  keyframe_states_.resize(keyframes_, frame.scale_state);
  if (now - asked_at_ > kWatchedFor) return;
  if (!gray.empty() && now - copied_image_at_ > kImageInterval) {
    copied_image_at_ = now;
    gray.copyTo(image_);
    odometry.mask().copyTo(mask_);
    const bool tracked = frame.state == TrackingState::kTracked;
    features_ = tracked ? FeaturesOf(odometry) : std::vector<DrawnFeature>();
    ++image_number_;
  }
  if (now - copied_path_at_ > kPathInterval) {
    copied_path_at_ = now;
    CopyPath(frame, odometry);
  }
}

void LiveState::CopyPath(const FrameResult& frame, const Odometry& odometry) {
  const Map& map = odometry.map();
  const MetricPath& path = odometry.live_path();
  const int count = static_cast<int>(std::min(map.keyframes.size(), path.centres.size()));
  path_.frames.clear();
  path_.metric = frame.scale_state != ScaleState::kPending;
  const int stride = count / kPathPoints + 1;
  for (int i = 0; i < count; i += stride) {
    FrameResult keyframe;
    keyframe.frame = map.keyframes[i].frame;
    keyframe.time = map.keyframes[i].time;
    keyframe.state = TrackingState::kTracked;
    keyframe.world_from_camera =
        RigidTransform{map.keyframes[i].camera_from_world.rotation.conjugate(), path.centres[i]};
    // Once a turn has given the scale, it holds for the path before it too.
    keyframe.scale_state =
        path_.metric && keyframe_states_[i] == ScaleState::kPending ? ScaleState::kHeld : keyframe_states_[i];
    keyframe.scale_sigma = frame.scale_sigma;
    path_.frames.push_back(keyframe);
  }
  if (frame.world_from_camera && (path_.frames.empty() || frame.time > path_.frames.back().time))
    path_.frames.push_back(frame);
  path_.vehicle_from_camera = odometry.mount().At(0);
  ++path_number_;
}

void LiveState::AddWarning(const std::string& warning) {
  const std::lock_guard lock(mutex_);
  if (warnings_.size() < kMostWarnings) {
    warnings_.push_back(warning);
  } else {
    ++more_warnings_;
  }
}

void LiveState::Finish() {
  const std::lock_guard lock(mutex_);
  finished_ = true;
}

void LiveState::SetPaused(bool paused) {
  const std::lock_guard lock(mutex_);
  paused_ = paused;
  asked_at_ = Clock::now();
}

bool LiveState::IsPaused() const {
  const std::lock_guard lock(mutex_);
  return paused_;
}

void LiveState::EndStalePause() {
  const std::lock_guard lock(mutex_);
  if (Clock::now() - asked_at_ > pause_kept_) paused_ = false;
}

std::string LiveState::StateJson() {
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  asked_at_ = now;
  // Those of the last seconds, or the last two where the run is slower.
  const auto in_window = [&](Clock::time_point at) { return now - at <= kRateWindow; };
  const auto recent = std::max<std::ptrdiff_t>(std::count_if(done_at_.begin(), done_at_.end(), in_window),
                                               std::min<std::ptrdiff_t>(std::ssize(done_at_), 2));
  const double span = recent > 0 ? std::chrono::duration<double>(now - *(done_at_.end() - recent)).count() : 0;
  std::vector<std::string> warnings = warnings_;
  if (more_warnings_ > 0) warnings.push_back(std::to_string(more_warnings_) + " more, in the report");
  const nlohmann::ordered_json json = {
      {"phase", phase_},
      {"report", report_},
      {"warnings", warnings},
      {"frame", frames_done_},
      {"frames", frames_done_ > frames_ ? 0 : frames_},
      {"rate", recent > 1 && span > 0 ? static_cast<double>(recent) / span : 0.0},
      {"keyframes", keyframes_},
      {"scaleState", ScaleStateName(latest_.scale_state)},
      {"sigma", std::isfinite(latest_.scale_sigma) ? nlohmann::ordered_json(latest_.scale_sigma) : nullptr},
      {"tracking", TrackingStateName(latest_.state)},
      {"tracked", latest_.tracked},
      {"paused", paused_},
      {"finished", finished_},
      {"image", image_number_},
      {"path", path_number_}};
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string LiveState::PathJson() {
  const std::lock_guard making(making_);
  ReportData data;
  int number = 0;
  {
    const std::lock_guard lock(mutex_);
    number = path_number_;
    if (number == path_json_number_) return path_json_;
    data.frames = path_.frames;
    data.metric = path_.metric;
    data.vehicle_from_body = path_.vehicle_from_camera;
  }
  data.time_origin = first_time_;
  data.title = title_;
  data.version = version_;
  data.notes = {"The path as far as it is known now"};
  if (data.metric) data.speeds = RoughSpeeds(data.frames, data.vehicle_from_body);
  path_json_ = ReportJson(data);
  path_json_number_ = number;
  return path_json_;
}

std::string LiveState::Image() {
  const std::lock_guard making(making_);
  cv::Mat image;
  cv::Mat mask;
  std::vector<DrawnFeature> features;
  {
    const std::lock_guard lock(mutex_);
    if (image_number_ == jpeg_number_ || image_.empty()) return jpeg_;
    image = image_.clone();
    mask = mask_.clone();
    features = features_;
    jpeg_number_ = image_number_;
  }
  jpeg_ = EncodeJpeg(DrawTracking(image, features, mask, kImageWidth), kImageQuality);
  return jpeg_;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/odometry/frame_history.h"

#include <optional>

namespace turnscale {
namespace {

bool Measured(const FrameResult& frame) { return frame.state == TrackingState::kTracked && frame.world_from_camera; }

RigidTransform Between(const FrameResult& before, const FrameResult& after, double time) {
  const double share = (time - before.time) / (after.time - before.time);
  const RigidTransform& a = *before.world_from_camera;
  const RigidTransform& b = *after.world_from_camera;
  return {a.rotation.slerp(share, b.rotation), (1 - share) * a.translation + share * b.translation};
}

void InterpolateBridged(std::vector<FrameResult>& frames) {
  std::optional<size_t> before;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (!Measured(frames[i])) continue;
    if (before)
      for (size_t gap = *before + 1; gap < i; ++gap)
        frames[gap].world_from_camera = Between(frames[*before], frames[i], frames[gap].time);
    before = i;
  }
}

void FillStart(std::vector<FrameResult>& frames) {
  size_t first = 0;
  while (first < frames.size() && !frames[first].world_from_camera) ++first;
  if (first == frames.size()) return;
  for (size_t i = 0; i < first; ++i) frames[i].world_from_camera = frames[first].world_from_camera;
}

}  // namespace

RigidTransform MetricPath::InMetres(const Map& map, int keyframe, const RigidTransform& world_from_camera) const {
  return {world_from_camera.rotation, InMetres(map, keyframe, world_from_camera.translation)};
}

Eigen::Vector3d MetricPath::InMetres(const Map& map, int keyframe, const Eigen::Vector3d& point) const {
  return centres[keyframe] + metres_per_unit[keyframe] * (point - Centre(map.keyframes[keyframe]));
}

FrameHistory::Entry FrameHistory::EntryOf(const FrameResult& result) {
  return {result.time, result.tracked, result.inliers, result.state, result.keyframe, -1, {}};
}

void FrameHistory::AddWithoutPose(const FrameResult& result) { entries_.push_back(EntryOf(result)); }

void FrameHistory::Add(const FrameResult& result, const Map& map, int keyframe,
                       const RigidTransform& camera_from_world) {
  Entry entry = EntryOf(result);
  entry.keyframe = keyframe;
  entry.frame_from_keyframe = camera_from_world * map.keyframes[keyframe].camera_from_world.inverse();
  if (result.frame < static_cast<int>(entries_.size()))
    entries_[result.frame] = entry;
  else
    entries_.push_back(entry);
}

void FrameHistory::Rescale(int first, const std::vector<double>& factors) {
  for (size_t i = entries_.size(); i-- > 0;) {
    Entry& entry = entries_[i];
    if (entry.keyframe >= first) entry.frame_from_keyframe.translation *= factors[entry.keyframe - first];
    // Frames around a restart are out of order by one keyframe.
    if (entry.keyframe >= 0 && entry.keyframe < first - 1) return;
  }
}

std::vector<int> FrameHistory::Keyframes() const {
  std::vector<int> keyframes;
  for (const Entry& entry : entries_) keyframes.push_back(entry.keyframe);
  return keyframes;
}

std::vector<MeasuredEnd> FrameHistory::MeasuredEnds(const Map& map) const {
  std::vector<MeasuredEnd> ends;
  for (const Keyframe& keyframe : map.keyframes) ends.push_back({keyframe.time, Centre(keyframe)});
  for (const Entry& entry : entries_) {
    if (entry.keyframe < 0 || entry.state != TrackingState::kTracked) continue;
    MeasuredEnd& end = ends[entry.keyframe];
    if (entry.time <= end.time) continue;
    const RigidTransform pose = entry.frame_from_keyframe * map.keyframes[entry.keyframe].camera_from_world;
    end = {entry.time, pose.inverse().translation};
  }
  return ends;
}

std::vector<FrameResult> FrameHistory::Refined(const Map& map, const MetricPath& path) const {
  std::vector<FrameResult> frames;
  frames.reserve(entries_.size());
  for (const Entry& entry : entries_) {
    FrameResult frame;
    frame.frame = static_cast<int>(frames.size());
    frame.time = entry.time;
    frame.state = entry.state;
    frame.tracked = entry.tracked;
    frame.inliers = entry.inliers;
    frame.keyframe = entry.is_keyframe;
    if (entry.keyframe >= 0) {
      const RigidTransform pose =
          (entry.frame_from_keyframe * map.keyframes[entry.keyframe].camera_from_world).inverse();
      frame.world_from_camera = path.InMetres(map, entry.keyframe, pose);
    }
    frames.push_back(frame);
  }
  InterpolateBridged(frames);
  FillStart(frames);
  return frames;
}

}  // namespace turnscale

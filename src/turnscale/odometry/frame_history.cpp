// SPDX-License-Identifier: MIT
#include "turnscale/odometry/frame_history.h"

#include <optional>

#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// Motion between two frames: mean velocity, and turn about the first one's axes per second.
struct MeanMotion {
  Eigen::Vector3d velocity;
  Eigen::Vector3d turning;
  double seconds = 0;
};

MeanMotion MotionBetween(const FrameResult& first, const FrameResult& second) {
  const RigidTransform& a = *first.world_from_camera;
  const RigidTransform& b = *second.world_from_camera;
  const double seconds = second.time - first.time;
  return {(b.translation - a.translation) / seconds, VectorFromRotation(a.rotation.conjugate() * b.rotation) / seconds,
          seconds};
}

// Rate at the end of a gap from the mean rates in it and beside it, each valid in the middle of its interval. Bounded,
// so that the path through the gap does not turn back.
Eigen::Vector3d RateAtEnd(const Eigen::Vector3d& within, double seconds, const Eigen::Vector3d& beside,
                          double seconds_beside) {
  constexpr double kMostTimesMean = 3;
  const Eigen::Vector3d rate = (seconds * beside + seconds_beside * within) / (seconds + seconds_beside);
  const double most = kMostTimesMean * within.norm();
  return rate.norm() > most ? Eigen::Vector3d(rate * (most / rate.norm())) : rate;
}

// The poses in a gap between two measured frames: cubics in time of position and rotation, which go on from the
// measured motion on either side, where there is some.
class GapPath {
 public:
  GapPath(const FrameResult* earlier, const FrameResult& before, const FrameResult& after, const FrameResult* later)
      : start_(*before.world_from_camera), time_(before.time), mean_(MotionBetween(before, after)) {
    first_ = last_ = mean_;
    const auto join = [&](const MeanMotion& beside, MeanMotion& end) {
      end.velocity = RateAtEnd(mean_.velocity, mean_.seconds, beside.velocity, beside.seconds);
      end.turning = RateAtEnd(mean_.turning, mean_.seconds, beside.turning, beside.seconds);
    };
    if (earlier != nullptr) join(MotionBetween(*earlier, before), first_);
    if (later != nullptr) join(MotionBetween(after, *later), last_);
  }

  RigidTransform At(double time) const {
    const double share = (time - time_) / mean_.seconds;
    const auto moved = [&](const Eigen::Vector3d& mean, const Eigen::Vector3d& first, const Eigen::Vector3d& last) {
      const double left = 1 - share;
      return Eigen::Vector3d(mean_.seconds * share * (mean + left * (left * (first - mean) - share * (last - mean))));
    };
    return {start_.rotation * RotationFromVector(moved(mean_.turning, first_.turning, last_.turning)),
            start_.translation + moved(mean_.velocity, first_.velocity, last_.velocity)};
  }

 private:
  RigidTransform start_;
  double time_ = 0;
  MeanMotion mean_;
  MeanMotion first_;  // at the ends of the gap
  MeanMotion last_;
};

void InterpolateBridged(std::vector<FrameResult>& frames) {
  std::vector<const FrameResult*> measured;
  for (const FrameResult& frame : frames)
    if (frame.is_measured()) measured.push_back(&frame);
  for (size_t i = 1; i < measured.size(); ++i) {
    const size_t before = measured[i - 1] - frames.data();
    const size_t after = measured[i] - frames.data();
    if (after - before < 2) continue;
    const GapPath path(i > 1 ? measured[i - 2] : nullptr, frames[before], frames[after],
                       i + 1 < measured.size() ? measured[i + 1] : nullptr);
    for (size_t gap = before + 1; gap < after; ++gap) frames[gap].world_from_camera = path.At(frames[gap].time);
  }
}

void FillStart(std::vector<FrameResult>& frames) {
  size_t first = 0;
  while (first < frames.size() && !frames[first].world_from_camera) ++first;
  if (first == frames.size()) return;
  for (size_t i = 0; i < first; ++i) frames[i].world_from_camera = frames[first].world_from_camera;
}

}  // namespace

FrameHistory::Entry FrameHistory::EntryOf(const FrameResult& result) {
  return {result.time, result.tracked, result.inliers, result.state, result.keyframe, -1, {}};
}

void FrameHistory::Put(int frame, const Entry& entry) {
  if (frame < static_cast<int>(entries_.size()))
    entries_[frame] = entry;
  else
    entries_.push_back(entry);
}

void FrameHistory::AddWithoutPose(const FrameResult& result) { Put(result.frame, EntryOf(result)); }

void FrameHistory::Add(const FrameResult& result, const Map& map, int keyframe,
                       const RigidTransform& camera_from_world) {
  Entry entry = EntryOf(result);
  entry.keyframe = keyframe;
  entry.frame_from_keyframe = camera_from_world * map.keyframes[keyframe].camera_from_world.inverse();
  Put(result.frame, entry);
}

void FrameHistory::ForgetMeasured(double after) {
  for (auto entry = entries_.rbegin(); entry != entries_.rend() && entry->time > after; ++entry)
    if (!entry->is_keyframe && entry->state != TrackingState::kUnreadable) entry->state = TrackingState::kBridged;
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

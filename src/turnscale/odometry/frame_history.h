// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <vector>

#include <Eigen/Core>

#include "turnscale/mapping/map.h"
#include "turnscale/odometry/metric_path.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// Where and when the camera was measured last before the map went on from another keyframe.
struct MeasuredEnd {
  double time = 0;         ///< seconds
  Eigen::Vector3d centre;  ///< in the world of the map, its unit
};

/// Every frame of the drive, relative to a keyframe: when keyframes are refined, their frames move with them.
class FrameHistory {
 public:
  /// Adds a frame that has no pose yet, or replaces what is known of the frame of that number.
  void AddWithoutPose(const FrameResult& result);

  /// Adds a frame, or gives the frame of that number its pose, relative to a keyframe of the map.
  void Add(const FrameResult& result, const Map& map, int keyframe, const RigidTransform& camera_from_world);

  /// Frames later than `after` (seconds), other than keyframes and unreadable ones, become bridged: their images showed
  /// a frozen view.
  void ForgetMeasured(double after);

  /// Translations relative to keyframe first + k are multiplied by `factors[k]`.
  void Rescale(int first, const std::vector<double>& factors);

  /// The reference keyframe of each frame, -1 if it has no pose.
  std::vector<int> Keyframes() const;

  /// The last measured frame relative to each keyframe of the map; the keyframe itself where there is no other.
  std::vector<MeasuredEnd> MeasuredEnds(const Map& map) const;

  /// All frames with their current poses, from the map and the metric path. Poses that were not measured go on
  /// smoothly between measured ones; frames before the first pose have that pose, once there is one.
  std::vector<FrameResult> Refined(const Map& map, const MetricPath& path) const;

 private:
  /// What cannot be computed from the map and the scale: there are many frames.
  struct Entry {
    double time = 0;
    int tracked = 0;
    int inliers = 0;
    TrackingState state = TrackingState::kInitializing;
    bool is_keyframe = false;
    int keyframe = -1;  ///< -1 while the frame has no pose
    RigidTransform frame_from_keyframe;
  };
  static Entry EntryOf(const FrameResult& result);
  void Put(int frame, const Entry& entry);

  std::deque<Entry> entries_;  ///< index is the frame's number; keyframes ascend but for those around a restart
};

}  // namespace turnscale

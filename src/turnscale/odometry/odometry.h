// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// From a drive's images to the camera's path: one call a frame, in the order of time.
class Odometry {
 public:
  Odometry(const OdometryOptions& options, const CameraModel& camera);
  ~Odometry();

  /// Takes the next image (8-bit gray, the camera file's size) taken at `time` seconds, and gives what is known of the
  /// camera's pose at this moment.
  FrameResult Process(const cv::Mat& gray, double time);

  /// The next frame has no usable image: its pose is predicted and flagged.
  FrameResult ProcessUnreadable(double time);

  /// Every frame so far with its refined pose: what the absolute scale recovery has gone back over. Frames before the
  /// map started are given the first pose known (they have none of their own only while there is no map at all).
  std::vector<FrameResult> RefinedFrames() const;

  /// Grows whenever the refined poses of frames already given change as a whole.
  int revision() const;

  std::vector<TurnResult> Turns() const;
  const Map& map() const;
  ScaleState scale_state() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "turnscale/calibration/camera_step.h"
#include "turnscale/geometry/trajectory.h"

namespace turnscale {

struct StepOptions {
  /// A step takes in as many frames as the car drives in this time at its usual speed, seconds. The motion between two
  /// frames has more noise than signal; over more than a second, a turn is not one turn any more. In time, since the
  /// unit of length is unknown.
  double duration = 0.6;
  /// What took more than this many times `duration` is left out: the car crept or stood, and what moved was the noise.
  double max_slowness = 4;
  /// The usual speed is this quantile of the speeds seen lately: standing at a light must not count.
  double usual_speed_quantile = 0.75;
  /// How many frames "lately" are.
  int speed_memory = 600;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The frames of a step that is not complete.
struct FrameMotions {
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< sum of rotation vectors, rad
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< sum of translations, each in its own camera frame
  int frames = 0;
  double begin = 0;  ///< seconds
};

/// Makes steps of about equal length out of poses, frame by frame, in bounded memory.
class StepGatherer {
 public:
  explicit StepGatherer(const StepOptions& options = {});

  /// Takes the next pose; gives the step that it completes. Throws InputError where the pose is not finite or its time
  /// does not come after the one before.
  std::optional<CameraStep> Add(const StampedPose& pose);

  /// The next pose does not belong to the same path (tracking was lost): no step reaches across.
  void Break();

 private:
  StepOptions options_;
  std::optional<StampedPose> last_;
  std::deque<double> speeds_;
  FrameMotions open_;
};

/// All steps of a path. The usual speed is the whole path's.
std::vector<CameraStep> StepsAlong(const Trajectory& trajectory, const StepOptions& options = {});

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/usual_speed.h"
#include "turnscale/geometry/trajectory.h"

namespace turnscale {

struct StepOptions {
  /// A step takes in as many frames as the car drives in this time at its usual speed, seconds. The motion between two
  /// frames has more noise than signal; over more than a second, a turn is not one turn any more. In time, since the
  /// unit of length is unknown.
  double duration = 0.6;
  /// What took more than this many times `duration` is left out: the car crept or stood, and what moved was the noise;
  /// or frames are missing there.
  double max_slowness = 4;
  /// Nor does a car go faster than this many times its usual speed from one frame to the next: the path jumps.
  double max_haste = 6;
  /// The usual speed of a drive that goes on is that of so many seconds of driving.
  double speed_memory = 60;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Accumulator of the frames of an incomplete step.
struct FrameMotions {
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();     ///< sum of rotation vectors, rad
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< sum of translations, each half-way through its rotation
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
  UsualSpeed speed_;
  FrameMotions open_;
};

/// All steps of a path. The usual speed is the whole path's.
std::vector<CameraStep> StepsAlong(const Trajectory& trajectory, const StepOptions& options = {});

/// All steps of a drive whose path is known in segments, in one unit of length. The usual speed is the whole drive's;
/// no step reaches from one segment to the next.
std::vector<CameraStep> StepsAlong(const std::vector<Trajectory>& stretches, const StepOptions& options = {});

/// When the first piece is missing in a path: the car has gone on, and no step reaches across. Nothing where none is.
std::optional<double> FirstGap(const Trajectory& trajectory, const StepOptions& options = {});

}  // namespace turnscale

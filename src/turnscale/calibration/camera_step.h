// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {

/// The camera's motion from one frame to the next, as a mean over some frames: the paper's hat R_j, hat t_j, with
/// less noise. In the odometry's own unit of length.
///
/// Each frame's motion is taken in its own camera frame, half-way through its rotation: on a bend the camera then goes
/// the same way in every frame, so means obey the kinematics however long the bend is and however unequal the frames
/// are. The chord of a long step does not, nor does a mean of the directions seen from where the frames begin. Noise
/// that is independent from frame to frame averages out.
struct CameraStep {
  RigidTransform previous_from_current;  ///< of one frame
  int frames = 1;
  double begin = 0;  ///< seconds
  double end = 0;    ///< seconds
};

/// The step as one motion: its first pose from its last, had the camera moved in every frame as on the mean.
inline RigidTransform WholeMotion(const CameraStep& step) {
  const Eigen::Vector3d rotation = VectorFromRotation(step.previous_from_current.rotation);
  return {
      RotationFromVector(step.frames * rotation),
      step.frames * (RotationFromVector(0.5 * (step.frames - 1) * rotation) * step.previous_from_current.translation)};
}

/// Reversing obeys the same kinematics with time inverted, except for the slip of the tyres: the step as if the car
/// drove forward.
inline CameraStep Reversed(CameraStep step) {
  step.previous_from_current = step.previous_from_current.inverse();
  return step;
}

/// Typical speed of a car: half of its path length is driven at this speed or faster. Weighted by path length, not by
/// frames, so that odometry noise at standstill has almost no influence. In bounded memory; any unit.
class UsualSpeed {
 public:
  /// Speeds seen longer ago than about so many seconds of driving are forgotten.
  explicit UsualSpeed(double memory = std::numeric_limits<double>::infinity());

  /// Takes a way and the seconds (above 0) that it took.
  void Add(double way, double seconds);

  /// 0 while nothing has moved.
  double value() const { return value_; }

 private:
  struct Driven {
    double way = 0;
    double seconds = 0;
  };

  double memory_;
  std::optional<double> reference_;                 ///< the first speed; others are sorted by their ratio to it
  std::map<int, Driven, std::greater<>> by_speed_;  ///< fastest first
  double way_ = 0;
  double value_ = 0;
};

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

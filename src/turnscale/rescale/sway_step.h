// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "turnscale/geometry/trajectory.h"

namespace turnscale {

/// A step between two keys of a trajectory, in the terms of the pooled line (blueprint: lambda y = L x).
///
/// Its axes are those of Q, pitched so that the step goes neither up nor down. Where Q has the pitch wrong by d, a turn
/// by psi shows a roll of psi d that is none, in proportion to what the lever arm does; a car goes along its road, so
/// each step shows that pitch itself, and the body's as well.
struct SwayStep {
  int first = 0;  ///< poses that the step leads from and to
  int last = 0;
  double psi = 0;       ///< turning angle, rad, positive to the right
  double length = 0;    ///< odometry units
  double sway = 0;      ///< y = length sin(theta - psi/2): sideways as seen half-way, odometry units
  double roll = 0;      ///< rad that the camera leans over to the right meanwhile
  double speed = 0;     ///< odometry units a second; 0 where times are unknown
  bool forward = true;  ///< false where the step goes to the side, up, down or backwards
  /// False where the step does not go forward, or the odometry jumped or was lost: nothing is read from it then.
  bool usable = true;
  bool after_gap = false;  ///< leads across a gap: nothing of its motion is known
};

struct KeySpacingOptions {
  /// Turning angle of a step in a turn, rad (3 deg, as in the paper's keyframes). Closer keys carry more noise than
  /// signal; with wider ones the curvature changes within the step, for which the circle of (1) has no room.
  double step_angle = 3.0 / 57.295779513082320877;
  /// Greatest number of poses from key to key.
  int max_spacing = 20;
  /// A key is at least this share of an ordinary step away from the one before: creeping is no driving.
  double min_length_share = 0.25;
  /// A step this many times as fast as four of five others is no driving but a jump of the odometry.
  double max_speed_ratio = 3;
  /// A key that comes this many times as late as `spacing` has it follows a stop, or a loss of tracking.
  int max_late = 4;
  /// Steps that go further off the forward direction than this are backwards or a jump, rad (60 deg).
  double max_direction = 60.0 / 57.295779513082320877;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Poses from key to key at which a turning step has about `step_angle`: 2 for 10 images a second, 1 for keyframes.
int KeySpacing(const Trajectory& trajectory, const Eigen::Quaterniond& vehicle_from_camera,
               const KeySpacingOptions& options);

/// Steps between keys that are at least `spacing` poses apart. `timed` says that the poses' times are seconds, `gaps`
/// which poses do not hang together with the one before (increasing): a step of no length leads there.
std::vector<SwayStep> SwaySteps(const Trajectory& trajectory, const Eigen::Quaterniond& vehicle_from_camera,
                                int spacing, bool timed, const KeySpacingOptions& options,
                                const std::vector<int>& gaps = {});

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Geometry>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// A camera step in kinematic terms.
struct TurningMotion {
  double psi = 0;    ///< turning angle, rad, positive to the right
  double theta = 0;  ///< direction of travel in A's horizontal plane, rad, positive to the right (19)
  double step = 0;   ///< distance between the two camera centres, in the unit of the motion
};

/// Kinematic terms of a camera's `previous_from_current`; `vehicle_from_camera` is the paper's Q.
///
/// psi is the part of the rotation about the vehicle's y axis (twist), signed by that axis. (9) takes the whole angle,
/// by arccos of the trace: that loses half the digits near zero, counts pitching and rolling as turning, and has no
/// sign. theta is 0 for a step of length 0.
TurningMotion TurningMotionOf(const RigidTransform& previous_from_current,
                              const Eigen::Quaterniond& vehicle_from_camera);

}  // namespace turnscale

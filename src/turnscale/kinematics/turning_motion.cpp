// SPDX-License-Identifier: MIT
#include "turnscale/kinematics/turning_motion.h"

#include <cmath>

#include "turnscale/geometry/rotation.h"

namespace turnscale {

TurningMotion TurningMotionOf(const RigidTransform& previous_from_current,
                              const Eigen::Quaterniond& vehicle_from_camera) {
  const Eigen::Quaterniond turn =
      vehicle_from_camera * previous_from_current.rotation * vehicle_from_camera.conjugate();
  const Eigen::Vector3d travel = vehicle_from_camera * previous_from_current.translation;
  return {TwistAboutY(turn), std::atan2(travel.x(), travel.z()), travel.norm()};
}

}  // namespace turnscale

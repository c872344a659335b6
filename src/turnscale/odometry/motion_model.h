// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Goes on as the camera moved last: constant velocity and turning rate.
class MotionModel {
 public:
  /// Pose expected at `time` (seconds).
  RigidTransform Predict(double time) const;

  /// Takes a measured pose; the velocity is the one from the measured pose before.
  void Update(double time, const RigidTransform& camera_from_world);

  /// The last pose turned out to be this one, and lengths are `factor` times what they were.
  void Correct(const RigidTransform& camera_from_world, double factor);

  const RigidTransform& last() const { return camera_from_world_; }
  /// Units of length per second; 0 before two poses are known.
  double speed() const;

 private:
  double time_ = 0;
  RigidTransform camera_from_world_;
  std::optional<double> interval_;  ///< seconds that `current_from_previous_` spans
  RigidTransform current_from_previous_;
  bool started_ = false;
};

}  // namespace turnscale

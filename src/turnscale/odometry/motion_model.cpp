// SPDX-License-Identifier: MIT
#include "turnscale/odometry/motion_model.h"

#include "turnscale/geometry/rotation.h"

namespace turnscale {

RigidTransform MotionModel::Predict(double time) const {
  if (!interval_) return camera_from_world_;
  const double share = (time - time_) / *interval_;
  const RigidTransform step{RotationFromVector(share * VectorFromRotation(current_from_previous_.rotation)),
                            share * current_from_previous_.translation};
  return step * camera_from_world_;
}

void MotionModel::Update(double time, const RigidTransform& camera_from_world) {
  if (started_ && time > time_) {
    interval_ = time - time_;
    current_from_previous_ = camera_from_world * camera_from_world_.inverse();
  }
  started_ = true;
  time_ = time;
  camera_from_world_ = camera_from_world;
}

void MotionModel::Correct(const RigidTransform& camera_from_world, double factor) {
  camera_from_world_ = camera_from_world;
  current_from_previous_.translation *= factor;
}

double MotionModel::speed() const { return interval_ ? current_from_previous_.translation.norm() / *interval_ : 0.0; }

}  // namespace turnscale

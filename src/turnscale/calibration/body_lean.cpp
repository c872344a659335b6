// SPDX-License-Identifier: MIT
#include "turnscale/calibration/body_lean.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "turnscale/base/quantiles.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

// A step of the body.
struct BodyStep {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  ///< whole rotation, vehicle axes, rad
  double acceleration = 0;                         ///< sideways, on the mean
  double change = 0;                               ///< of the acceleration, from begin to end
  bool follows = false;                            ///< on the step before, without a gap
};

std::vector<BodyStep> BodySteps(const std::vector<CameraStep>& steps, const Eigen::Quaterniond& vehicle_from_camera) {
  std::vector<BodyStep> body(steps.size());
  for (size_t i = 0; i < steps.size(); ++i) {
    const CameraStep& step = steps[i];
    const double seconds = step.end - step.begin;
    body[i].turn = step.frames * (vehicle_from_camera * VectorFromRotation(step.previous_from_current.rotation));
    const double speed = step.frames * step.previous_from_current.translation.norm() / seconds;
    body[i].acceleration = speed * body[i].turn.y() / seconds;
  }
  for (size_t i = 1; i < steps.size(); ++i) body[i].follows = steps[i - 1].end == steps[i].begin;
  for (size_t i = 1; i + 1 < steps.size(); ++i) {
    if (!body[i].follows || !body[i + 1].follows) continue;
    body[i].change = 0.5 * (body[i + 1].acceleration - body[i - 1].acceleration);
  }
  return body;
}

}  // namespace

BodyLean FitBodyLean(const std::vector<CameraStep>& steps, const Eigen::Quaterniond& vehicle_from_camera) {
  constexpr size_t kLeastSteps = 20;
  constexpr int kIterations = 20;
  const std::vector<BodyStep> body = BodySteps(steps, vehicle_from_camera);
  // Over three steps, which hold the whole begin or end of a turn, from the acceleration before to the one after.
  struct Change {
    double acceleration = 0;
    double roll = 0;
  };
  std::vector<Change> changes;
  double squares = 0;
  for (size_t i = 2; i + 2 < body.size(); ++i) {
    if (!(body[i - 1].follows && body[i].follows && body[i + 1].follows && body[i + 2].follows)) continue;
    const double before = 0.5 * (body[i - 2].acceleration + body[i - 1].acceleration);
    const double after = 0.5 * (body[i + 1].acceleration + body[i + 2].acceleration);
    changes.push_back({after - before, body[i - 1].turn.z() + body[i].turn.z() + body[i + 1].turn.z()});
    squares += changes.back().acceleration * changes.back().acceleration;
  }
  BodyLean lean;
  if (changes.size() < kLeastSteps || !(squares > 0)) return lean;
  double curvature = 0;
  double scores = 0;
  double noise = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kIterations; ++i) {
    double product = 0;
    double information = 0;
    curvature = scores = 0;
    std::vector<std::pair<double, double>> sizes;
    for (const Change& change : changes) {
      // Kerbs and pot-holes roll a car more than turns do.
      const double off = change.roll - lean.per_acceleration * change.acceleration;
      const double weight = 1 / std::hypot(1, off / noise);
      const double square = change.acceleration * change.acceleration;
      product += weight * change.acceleration * off;
      information += weight * square;
      curvature += weight * weight * weight * square;
      scores += weight * weight * off * off * square;
      sizes.emplace_back(std::abs(off), square);
    }
    lean.per_acceleration += product / information;
    // As large as where the acceleration changes.
    noise = std::max(WeightedMedian(std::move(sizes)), 1e-9);
  }
  lean.per_acceleration = std::min(lean.per_acceleration, 0.0);
  // Each step's roll is in three changes.
  lean.sigma = std::sqrt(3 * scores) / curvature;
  double turning = 0;
  for (const BodyStep& step : body) {
    turning += step.turn.y() * step.turn.y();
    lean.mean_acceleration += step.turn.y() * step.turn.y() * step.acceleration;
  }
  lean.mean_acceleration /= turning;
  return lean;
}

std::vector<CameraStep> Levelled(std::vector<CameraStep> steps, const Eigen::Quaterniond& vehicle_from_camera,
                                 const BodyLean& lean) {
  const std::vector<BodyStep> body = BodySteps(steps, vehicle_from_camera);
  for (size_t i = 0; i < steps.size(); ++i) {
    // A body that leans by phi sees the car's axis y at (sin phi, cos phi, 0), the way it goes turned likewise, and its
    // own rolling about z.
    const Eigen::Quaterniond upright_from_body =
        RotationFromVector({0, 0, lean.per_acceleration * body[i].acceleration});
    const Eigen::Vector3d turn =
        upright_from_body * body[i].turn - Eigen::Vector3d(0, 0, lean.per_acceleration * body[i].change);
    RigidTransform& motion = steps[i].previous_from_current;
    motion.rotation = RotationFromVector(vehicle_from_camera.conjugate() * turn / steps[i].frames);
    motion.translation =
        vehicle_from_camera.conjugate() * (upright_from_body * (vehicle_from_camera * motion.translation));
  }
  return steps;
}

}  // namespace turnscale

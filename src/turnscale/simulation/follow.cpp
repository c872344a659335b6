// SPDX-License-Identifier: MIT
#include "turnscale/simulation/follow.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Dense>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

constexpr double kFitTime = 0.3;          // seconds, standard deviation
constexpr double kHeightSmoothing = 4.0;  // metres, standard deviation
constexpr double kMinSpacing = 0.3;       // metres
constexpr double kMinLength = 1.0;        // metres

struct Fit {
  Eigen::Vector3d value;
  Eigen::Vector3d slope;
};

/// Value and slope at place `i` of the parabola through the samples around it. A parabola, because a straight line
/// would cut curves; a line where there are too few samples for it.
Fit FitAround(const std::vector<double>& places, const std::vector<Eigen::Vector3d>& samples, std::size_t i,
              double sigma) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d right_side = Eigen::Matrix3d::Zero();
  int count = 0;
  const auto add = [&](std::size_t k) {
    const double u = (places[k] - places[i]) / sigma;
    if (std::abs(u) > 4 && (k > i + 1 || k + 1 < i)) return false;
    const double weight = std::exp(-0.5 * std::min(u * u, 16.0));
    const Eigen::Vector3d powers(1, u, u * u);
    normal += weight * powers * powers.transpose();
    right_side += weight * powers * samples[k].transpose();
    ++count;
    return true;
  };
  add(i);
  for (std::size_t k = i + 1; k < samples.size() && add(k); ++k) continue;
  for (std::size_t k = i; k-- > 0 && add(k);) continue;
  const int degree = std::min(count - 1, 2);
  const Eigen::MatrixXd coefficients =
      normal.topLeftCorner(degree + 1, degree + 1).ldlt().solve(right_side.topRows(degree + 1));
  Fit fit;
  fit.value = coefficients.row(0);
  fit.slope = coefficients.row(1) / sigma;
  return fit;
}

Eigen::Vector2d FromAbove(const Eigen::Vector3d& point) { return {point.x(), point.z()}; }

void SmoothHeights(std::vector<Eigen::Vector3d>& points) {
  std::vector<double> distance = {0};
  for (std::size_t i = 1; i < points.size(); ++i)
    distance.push_back(distance.back() + (FromAbove(points[i]) - FromAbove(points[i - 1])).norm());
  const std::vector<Eigen::Vector3d> before = points;
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i].y() = FitAround(distance, before, i, kHeightSmoothing).value.y();
}

}  // namespace

RecordedPath RearAxlePath(const Trajectory& trajectory, const RigidTransform& vehicle_from_camera) {
  std::vector<double> times;
  std::vector<Eigen::Vector3d> axle;
  for (const StampedPose& pose : trajectory) {
    if (!times.empty() && !(pose.time > times.back()))
      throw InputError("trajectory: time of pose " + std::to_string(times.size()) + " is not after the one before");
    const RigidTransform first_from_vehicle = vehicle_from_camera * trajectory.front().world_from_camera.inverse() *
                                              pose.world_from_camera * vehicle_from_camera.inverse();
    const Eigen::Vector3d& place = first_from_vehicle.translation;
    times.push_back(pose.time);
    axle.emplace_back(place.x(), -place.y(), place.z());
  }
  RecordedPath path;
  for (std::size_t i = 0; i < axle.size() && axle.size() >= 2; ++i) {
    const Fit fit = FitAround(times, axle, i, kFitTime);
    const double speed = FromAbove(fit.slope).norm();
    if (!path.points.empty() && (FromAbove(fit.value) - FromAbove(path.points.back())).norm() < kMinSpacing) {
      path.speeds.back() = std::min(path.speeds.back(), speed);
      continue;
    }
    path.points.push_back(fit.value);
    path.speeds.push_back(speed);
  }
  double length = 0;
  for (std::size_t i = 1; i < path.points.size(); ++i)
    length += (FromAbove(path.points[i]) - FromAbove(path.points[i - 1])).norm();
  if (!(length >= kMinLength)) throw InputError("trajectory: its path length is below 1 m");
  SmoothHeights(path.points);
  return path;
}

}  // namespace turnscale

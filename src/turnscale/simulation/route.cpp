// SPDX-License-Identifier: MIT
#include "turnscale/simulation/route.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kMaxSpeed = 100;
constexpr double kMaxTurn = 170 / kDegreesPerRadian;
// Length of a transition in radii: about a second at the speed at which a curve is comfortable.
constexpr double kTransition = 0.5;

/// A corner: the curvature rises over the transition, stays at 1 / radius, and falls again.
struct Bend {
  double angle = 0;  // positive to the right
  double radius = 1;
  double transition = 0;

  double Length() const { return radius * std::abs(angle) + transition; }

  /// Angle turned after a distance, its sign left out.
  double Turned(double distance) const {
    const double rest = Length() - distance;
    if (distance < transition) return distance * distance / (2 * transition * radius);
    if (rest < transition) return std::abs(angle) - rest * rest / (2 * transition * radius);
    return (distance - 0.5 * transition) / radius;
  }
};

Bend MakeBend(double angle, double radius, double transition) {
  return {angle, radius, std::min(transition, radius * std::abs(angle))};
}

/// Points of the bend after its start, which lies at the origin and leads along the second axis.
std::vector<Eigen::Vector2d> Trace(const Bend& bend, double step) {
  constexpr int kParts = 8;
  const int count = std::max(1, static_cast<int>(std::ceil(bend.Length() / step)));
  const double part = bend.Length() / (count * kParts);
  std::vector<Eigen::Vector2d> points;
  Eigen::Vector2d at(0, 0);
  for (int i = 0; i < count * kParts; ++i) {
    const double heading = std::copysign(bend.Turned((i + 0.5) * part), bend.angle);
    at += part * Eigen::Vector2d(std::sin(heading), std::cos(heading));
    if ((i + 1) % kParts == 0) points.push_back(at);
  }
  return points;
}

/// Distance from the bend's ends to the corner that it rounds.
double TangentLength(const Bend& bend) {
  const double chord = Trace(bend, bend.Length() / 16).back().norm();
  return chord / (2 * std::cos(0.5 * bend.angle));
}

/// The bend of at most the radius whose tangents are at most `room` long.
Bend FitBend(double angle, double radius, double room) {
  Bend bend = MakeBend(angle, radius, kTransition * radius);
  double tangent = TangentLength(bend);
  if (tangent > room) {
    // The tangents give up a little more than half of what the transition does.
    bend = MakeBend(angle, radius, std::max(0.0, bend.transition - 2 * (tangent - room)));
    tangent = TangentLength(bend);
  }
  const double scale = std::min(1.0, room / tangent);
  return {angle, scale * bend.radius, scale * bend.transition};
}

double TurnAt(const Eigen::Vector2d& before, const Eigen::Vector2d& after) {
  return std::atan2(before.y() * after.x() - before.x() * after.y(), before.dot(after));
}

void AddStraight(const Eigen::Vector2d& end, double step, std::vector<Eigen::Vector2d>& path) {
  const Eigen::Vector2d start = path.back();
  const double length = (end - start).norm();
  if (length < 0.01 * step) {
    path.back() = end;
    return;
  }
  const int count = std::max(1, static_cast<int>(std::ceil(length / step - 1e-9)));
  for (int i = 1; i <= count; ++i) path.push_back(start + (end - start) * (static_cast<double>(i) / count));
}

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

void RouteLeg::Check() const {
  if (points.size() < 2) throw InputError("leg.points: has to have two points or more");
  if (!speeds.empty() && speeds.size() != points.size()) throw InputError("leg.speeds: has to be empty or one a point");
  double length = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) throw InputError("leg.points: has to be finite");
    if (i > 0) length += (points[i] - points[i - 1]).norm();
    if (speeds.empty() || (speeds[i] >= 0 && speeds[i] <= kMaxSpeed)) continue;
    throw InputError(fmt::format(
        "leg.speeds: is {:.6g} m/s after {:.1f} m; it has to be in 0...{} m/s: check that a recording is in metres and "
        "seconds",
        speeds[i], length, kMaxSpeed));
  }
  if (!(length >= 0.1)) throw InputError("leg.points: the leg must be at least 0.1 m long");
  if (!(speed > 0 && speed <= kMaxSpeed)) throw InputError("leg.speed: has to be positive and at most 100 m/s");
  if (!(wait >= 0 && wait <= 3600)) throw InputError("leg.wait: has to be in 0...3600 s");
}

std::vector<Eigen::Vector2d> RoundCorners(const std::vector<Eigen::Vector2d>& corners, double radius, double step) {
  if (corners.size() < 2) throw InputError("corners: at least two are needed");
  if (!(radius > 0) || !std::isfinite(radius)) throw InputError("radius: has to be positive");
  if (!(step > 0)) throw InputError("step: has to be positive");
  std::vector<Eigen::Vector2d> directions;
  std::vector<double> room;
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const double length = (corners[i + 1] - corners[i]).norm();
    if (!(length > 1e-6))
      throw InputError("corners: number " + std::to_string(i + 1) + " coincides with the one before");
    directions.emplace_back((corners[i + 1] - corners[i]) / length);
    const bool has_two_corners = i > 0 && i + 2 < corners.size();
    room.push_back(has_two_corners ? 0.5 * length : length);
  }
  std::vector<Eigen::Vector2d> path = {corners.front()};
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const double angle = TurnAt(directions[i - 1], directions[i]);
    if (std::abs(angle) > kMaxTurn) throw InputError("corners: number " + std::to_string(i) + " turns back");
    if (std::abs(angle) < 1e-6) continue;
    const Bend bend = FitBend(angle, radius, std::min(room[i - 1], room[i]));
    const Eigen::Vector2d ahead = directions[i - 1];
    const Eigen::Vector2d right(ahead.y(), -ahead.x());
    const Eigen::Vector2d start = corners[i] - TangentLength(bend) * ahead;
    AddStraight(start, step, path);
    for (const Eigen::Vector2d& point : Trace(bend, step))
      path.emplace_back(start + right * point.x() + ahead * point.y());
  }
  AddStraight(corners.back(), step, path);
  return path;
}

double PathLength(const std::vector<Eigen::Vector2d>& points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

void CutLegs(double metres, std::vector<RouteLeg>& legs) {
  constexpr double kShortestLeg = 5;
  double left = metres;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    if (i > 0 && left < kShortestLeg) {
      legs.resize(i);
      return;
    }
    std::vector<Eigen::Vector2d>& points = legs[i].points;
    double length = 0;
    for (std::size_t k = 1; k < points.size(); ++k) {
      length += (points[k] - points[k - 1]).norm();
      if (length >= std::max(left, kShortestLeg)) points.resize(k + 1);
    }
    left -= length;
  }
}

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

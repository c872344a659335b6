// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/simulation/route.h"

namespace turnscale {

/// An angle of the body on its springs: a damped oscillator.
struct Suspension {
  double angle = 0;  ///< rad
  double rate = 0;   ///< rad/s

  /// Goes on by `dt` seconds towards `target` (rad), with a natural frequency in Hz. Movements that nobody could see
  /// end at a target of zero: at rest the angle is zero exactly.
  void Step(double target, double frequency, double dt);
};

/// Unevenness of a road: a smooth random function of the distance with mean 0 and standard deviation 1. It has waves
/// of 2 to 25 m, up to 5 Hz at 10 m/s.
class RoadNoise {
 public:
  explicit RoadNoise(unsigned long long seed);
  double At(double distance) const;

 private:
  struct Wave {
    double frequency = 0;  // rad/m
    double phase = 0;
  };
  std::vector<Wave> waves_;
};

/// How much of the unevenness is felt at a speed (m/s, of either sign): 1 at 10 m/s, nothing at standstill.
double RoadNoiseGain(double speed);

/// A car on a plane: a bicycle with a rear axle that slips.
struct CarOptions {
  double wheelbase = 2.7;               ///< metres
  double max_steering_deg = 38;         ///< of the front wheels, to either side
  double max_steering_rate_deg = 45;    ///< per second
  double slip_deg_per_g = 3;            ///< slip angle of the rear axle for a lateral acceleration of 9.81 m/s^2
  double max_acceleration = 1.8;        ///< m/s^2, along the path
  double max_deceleration = 2.5;        ///< m/s^2
  double max_lateral_acceleration = 3;  ///< m/s^2: curves are taken no faster
  double pitch_deg_per_g = 4;           ///< nose up when accelerating
  double roll_deg_per_g = 5;            ///< outwards in a curve
  double suspension_hz = 1.4;           ///< natural frequency of pitch and roll, damped at 0.4
  double road_noise_deg = 0.1;          ///< standard deviation of pitch and roll from the road's unevenness, at 10 m/s

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
  /// c of L_eff = L - c v^2 (s^2/m) that this slip amounts to: the rear axle moves outwards in a curve by c v^2
  /// yaw_rate (m/s), so that a camera L ahead of it moves sideways by (L - c v^2) yaw_rate. Backwards the camera is on
  /// the other side of the curve's force, and it is L + c v^2.
  double SideSlip() const;
};

/// Height of the road above y = 0 at (x, z), metres.
using RoadHeight = std::function<double(const Eigen::Vector2d&)>;

/// One moment of a simulated drive. Speeds are those over ground, seen from above: on a slope the way is longer.
struct VehicleState {
  double time = 0;                    ///< seconds
  Eigen::Vector2d position = {0, 0};  ///< (x, z) of the rear axle's centre on the road
  double heading = 0;                 ///< rad, 0 along z, positive to the right; it goes on beyond pi
  double speed = 0;                   ///< m/s along the heading, negative backwards
  double yaw_rate = 0;                ///< rad/s, positive to the right
  double steering = 0;                ///< rad, front wheels, positive to the right
  double slip = 0;  ///< rad, the rear axle's line of travel against the heading, positive to the right
  /// Vehicle frame: centre of the rear axle, turned with the body. Its rotation is that of YawPitchRoll (geometry): the
  /// heading; pitch, nose up; roll, to the right. The body pitches and rolls about the rear axle's centre.
  RigidTransform world_from_vehicle;
};

/// A drive, densely in time.
class VehicleMotion {
 public:
  /// `states` are `interval` seconds apart, from time 0. Throws InternalError when there are none.
  VehicleMotion(std::vector<VehicleState> states, double interval);

  /// State at a time within [0, duration()], interpolated between the simulated moments, which are so dense that this
  /// costs less than 1e-5 m and 1e-6 rad; clamped outside.
  VehicleState At(double time) const;
  double duration() const;

 private:
  std::vector<VehicleState> states_;
  double interval_;
};

/// Drives the legs one after the other, a path follower at the wheel. The rear axle stays within decimetres of the
/// points and moves as the bicycle with slip does, not as the points do. The car stands still where legs meet;
/// standing, it comes to rest exactly.
///
/// `axle_height` is the height of the rear axle above the road, metres. The road's slope between the axles and across
/// the track (1.5 m) tilts the body, as accelerations do, and its unevenness, which `seed` draws and which grows with
/// speed; the path is the same for all seeds.
///
/// Throws InputError when an option or a leg makes no sense, or one bends more sharply than the car can follow, and
/// InternalError when a leg does not start where the previous one ends.
VehicleMotion Drive(const CarOptions& options, const std::vector<RouteLeg>& legs, const RoadHeight& road,
                    double axle_height, unsigned seed);

}  // namespace turnscale

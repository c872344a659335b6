// SPDX-License-Identifier: MIT
#pragma once

#include <cmath>
#include <vector>

#include "turnscale/base/random.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/synthetic_drive.h"

namespace turnscale {

/// A made-up drive in an arbitrary unit, whose scale is known at every pose; for tests.
struct ScaledDrive {
  Trajectory trajectory;
  std::vector<double> metres_per_unit;  ///< of the step that ends at each pose; the first is that of the second
};

/// Blocks of streets: `corners` turns of 90 degrees, some to the left, at two speeds, with straights between.
inline std::vector<DriveSegment> CityRoute(int corners) {
  std::vector<DriveSegment> route{{60, 0.9, 0}};
  for (int i = 0; i < corners; ++i) {
    const double side = i % 3 == 1 ? -1 : 1;
    const bool fast = i % 2 == 0;
    const int steps = fast ? 45 : 30;
    for (const double share : {0.5, 1.0, 0.5}) {
      route.push_back({steps / 3, fast ? 0.7 : 0.4, side * share * 1.5 * (M_PI / 2) / steps});
    }
    route.push_back({60 + 20 * (i % 4), 0.9, 0});
  }
  return route;
}

struct DriveNoise {
  double position = 0;  ///< of each camera place, metres
  double rotation = 0;  ///< of each camera rotation, rad
  double drift = 0;     ///< of log-scale, from pose to pose
};

/// Drives a route and forgets the metre. `unit` is the length of one odometry unit in metres at the start.
inline ScaledDrive MakeScaledDrive(const std::vector<DriveSegment>& route, const LeverArm& lever_arm,
                                   const Eigen::Quaterniond& vehicle_from_camera, double unit,
                                   const DriveNoise& noise = {}, std::uint64_t seed = 1, const BodyRoll& body = {}) {
  CarDrive drive = MakeCarDrive(route, 0.1, lever_arm, vehicle_from_camera);
  RollBody(drive.world_from_camera, vehicle_from_camera, body, drive.dt);
  Random random(seed);
  const auto vector = [&](double sigma) {
    const double x = sigma * random.Gaussian();
    const double y = sigma * random.Gaussian();
    return Eigen::Vector3d(x, y, sigma * random.Gaussian());
  };
  ScaledDrive scaled;
  std::vector<Eigen::Vector3d> places;
  double log_scale = std::log(unit);
  for (std::size_t i = 0; i < drive.world_from_camera.size(); ++i) {
    const RigidTransform& pose = drive.world_from_camera[i];
    places.push_back(pose.translation + vector(noise.position));
    StampedPose stamped{drive.dt * static_cast<double>(i),
                        {pose.rotation * RotationFromVector(vector(noise.rotation)), {0, 0, 0}}};
    if (i > 0) {
      log_scale += noise.drift * random.Gaussian();
      stamped.world_from_camera.translation =
          scaled.trajectory.back().world_from_camera.translation + std::exp(-log_scale) * (places[i] - places[i - 1]);
    }
    scaled.trajectory.push_back(stamped);
    scaled.metres_per_unit.push_back(std::exp(log_scale));
  }
  return scaled;
}

}  // namespace turnscale

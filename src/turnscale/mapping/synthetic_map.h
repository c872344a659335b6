// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/random_vector.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/geometry/triangulation.h"
#include "turnscale/kinematics/synthetic_drive.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// A camera of wide images.
inline const Pinhole kTestPinhole{700, 700, 600, 180};

/// A turn to either side.
inline const std::vector<DriveSegment> kRightAndLeft = {{4, 0.8, 0}, {22, 0.7, 0.07}, {4, 0.8, 0}, {22, 0.7, -0.07}};

/// A street of points around a made-up drive, seen by one keyframe a step, for tests. Metres, pixels.
struct SyntheticStreet {
  double points_per_step = 3;
  double max_depth = 30;
  double pixel_noise = 0.3;
  unsigned seed = 1;
  double readout = 0;          ///< seconds, of a rolling shutter from the top to the bottom row
  bool reads_columns = false;  ///< from the left to the right column instead
};

/// The camera between the poses of a drive, `steps` after that of a keyframe.
inline RigidTransform CameraBetween(const CarDrive& drive, std::size_t keyframe, double steps) {
  const std::size_t next =
      steps < 0 ? std::max<std::size_t>(keyframe, 1) - 1 : std::min(keyframe + 1, drive.world_from_camera.size() - 1);
  const RigidTransform& a = drive.world_from_camera[keyframe];
  const RigidTransform& b = drive.world_from_camera[next];
  const double share = std::abs(steps);
  return RigidTransform{a.rotation.slerp(share, b.rotation), a.translation + share * (b.translation - a.translation)}
      .inverse();
}

/// The true map of a drive with noisy pixels: a KITTI-like camera that looks forward.
inline Map MakeMap(const CarDrive& drive, const SyntheticStreet& street) {
  std::mt19937 random(street.seed);
  std::normal_distribution<double> noise(0, street.pixel_noise);
  std::uniform_real_distribution<double> uniform(0, 1);
  Map map;
  map.camera.pinhole = {718, 718, 607, 185};
  map.camera.width = 1241;
  map.camera.height = 371;
  for (std::size_t i = 0; i < drive.world_from_camera.size(); ++i) {
    const double time = drive.dt * static_cast<double>(i);
    map.keyframes.push_back({.frame = static_cast<int>(i),
                             .time = time,
                             .camera_from_world = drive.world_from_camera[i].inverse(),
                             .observations = {}});
  }
  const double wanted = street.points_per_step * static_cast<double>(drive.world_from_camera.size());
  while (static_cast<double>(map.landmarks.size()) < wanted) {
    const RigidTransform& near = drive.world_from_camera[random() % drive.world_from_camera.size()];
    const double side = uniform(random) < 0.5 ? -1 : 1;
    const Eigen::Vector3d shares = DrawVector<3>([&] { return uniform(random); });
    const Eigen::Vector3d place(side * (4 + 8 * shares.x()), 1.5 - 5 * shares.y(), 20 * shares.z());
    Landmark landmark{near * place, true, {}};
    for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
      const Eigen::Vector3d x = map.keyframes[k].camera_from_world * landmark.position;
      if (x.z() < 3 || x.z() > street.max_depth) continue;
      Eigen::Vector2d pixel = map.camera.pinhole.Project(x);
      if (street.readout != 0) {
        const double share =
            (street.reads_columns ? pixel.x() / map.camera.width : pixel.y() / map.camera.height) - 0.5;
        const RigidTransform camera = CameraBetween(drive, k, street.readout * share / drive.dt);
        pixel = map.camera.pinhole.Project(camera * landmark.position);
      }
      if (pixel.x() < 0 || pixel.x() > 1240 || pixel.y() < 0 || pixel.y() > 370) continue;
      const Eigen::Vector2d seen = pixel + DrawVector<2>([&] { return noise(random); });
      landmark.observations.push_back({static_cast<int>(k), seen});
    }
    if (landmark.observations.size() < 2) continue;
    const int index = static_cast<int>(map.landmarks.size());
    for (const LandmarkObservation& seen : landmark.observations) {
      map.keyframes[seen.keyframe].observations.push_back({index, seen.pixel});
    }
    map.landmarks.push_back(landmark);
  }
  return map;
}

/// The map as it was when this many keyframes had come.
inline Map MapUpTo(int keyframes, const Map& whole) {
  constexpr double kLeastParallax = 0.5 / kDegreesPerRadian;  // as landmarks are given a depth
  Map map;
  map.camera = whole.camera;
  for (int k = 0; k < keyframes; ++k) {
    map.keyframes.push_back(whole.keyframes[k]);
    map.keyframes.back().observations.clear();
  }
  map.landmarks.resize(whole.landmarks.size());
  for (size_t i = 0; i < whole.landmarks.size(); ++i) {
    Landmark& landmark = map.landmarks[i];
    landmark.position = whole.landmarks[i].position;
    for (const LandmarkObservation& seen : whole.landmarks[i].observations)
      if (seen.keyframe < keyframes) AddObservation(map, seen.keyframe, static_cast<int>(i), seen.pixel);
    if (landmark.observations.empty()) continue;
    const auto pose = [&](const LandmarkObservation& seen) { return map.keyframes[seen.keyframe].camera_from_world; };
    landmark.valid = ParallaxAngle(pose(landmark.observations.front()), pose(landmark.observations.back()),
                                   landmark.position) > kLeastParallax;
  }
  return map;
}

}  // namespace turnscale

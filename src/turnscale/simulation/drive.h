// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/io/floor_plan_file.h"
#include "turnscale/simulation/rig.h"
#include "turnscale/simulation/vehicle.h"
#include "turnscale/simulation/world.h"

namespace turnscale {

/// One image's moment of a simulated drive.
struct DriveFrame {
  double time = 0;  ///< seconds
  VehicleState vehicle;
  RigidTransform world_from_camera;
};

/// A rig on its way through a world.
class CameraDrive {
 public:
  /// Drives the world's legs; `seed` is the road's unevenness. Throws InputError where the rig makes no sense or its
  /// car cannot follow the legs.
  CameraDrive(const World& world, const Rig& rig, unsigned seed);

  /// Images from the first moment to the last.
  int frames() const;
  /// The moment of an image, from 0.
  DriveFrame At(int frame) const;
  /// What the renderer needs to draw that image. Refers to this drive.
  View ViewAt(int frame) const;

 private:
  RigidTransform WorldFromCamera(double time) const;

  double rate_hz_;
  Shutter shutter_;
  RigidTransform vehicle_from_camera_;
  std::vector<std::function<RigidTransform(double)>> world_from_movable_;
  VehicleMotion motion_;
};

/// The texts that lie beside a simulated drive's images. All places are in the frame of the first camera.

/// `times.txt`: seconds, one per line.
std::string TimesText(const std::vector<DriveFrame>& frames);

/// `poses.txt` as KITTI has it: first_camera_from_camera, to the last bit.
std::string PosesText(const std::vector<DriveFrame>& frames);

/// `truth.csv`: per frame the car's speed, yaw rate, steering and slip, how far the camera has come since the frame
/// before, and where the rear axle is (x to the right, z ahead, the heading from z to the right).
std::string TruthText(const std::vector<DriveFrame>& frames);

/// `vehicle.yaml`: the camera's place on the car and the car's side slip, as `run` wants to know them.
std::string VehicleText(const Rig& rig);

/// The world's outlines as seen from the first camera's frame.
FloorPlan FloorPlanFrom(const RigidTransform& world_from_first_camera, const World& world);

}  // namespace turnscale

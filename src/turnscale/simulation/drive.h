// SPDX-License-Identifier: MIT
#pragma once

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

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/simulation/drive.h"

#include <cmath>

namespace turnscale {
namespace {

const Rig& Checked(const Rig& rig) {
  rig.Check();
  return rig;
}

}  // namespace

CameraDrive::CameraDrive(const World& world, const Rig& rig, unsigned seed)
    : rate_hz_(Checked(rig).rate_hz),
      shutter_(rig.ImageShutter()),
      vehicle_from_camera_(rig.mount.VehicleFromCamera()),
      world_from_movable_(world.world_from_movable),
      motion_(Drive(rig.vehicle, world.legs, world.road, kAxleHeight, seed)) {}

int CameraDrive::frames() const {
  // A drive of whole intervals has an image at its very end, rounding or not.
  return static_cast<int>(std::floor(motion_.duration() * rate_hz_ + 1e-6)) + 1;
}

DriveFrame CameraDrive::At(int frame) const {
  const double time = frame / rate_hz_;
  return {time, motion_.At(time), WorldFromCamera(time)};
}

View CameraDrive::ViewAt(int frame) const {
  const double time = frame / rate_hz_;
  View view;
  view.world_from_camera = [this, time](double since) { return WorldFromCamera(time + since); };
  for (const auto& world_from_movable : world_from_movable_) {
    view.world_from_movable.emplace_back(
        [&world_from_movable, time](double since) { return world_from_movable(time + since); });
  }
  view.shutter = shutter_;
  return view;
}

RigidTransform CameraDrive::WorldFromCamera(double time) const {
  return motion_.At(time).world_from_vehicle * vehicle_from_camera_;
}

}  // namespace turnscale

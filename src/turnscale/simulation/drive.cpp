// SPDX-License-Identifier: MIT
#include "turnscale/simulation/drive.h"

#include <cmath>

#include <fmt/format.h>

#include "turnscale/geometry/rotation.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

const Rig& Checked(const Rig& rig) {
  rig.Check();
  return rig;
}

constexpr int kAllDigits = 17;

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

std::string TimesText(const std::vector<DriveFrame>& frames) {
  std::string text;
  for (const DriveFrame& frame : frames) text += fmt::format("{}\n", frame.time);
  return text;
}

std::string PosesText(const std::vector<DriveFrame>& frames) {
  std::string text;
  for (const DriveFrame& frame : frames) {
    text += KittiLine(frames.front().world_from_camera.inverse() * frame.world_from_camera, kAllDigits);
  }
  return text;
}

std::string TruthText(const std::vector<DriveFrame>& frames) {
  std::string text = "frame,time_s,speed_mps,yaw_rate_degps,steering_deg,slip_deg,camera_step_m,x_m,z_m,heading_deg\n";
  for (size_t i = 0; i < frames.size(); ++i) {
    const DriveFrame& frame = frames[i];
    const VehicleState& car = frame.vehicle;
    const Eigen::Vector3d& before = frames[i == 0 ? 0 : i - 1].world_from_camera.translation;
    const RigidTransform axle = frames.front().world_from_camera.inverse() * car.world_from_vehicle;
    const Eigen::Vector3d ahead = axle.rotation * Eigen::Vector3d::UnitZ();
    text += fmt::format("{},{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}\n", i, frame.time, car.speed,
                        InDegrees(car.yaw_rate), InDegrees(car.steering), InDegrees(car.slip),
                        (frame.world_from_camera.translation - before).norm(), axle.translation.x(),
                        axle.translation.z(), InDegrees(std::atan2(ahead.x(), ahead.z())));
  }
  return text;
}

std::string VehicleText(const Rig& rig) {
  const CameraMount& mount = rig.mount;
  return fmt::format(
      "lever_arm: {}  # metres from the rear axle forward to the camera\n"
      "lateral_offset: {}  # metres from the car's middle to the right\n"
      "height: {}  # metres above the road\n"
      "yaw_deg: {}  # to the right\n"
      "pitch_deg: {}  # up\n"
      "roll_deg: {}  # leaning right\n"
      "side_slip: {:.6g}  # c in L_eff = L - c v^2, s^2/m\n",
      mount.lever_arm, mount.lateral_offset, mount.height, mount.yaw_deg, mount.pitch_deg, mount.roll_deg,
      rig.vehicle.SideSlip());
}

FloorPlan FloorPlanFrom(const RigidTransform& world_from_first_camera, const World& world) {
  const RigidTransform first_camera_from_world = world_from_first_camera.inverse();
  FloorPlan plan = world.floor_plan;
  for (auto& outline : plan) {
    for (Eigen::Vector2d& point : outline) {
      const Eigen::Vector3d seen = first_camera_from_world * Eigen::Vector3d(point.x(), 0, point.y());
      point = {seen.x(), seen.z()};
    }
  }
  return plan;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "street_drive.h"

#include <algorithm>

#include "street_world.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {
namespace {

constexpr double kCameraHeight = 1.5;   // metres
constexpr double kStreetStep = 0.4;     // metres a frame
constexpr double kTurnStep = 0.32;      // metres a frame: a radius of 6.5 m
constexpr int kRamp = 5;                // frames over which the steering wheel moves
constexpr double kNoise = 1.0;          // gray levels
constexpr double kHalfStreet = 6;       // metres
constexpr double kFirstCrossing = 18;   // z of the street after the right turn
constexpr double kSecondCrossing = 26;  // x of the street after the left turn

// How far the steering wheel is turned, 0..1, in this frame of a turn.
double Steering(int frame) {
  return std::clamp(std::min(frame + 0.5, kStreetTurnFrames - frame - 0.5) / kRamp, 0.0, 1.0);
}

AckermannStep StepAt(int frame) {
  const bool second = frame >= kStreetSecondTurn;
  const double steering = Steering(frame - (second ? kStreetSecondTurn : kStreetFirstTurn));
  const double full = 90.0 / kDegreesPerRadian / (kStreetTurnFrames - kRamp);
  return {(second ? -full : full) * steering, kStreetStep + (kTurnStep - kStreetStep) * steering};
}

// Share of the step of a car that neither brakes nor stands which leads to this frame.
double ShareOfStep(const StreetDriveOptions& options, int frame) {
  if (options.standing_frames == 0) return 1;
  const int until = options.standing_at - frame + 1;
  const int since = frame - options.standing_at - options.standing_frames;
  const double share = (std::max(until, since) - 0.5) / std::max(options.braking_frames, 1);
  return options.braking_frames == 0 ? static_cast<double>(std::max(until, since) > 0) : std::clamp(share, 0.0, 1.0);
}

// After so many steps.
double LeverArmAt(const StreetDriveOptions& options, double done) {
  constexpr double kFirstStep = kStreetFirstTurn + kStreetTurnFrames + 4;
  constexpr double kLastStep = kStreetSecondTurn - 4;
  const double share = std::clamp((done - kFirstStep) / (kLastStep - kFirstStep), 0.0, 1.0);
  return kStreetLeverArm + share * (options.second_lever_arm - kStreetLeverArm);
}

// Drives on by a share of a step, from so many steps after the start.
RigidTransform DriveOn(RigidTransform world_from_vehicle, double done, double share) {
  while (share > 1e-9) {
    const int step = static_cast<int>(done + 1e-9);
    const double part = std::min(share, step + 1 - done);
    const AckermannStep whole = StepAt(step);
    world_from_vehicle = world_from_vehicle * ConstrainedVehicleMotion({part * whole.psi, part * whole.rho});
    done += part;
    share -= part;
  }
  return world_from_vehicle;
}

std::vector<Block> Streets() {
  constexpr double kFar = 100;
  const double near_first = kFirstCrossing - kHalfStreet;
  const double far_first = kFirstCrossing + kHalfStreet;
  const double left_second = kSecondCrossing - kHalfStreet;
  const double right_second = kSecondCrossing + kHalfStreet;
  std::vector<Block> blocks = {
      {{-kFar, -9, -kFar}, {-kHalfStreet, 0, kFar}},
      {{kHalfStreet, -7, -kFar}, {right_second, 0, near_first}},
      {{-kHalfStreet, -8, far_first}, {left_second, 0, kFar}},
      {{right_second, -10, -kFar}, {kFar, 0, kFar}},
      {{left_second, -8, 55}, {right_second, 0, kFar}},
  };
  // What stands on the pavements, so that depth varies along the walls.
  for (int i = 0; i < 9; ++i) {
    const double z = -4 + 6.5 * i;
    const double high = 0.9 + 0.7 * (i % 3);
    if (z < near_first - 3) {
      blocks.push_back({{-5.4, -high, z}, {-4.2, 0, z + 2}});
      blocks.push_back({{4.4, -high - 0.4, z + 3}, {5.5, 0, z + 4}});
    }
    if (z > far_first + 3) {
      blocks.push_back({{left_second + 0.6, -high, z}, {left_second + 1.8, 0, z + 2}});
      blocks.push_back({{right_second - 1.6, -high - 0.4, z + 3}, {right_second - 0.5, 0, z + 4}});
    }
  }
  for (const double x : {-3.5, 3.0, 8.5, 15.0})
    blocks.push_back({{x, -1.3, far_first - 1.5}, {x + 2, 0, far_first - 0.4}});
  return blocks;
}

// The camera at each row of a frame.
std::vector<RigidTransform> PosesOfRows(const StreetDrive& drive, size_t frame, double readout) {
  const RigidTransform& at = drive.world_from_camera[frame];
  std::vector<RigidTransform> poses(drive.camera.height, at);
  if (readout == 0) return poses;
  for (int y = 0; y < drive.camera.height; ++y) {
    const double after = readout * ((y + 0.5) / drive.camera.height - 0.5);
    const size_t other = after < 0 ? std::max<size_t>(frame, 1) - 1 : std::min(frame + 1, drive.times.size() - 1);
    if (other == frame) continue;
    const RigidTransform& to = drive.world_from_camera[other];
    const double share = after / (drive.times[other] - drive.times[frame]);
    poses[y] = {at.rotation.slerp(share, to.rotation), at.translation + share * (to.translation - at.translation)};
  }
  return poses;
}

}  // namespace

StreetDrive StreetDriveWithoutImages(const StreetDriveOptions& options) {
  StreetDrive drive;
  const LensModel lens = options.k1 == 0 ? LensModel::kPinhole : LensModel::kRadialTangential;
  const double focal_length = 280.0 * options.width / 480;
  drive.camera = {.pinhole = {focal_length, focal_length, 0.5 * (options.width - 1), 0.5 * (options.height - 1)},
                  .lens = options.fisheye ? LensModel::kEquidistant : lens,
                  .distortion = {options.k1, 0, 0, 0, 0},
                  .width = options.width,
                  .height = options.height};
  RigidTransform world_from_vehicle;
  double done = 0;
  const double steps = 1 / (options.fps * kStreetInterval);  // a frame
  const int moving = static_cast<int>(kStreetFrames / steps + 1e-9);
  const int frames = std::min(moving + options.standing_frames + options.braking_frames, options.frames);
  for (int frame = 0; frame < frames; ++frame) {
    const double share = frame > 0 ? ShareOfStep(options, frame) * steps : 0.0;
    world_from_vehicle = DriveOn(world_from_vehicle, done, share);
    done += share;
    const Eigen::Vector3d place(0, -kCameraHeight, LeverArmAt(options, done));
    drive.times.push_back(frame / options.fps);
    drive.world_from_camera.push_back(world_from_vehicle * RigidTransform{options.vehicle_from_camera, place});
  }
  return drive;
}

StreetDrive RenderStreetDrive(const StreetDriveOptions& options) {
  return RenderStreetDrives(options, {options.noise}).front();
}

std::vector<StreetDrive> RenderStreetDrives(const StreetDriveOptions& options, const std::vector<unsigned>& noises) {
  const StreetDrive plan = StreetDriveWithoutImages(options);
  const StreetWorld world(Streets());
  const std::vector<Eigen::Vector3d> rays = PixelRays(plan.camera);
  std::vector<cv::RNG> random(noises.begin(), noises.end());
  std::vector<StreetDrive> drives(noises.size(), plan);
  cv::Mat ideal;
  for (size_t frame = 0; frame < plan.times.size(); ++frame) {
    const RigidTransform& pose = plan.world_from_camera[frame];
    const bool stands = frame > 0 && pose.translation == plan.world_from_camera[frame - 1].translation;
    if (!stands) ideal = world.Render(plan.camera, rays, PosesOfRows(plan, frame, options.readout));
    for (size_t i = 0; i < drives.size(); ++i) {
      cv::Mat noise(ideal.size(), CV_16S);
      random[i].fill(noise, cv::RNG::NORMAL, 0, kNoise);
      cv::Mat image;
      cv::add(ideal, noise, image, cv::noArray(), CV_8U);
      drives[i].images.push_back(image);
    }
  }
  return drives;
}

}  // namespace turnscale

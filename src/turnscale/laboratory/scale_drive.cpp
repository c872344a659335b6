// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/scale_drive.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/window_problem.h"

namespace turnscale {
namespace {

/// Of a landmark's first depth, relative.
constexpr double kDepthNoise = 0.1;
constexpr int kMostIterations = 40;
constexpr double kCostTolerance = 1e-7;

std::vector<int> KeyframesOf(const ScaleDriveOptions& options, const std::vector<VehicleStep>& steps) {
  std::vector<int> keyframes = {0};
  double turned = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const int frame = static_cast<int>(i) + 1;
    turned += steps[i].psi;
    if (frame - keyframes.back() < options.keyframe_frames && std::abs(turned) < options.keyframe_angle) continue;
    keyframes.push_back(frame);
    turned = 0;
  }
  return keyframes;
}

/// A point near the path, in the world.
Eigen::Vector3d RandomPoint(const ScaleDriveOptions& options, const Trajectory& path, Random& random) {
  const StampedPose& pose = path[random.Below(static_cast<int>(path.size()))];
  const double aside = random.Uniform(-options.points_aside, options.points_aside);
  const double height = random.Uniform(-options.points_above, options.points_below);
  const Eigen::Vector3d x_in_auxiliary(aside, height, 0);
  return pose.world_from_camera * (options.drive.vehicle_from_camera.conjugate() * x_in_auxiliary);
}

bool Sees(const ScaleDriveOptions& options, const Eigen::Vector3d& x_in_camera) {
  if (x_in_camera.z() < options.nearest || x_in_camera.z() > options.view_limit) return false;
  const Eigen::Vector2d pixel = options.pinhole.Project(x_in_camera);
  return pixel.x() >= 0 && pixel.x() < options.image_width && pixel.y() >= 0 && pixel.y() < options.image_height;
}

/// Length of the odometry's unit after so many steps, in metres.
double UnitAt(const ScaleDriveOptions& options, std::size_t step) {
  return std::pow(1 - options.scale_loss, static_cast<double>(step));
}

/// The odometry: each true motion disturbed by itself, one after the other.
std::vector<RigidTransform> OdometryPath(const ScaleDriveOptions& options, const std::vector<RigidTransform>& truth,
                                         Random& random) {
  std::vector<RigidTransform> path = {truth[0]};
  for (std::size_t k = 1; k < truth.size(); ++k) {
    RigidTransform motion = truth[k - 1].inverse() * truth[k];
    const double x = random.Gaussian();
    const double y = random.Gaussian();
    const double z = random.Gaussian();
    motion.rotation = motion.rotation * RotationFromVector(options.rotation_noise * Eigen::Vector3d(x, y, z));
    motion.translation *= UnitAt(options, k - 1);
    path.push_back(path.back() * motion);
  }
  return path;
}

/// Sights a point from all keyframes; a point that two have seen becomes a landmark.
void AddPoint(const ScaleDriveOptions& options, const Eigen::Vector3d& point, Random& random, ScaleDrive& drive) {
  Landmark landmark;
  std::size_t first = 0;
  for (std::size_t k = 0; k < drive.world_from_camera.size(); ++k) {
    const Eigen::Vector3d x_in_camera = drive.world_from_camera[k].inverse() * point;
    if (!Sees(options, x_in_camera)) continue;
    const double u = random.Gaussian();
    const double v = random.Gaussian();
    const Eigen::Vector2d pixel = options.pinhole.Project(x_in_camera) + options.pixel_noise * Eigen::Vector2d(u, v);
    if (landmark.observations.empty()) {
      first = k;
      landmark.position = x_in_camera.z() * options.pinhole.Ray(pixel);
    }
    landmark.observations.push_back({static_cast<int>(k), pixel});
  }
  const double depth = std::exp(kDepthNoise * random.Gaussian()) * UnitAt(options, first);
  if (landmark.observations.size() < 2) return;
  landmark.position = drive.map.keyframes[first].camera_from_world.inverse() * (depth * landmark.position).eval();
  landmark.valid = true;
  const int index = static_cast<int>(drive.map.landmarks.size());
  for (const LandmarkObservation& seen : landmark.observations) {
    drive.map.keyframes[seen.keyframe].observations.push_back({index, seen.pixel});
  }
  drive.map.landmarks.push_back(std::move(landmark));
  drive.points.push_back(point);
}

}  // namespace

void ScaleDriveOptions::Check() const {
  const auto require = [](bool good, const char* what) {
    if (!good) throw InputError(what);
  };
  drive.Check();
  require(points >= 1, "points: must be at least 1");
  require(points_aside > 0, "points_aside: must be above 0 m");
  require(nearest > 0 && view_limit > nearest, "view_limit: must be above nearest, and that above 0 m");
  require(keyframe_frames >= 1, "keyframe_frames: must be at least 1");
  require(keyframe_angle > 0, "keyframe_angle: must be above 0");
  require(pixel_noise > 0, "pixel_noise: must be above 0 pixels");
  require(rotation_noise >= 0, "rotation_noise: must not be negative");
  require(scale_loss >= 0 && scale_loss < 1, "scale_loss: must lie in [0, 1)");
}

ScaleDrive MakeScaleDrive(const ScaleDriveOptions& options) {
  options.Check();
  const std::vector<VehicleStep> steps = PaperDriveSteps(options.drive);
  const Trajectory path = NoisyCameraPath(steps, options.drive, {});
  ScaleDrive drive;
  drive.pixel_noise = options.pixel_noise;
  drive.map.pinhole = options.pinhole;
  const std::vector<int> frames = KeyframesOf(options, steps);
  for (const int frame : frames) drive.world_from_camera.push_back(path[frame].world_from_camera);
  Random random(options.seed);
  const std::vector<RigidTransform> odometry = OdometryPath(options, drive.world_from_camera, random);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    drive.map.keyframes.push_back({frames[k], path[frames[k]].time, odometry[k].inverse(), {}, false});
  }
  for (int i = 0; i < options.points; ++i) AddPoint(options, RandomPoint(options, path, random), random, drive);
  return drive;
}

Map AdjustedMap(const ScaleDrive& drive) {
  Map map = drive.map;
  WindowProblem problem = MakeWindowProblem(map, {0, 1}, drive.pixel_noise);
  BundleOptions options;
  options.max_iterations = kMostIterations;
  options.huber_threshold = 0;  // the noise is Gaussian
  options.relative_cost_tolerance = kCostTolerance;
  AdjustBundle(options, problem.bundle);
  WriteBack(problem, map);
  return map;
}

}  // namespace turnscale

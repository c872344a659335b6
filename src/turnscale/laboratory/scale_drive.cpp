// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/scale_drive.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "turnscale/base/check_part.h"
#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/bundle/bundle_adjustment.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/local_bundle_adjustment.h"
#include "turnscale/mapping/map_scaling.h"

namespace turnscale {
namespace {

// KITTI 00's, pixels.
constexpr double kImageWidth = 1241;
constexpr double kImageHeight = 376;

/// Frames that become keyframes.
std::vector<int> KeyframesOf(const ScaleDriveOptions& options, const std::vector<AckermannStep>& steps) {
  std::vector<int> keyframes = {0};
  double turned = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const int frame = static_cast<int>(i) + 1;
    turned += std::abs(steps[i].psi);
    const bool turning = frame % options.turning_keyframe_frames == 0 && turned > 0;
    if (frame % options.keyframe_frames != 0 && frame % options.step_frames != 0 && !turning) continue;
    keyframes.push_back(frame);
    turned = 0;
  }
  return keyframes;
}

/// A point near the path, in the world.
Eigen::Vector3d RandomPoint(const ScaleDriveOptions& options, const Trajectory& path, Random& random) {
  // As if the road went on straight: else the last keyframes see nothing.
  const int beyond = static_cast<int>(options.points_beyond / options.drive.length * static_cast<double>(path.size()));
  const int place = random.Below(static_cast<int>(path.size()) + beyond);
  const StampedPose& pose = path[std::min(place, static_cast<int>(path.size()) - 1)];
  const double aside = random.Uniform(-options.points_aside, options.points_aside);
  const double height = random.Uniform(-options.points_above, options.points_below);
  const double ahead =
      options.drive.length / static_cast<double>(path.size()) * std::max(0, place - static_cast<int>(path.size()) + 1);
  const Eigen::Vector3d x_in_auxiliary(aside, height, ahead);
  return pose.world_from_camera * (options.drive.vehicle_from_camera.conjugate() * x_in_auxiliary);
}

bool Sees(const ScaleDriveOptions& options, const Eigen::Vector3d& x_in_camera) {
  if (x_in_camera.z() < options.nearest || x_in_camera.norm() > options.view_limit) return false;
  if (!options.within_image) return true;
  const Eigen::Vector2d pixel = options.pinhole.Project(x_in_camera);
  return pixel.x() >= 0 && pixel.x() < kImageWidth && pixel.y() >= 0 && pixel.y() < kImageHeight;
}

/// The odometry: each true motion from station to station disturbed by itself, one after the other.
std::vector<RigidTransform> OdometryPath(const ScaleDriveOptions& options, const Map& truth, Random& random) {
  std::vector<RigidTransform> path = {truth.keyframes[0].camera_from_world.inverse()};
  for (std::size_t k = 1; k < truth.keyframes.size(); ++k) {
    const int frame = truth.keyframes[k].frame;
    RigidTransform motion = truth.keyframes[k - 1].camera_from_world * truth.keyframes[k].camera_from_world.inverse();
    if (frame % options.step_frames == 0) {
      const double x = random.Gaussian();
      const double y = random.Gaussian();
      const double z = random.Gaussian();
      motion.rotation = motion.rotation * RotationFromVector(options.rotation_noise * Eigen::Vector3d(x, y, z));
    }
    motion.translation *= std::pow(1 - options.scale_loss, static_cast<double>(frame) / options.scale_loss_frames);
    path.push_back(path.back() * motion);
  }
  return path;
}

/// Sights a point from all keyframes; a point that two have seen becomes a landmark.
void AddPoint(const ScaleDriveOptions& options, const Eigen::Vector3d& point, Random& random, Map& map) {
  Landmark landmark{point, true, {}};
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Eigen::Vector3d x_in_camera = map.keyframes[k].camera_from_world * point;
    if (!Sees(options, x_in_camera)) continue;
    const double u = random.Gaussian();
    const double v = random.Gaussian();
    const Eigen::Vector2d pixel = options.pinhole.Project(x_in_camera) + options.pixel_noise * Eigen::Vector2d(u, v);
    landmark.observations.push_back({static_cast<int>(k), pixel});
  }
  if (landmark.observations.size() < 2) return;
  const int index = static_cast<int>(map.landmarks.size());
  for (const LandmarkObservation& seen : landmark.observations) {
    map.keyframes[seen.keyframe].observations.push_back({index, seen.pixel});
  }
  map.landmarks.push_back(std::move(landmark));
}

constexpr int kIterations = 20;
// Started at the truth, a step that gains less moves nothing by a noticeable part of its sigma.
constexpr double kCostTolerance = 1e-4;

}  // namespace

void ScaleDriveOptions::Check() const {
  drive.Check();
  Require(points >= 1, "points: must be at least 1");
  Require(points_aside > 0, "points_aside: must be above 0 m");
  Require(points_above + points_below > 0, "points_above, points_below: together must be above 0 m");
  Require(points_beyond >= 0, "points_beyond: must not be negative");
  Require(nearest > 0 && view_limit > nearest, "view_limit: must be above nearest, and that above 0 m");
  Require(step_frames >= 1, "step_frames: must be at least 1");
  Require(keyframe_frames >= 1, "keyframe_frames: must be at least 1");
  Require(turning_keyframe_frames >= 1, "turning_keyframe_frames: must be at least 1");
  Require(pixel_noise > 0, "pixel_noise: must be above 0 pixels");
  Require(rotation_noise >= 0, "rotation_noise: must not be negative");
  Require(scale_loss >= 0 && scale_loss < 1, "scale_loss: must lie in [0, 1)");
  Require(scale_loss_frames >= 1, "scale_loss_frames: must be at least 1");
}

ScaleDrive MakeScaleDrive(const ScaleDriveOptions& options) {
  options.Check();
  const std::vector<AckermannStep> steps = PaperDriveSteps(options.drive);
  const Trajectory path = NoisyCameraPath(steps, options.drive, {});
  ScaleDrive drive;
  drive.pixel_noise = options.pixel_noise;
  drive.truth.camera.pinhole = options.pinhole;
  for (const int frame : KeyframesOf(options, steps)) {
    if (frame % options.step_frames == 0) drive.stations.push_back(CountKeyframes(drive.truth));
    drive.truth.keyframes.push_back({.frame = frame,
                                     .time = path[frame].time,
                                     .camera_from_world = path[frame].world_from_camera.inverse(),
                                     .observations = {}});
  }
  Random random(options.seed);
  drive.odometry = OdometryPath(options, drive.truth, random);
  for (int i = 0; i < options.points; ++i) AddPoint(options, RandomPoint(options, path, random), random, drive.truth);
  return drive;
}

Map PointOdometry(const ScaleDrive& drive) {
  Map map = drive.truth;
  WindowProblem problem = MakeWindowProblem(map, {0, 1}, drive.pixel_noise);
  BundleOptions options;
  options.max_iterations = kIterations;
  options.huber_threshold = 0;  // the noise is Gaussian
  options.relative_cost_tolerance = kCostTolerance;
  const BundleSummary summary = AdjustBundle(options, problem.bundle);
  if (!summary.converged) throw NumericalError("the synthetic drive's bundle adjustment: " + summary.message);
  WriteBack(problem, map);
  return map;
}

void LoseScale(double loss, int frames, Map& map) {
  std::vector<double> factors;
  for (const Keyframe& keyframe : map.keyframes)
    factors.push_back(std::pow(1 - loss, static_cast<double>(keyframe.frame) / frames));
  ScaleMap(factors, map);
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/bundle/synthetic_drive.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>

#include "turnscale/geometry/random_vector.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

constexpr double kWidth = 1240;
constexpr double kHeight = 376;
constexpr double kNearest = 2;

Eigen::Vector3d Centre(const RigidTransform& camera_from_world) { return camera_from_world.inverse().translation; }

RigidTransform CameraAt(const Eigen::Quaterniond& camera_from_world, const Eigen::Vector3d& centre) {
  return {camera_from_world, -(camera_from_world * centre)};
}

void AddCameras(const SyntheticDriveOptions& options, SyntheticDrive& drive) {
  double heading = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int i = 0; i < options.cameras; ++i) {
    const bool turning = i > 0 && i % options.turn_every < options.turn_length;
    const double sign = (i / options.turn_every) % 2 == 0 ? 1.0 : -1.0;
    if (i > 0) {
      const double before = heading;
      heading += turning ? sign * options.turn_angle : 0.0;
      const double middle = 0.5 * (before + heading);
      // A sway of pitch and height, as of a car on its springs.
      centre += options.step * Eigen::Vector3d(std::sin(middle), 0.01 * std::sin(0.7 * i), std::cos(middle));
    }
    if (turning) drive.turning.push_back(i);
    const Eigen::Quaterniond world_from_camera = RotationFromYawPitchRoll({heading, 0.005 * std::sin(0.5 * i), 0});
    drive.truth.camera_from_world.push_back(CameraAt(world_from_camera.conjugate(), centre));
  }
}

bool Sees(const BundleProblem& problem, int camera, const Eigen::Vector3d& point, Eigen::Vector2d& pixel) {
  const Eigen::Vector3d x_in_camera = problem.camera_from_world[camera] * point;
  if (x_in_camera.z() < kNearest) return false;
  pixel = problem.pinhole.Project(x_in_camera);
  return pixel.x() >= 0 && pixel.x() < kWidth && pixel.y() >= 0 && pixel.y() < kHeight;
}

}  // namespace

SyntheticDrive MakeSyntheticDrive(const SyntheticDriveOptions& options) {
  SyntheticDrive drive;
  BundleProblem& problem = drive.truth;
  problem.pinhole = {718, 718, 607, 185};
  AddCameras(options, drive);
  problem.camera_is_fixed.assign(options.cameras, 0);
  problem.camera_is_fixed[0] = 1;

  std::mt19937 random(options.seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  while (static_cast<int>(problem.points.size()) < options.points) {
    const int points_left = options.points - static_cast<int>(problem.points.size());
    const int observations_left = options.observations - static_cast<int>(problem.observations.size());
    const double mean_track = static_cast<double>(observations_left) / points_left;
    const int wanted = std::max(2, static_cast<int>(std::lround(mean_track * (0.5 + uniform(random)))));
    const int first = std::min(static_cast<int>(uniform(random) * options.cameras), options.cameras - 2);
    const Eigen::Vector2d seed_pixel =
        DrawVector<2>([&] { return uniform(random); }).cwiseProduct(Eigen::Vector2d(kWidth, kHeight));
    const double depth = 5 + 40 * uniform(random) * uniform(random);
    const Eigen::Vector3d point =
        problem.camera_from_world[first].inverse() * (depth * problem.pinhole.Ray(seed_pixel)).eval();
    std::vector<BundleObservation> track;
    const int point_index = static_cast<int>(problem.points.size());
    const auto add = [&](int camera) {
      Eigen::Vector2d pixel;
      if (!Sees(problem, camera, point, pixel)) return false;
      track.push_back({camera, point_index, pixel, 1.0});
      return true;
    };
    for (int i = first; i < options.cameras && static_cast<int>(track.size()) < wanted && add(i); ++i) {
    }
    for (int i = first - 1; i >= 0 && static_cast<int>(track.size()) < wanted && add(i); --i) {
    }
    if (track.size() < 2) continue;
    for (BundleObservation& seen : track) {
      const double noise = uniform(random) < options.outliers ? 40.0 : options.pixel_noise;
      seen.pixel += noise * DrawVector<2>([&] { return normal(random); });
    }
    problem.points.push_back(point);
    problem.observations.insert(problem.observations.end(), track.begin(), track.end());
  }
  return drive;
}

void Disturb(double position, double angle, double depth, unsigned seed, BundleProblem& problem) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return DrawVector<3>([&] { return normal(random); }); };
  std::vector<int> first_camera(problem.points.size(), -1);
  for (const BundleObservation& seen : problem.observations) {
    if (first_camera[seen.point] < 0) first_camera[seen.point] = seen.camera;
  }
  for (std::size_t i = 0; i < problem.points.size(); ++i) {
    if (first_camera[i] < 0) continue;
    const Eigen::Vector3d ray = problem.points[i] - Centre(problem.camera_from_world[first_camera[i]]);
    problem.points[i] += depth * normal(random) * ray;
  }
  for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
    if (problem.camera_is_fixed[i]) continue;
    const Eigen::Vector3d centre = Centre(problem.camera_from_world[i]) + position * vector();
    const Eigen::Quaterniond turned = RotationFromVector(angle * vector()) * problem.camera_from_world[i].rotation;
    problem.camera_from_world[i] = CameraAt(turned, centre);
  }
}

void DriftScale(double first, double last, BundleProblem& problem) {
  const std::size_t count = problem.camera_from_world.size();
  const auto scale = [&](std::size_t camera) {
    return first + (last - first) * static_cast<double>(camera) / static_cast<double>(count - 1);
  };
  std::vector<Eigen::Vector3d> before;
  for (const RigidTransform& pose : problem.camera_from_world) before.push_back(Centre(pose));
  std::vector<Eigen::Vector3d> after = {before[0]};
  for (std::size_t i = 1; i < count; ++i) after.push_back(after[i - 1] + scale(i) * (before[i] - before[i - 1]));
  std::vector<char> moved(problem.points.size(), 0);
  for (const BundleObservation& seen : problem.observations) {
    if (moved[seen.point]) continue;
    moved[seen.point] = 1;
    Eigen::Vector3d& point = problem.points[seen.point];
    point = after[seen.camera] + scale(seen.camera) * (point - before[seen.camera]);
  }
  for (std::size_t i = 0; i < count; ++i) {
    problem.camera_from_world[i] = CameraAt(problem.camera_from_world[i].rotation, after[i]);
  }
}

std::vector<DistanceConstraint> TurnDistances(const SyntheticDrive& drive, int count) {
  std::vector<DistanceConstraint> distances;
  const int available = static_cast<int>(drive.turning.size());
  const int wanted = std::min(count, available);
  for (int i = 0; i < wanted; ++i) {
    const int camera = drive.turning[static_cast<std::size_t>(i) * available / wanted];
    const double distance =
        (Centre(drive.truth.camera_from_world[camera]) - Centre(drive.truth.camera_from_world[camera - 1])).norm();
    distances.push_back({camera - 1, camera, distance});
  }
  return distances;
}

}  // namespace turnscale

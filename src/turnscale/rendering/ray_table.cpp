// SPDX-License-Identifier: MIT
#include "turnscale/rendering/ray_table.h"

#include <cmath>

#include <Eigen/Geometry>

#include "turnscale/base/error.h"
#include "turnscale/base/parallel.h"

namespace turnscale {

std::optional<Eigen::Vector3d> RayOf(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  const std::optional<Eigen::Vector2d> ideal = camera.Undistort(pixel);
  if (!ideal) return std::nullopt;
  return camera.pinhole.Ray(*ideal).normalized();
}

RayTable::RayTable(const CameraModel& camera, int threads) : camera_(camera) {
  if (camera.width < 2 || camera.height < 2) throw InternalError("the camera has no image size");
  rays_.resize(static_cast<size_t>(camera.width) * camera.height);
  ForEachIndex(camera.height, threads, [&](int row) {
    for (int column = 0; column < camera.width; ++column) {
      const std::optional<Eigen::Vector3d> ray = RayOf(camera, Eigen::Vector2d(column, row));
      if (!ray) continue;
      PixelRay& pixel = rays_[static_cast<size_t>(row) * camera.width + column];
      pixel.direction = ray->cast<float>();
      pixel.width = 1;
    }
  });
  std::vector<float> widths(rays_.size());
  ForEachIndex(camera.height, threads, [&](int row) {
    for (int column = 0; column < camera.width; ++column) {
      if (!At(row, column).sees()) continue;
      // A pixel without a neighbour that sees stays dark.
      const Eigen::Vector3f across = Step(row, column, 0, 1);
      const Eigen::Vector3f down = Step(row, column, 1, 0);
      widths[static_cast<size_t>(row) * camera.width + column] = std::sqrt(across.cross(down).norm());
    }
  });
  for (size_t i = 0; i < rays_.size(); ++i) rays_[i].width = widths[i];
}

// How the ray changes to the next pixel in a direction; where there is none, as from the one opposite.
Eigen::Vector3f RayTable::Step(int row, int column, int down, int right) const {
  const Eigen::Vector3f& here = At(row, column).direction;
  for (const int sign : {1, -1}) {
    const int r = row + sign * down;
    const int c = column + sign * right;
    if (r < 0 || c < 0 || r >= camera_.height || c >= camera_.width) continue;
    const Eigen::Vector3f& there = At(r, c).direction;
    if (!there.isZero(0)) return static_cast<float>(sign) * (there - here);
  }
  return Eigen::Vector3f::Zero();
}

Eigen::Vector3f RayTable::Inside(int row, int column, const Eigen::Vector2f& offset) const {
  const int right = offset.x() < 0 ? -1 : 1;
  const int down = offset.y() < 0 ? -1 : 1;
  const Eigen::Vector3f direction = At(row, column).direction + std::abs(offset.x()) * Step(row, column, 0, right) +
                                    std::abs(offset.y()) * Step(row, column, down, 0);
  return direction.normalized();
}

std::shared_ptr<const RayTable> RayTableCache::Get(const CameraModel& camera, int threads) {
  const std::scoped_lock lock(mutex_);
  if (!table_ || !(table_->camera() == camera)) table_ = std::make_shared<RayTable>(camera, threads);
  return table_;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/features/synthetic_texture.h"
#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// Boards at several depths before a wall, each with its own pattern.
class Boards {
 public:
  explicit Boards(unsigned seed) {
    const Eigen::Array4d places[] = {{-3.2, -0.8, 1.4, 1.6}, {-1.2, 0.9, 1.2, 1.1}, {0.6, -0.9, 1.3, 1.1},
                                     {2.2, 0.5, 1.5, 1.4},   {-2.4, 0.9, 0.9, 0.8}, {4.0, -1.0, 1.6, 1.5}};
    const double depths[] = {7, 5, 6, 8, 4.5, 9};
    for (size_t i = 0; i < std::size(depths); ++i)
      boards_.push_back({depths[i], places[i], SyntheticTexture(seed + static_cast<unsigned>(i), 8, 60)});
    std::ranges::sort(boards_, {}, &Board::depth);
    boards_.push_back({14, {0, 0, 100, 100}, SyntheticTexture(seed + 100, 8, 60)});
  }

  cv::Mat Seen(const CameraModel& camera, const RigidTransform& camera_from_world) const {
    const RigidTransform world_from_camera = camera_from_world.inverse();
    return MakeImage({camera.width, camera.height}, [&](const Eigen::Vector2d& pixel) {
      const Eigen::Vector3d ray = world_from_camera.rotation * camera.pinhole.Ray(pixel);
      for (const Board& board : boards_) {
        const double distance = (board.depth - world_from_camera.translation.z()) / ray.z();
        const Eigen::Vector2d place = (world_from_camera.translation + distance * ray).head<2>();
        if (std::abs(place.x() - board.place[0]) < board.place[2] &&
            std::abs(place.y() - board.place[1]) < board.place[3])
          return board.texture.At(place * camera.pinhole.fx / board.depth);
      }
      return 0.0;
    });
  }

  double DepthAt(const Eigen::Vector3d& ray) const {
    for (const Board& board : boards_) {
      const Eigen::Vector2d place = board.depth * ray.head<2>();
      if (std::abs(place.x() - board.place[0]) < board.place[2] &&
          std::abs(place.y() - board.place[1]) < board.place[3])
        return board.depth;
    }
    return 0;
  }

 private:
  struct Board {
    double depth = 0;
    Eigen::Array4d place;  // centre and half size, metres
    SyntheticTexture texture;
  };
  std::vector<Board> boards_;
};

inline CameraModel SmallCamera() {
  CameraModel camera;
  camera.pinhole = {300, 300, 240, 120};
  camera.width = 480;
  camera.height = 240;
  return camera;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/rendering/renderer.h"
#include "turnscale/rendering/tracer.h"

namespace turnscale {

/// Where a pixel looks, in the camera frame.
struct PixelRay {
  Eigen::Vector3f direction = Eigen::Vector3f::Zero();  ///< unit; zero where the lens sees nothing
  float width = 0;                                      ///< angle that the pixel covers, radians

  bool sees() const { return width > 0; }
};

/// The rays of all pixels of a camera: lens models are costly to invert.
class RayTable {
 public:
  /// Throws InternalError for a camera without an image size.
  RayTable(const CameraModel& camera, int threads);

  const CameraModel& camera() const { return camera_; }
  const PixelRay& At(int row, int column) const { return rays_[static_cast<size_t>(row) * camera_.width + column]; }

  /// Ray through a point of a pixel that sees, `offset` from its centre (within half a pixel).
  Eigen::Vector3f Inside(int row, int column, const Eigen::Vector2f& offset) const;

 private:
  Eigen::Vector3f Step(int row, int column, int down, int right) const;

  CameraModel camera_;
  std::vector<PixelRay> rays_;
};

/// Direction of a pixel in the camera frame, unit; nothing where the lens sees nothing in front of the image plane.
std::optional<Eigen::Vector3d> RayOf(const CameraModel& camera, const Eigen::Vector2d& pixel);

/// Keeps the table of the camera that was asked for last. Safe to use from several threads.
class RayTableCache {
 public:
  std::shared_ptr<const RayTable> Get(const CameraModel& camera, int threads);

 private:
  std::mutex mutex_;
  std::shared_ptr<const RayTable> table_;
};

/// Where the camera is at a moment.
struct CameraMoment {
  Eigen::Matrix3f world_from_camera = Eigen::Matrix3f::Identity();
  Eigen::Vector3f position = Eigen::Vector3f::Zero();
  float time = 0.5F;  ///< of the whole shutter's time, as Ray::time
};

/// Moments of each row, `samples` evenly over its exposure.
std::vector<std::vector<CameraMoment>> RowPoses(const View& view, int rows, int samples);

/// What is needed to draw a frame.
struct FrameDrawing {
  const Tracer& tracer;
  const RayTable& table;
  std::vector<std::vector<CameraMoment>> moments;  ///< by row
  int threads = 1;
  cv::Mat covered = {};  ///< as View::covered

  /// Whether the lens sees something at the pixel, and nothing hides it.
  bool Wants(int row, int column) const {
    return table.At(row, column).sees() && (covered.empty() || covered.at<uchar>(row, column) == 0);
  }
};

/// One ray through the centre of every pixel; at the edges of things `edge_samples` over the pixel.
cv::Mat DrawSharp(const FrameDrawing& drawing, int edge_samples);

/// A ray for every moment of a row through each of its pixels, spread over the pixel.
cv::Mat DrawBlurred(const FrameDrawing& drawing);

}  // namespace turnscale

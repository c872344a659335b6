// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "turnscale/rendering/ray_table.h"
#include "turnscale/rendering/renderer.h"
#include "turnscale/rendering/tracer.h"

namespace turnscale {

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
};

/// One ray through the centre of every pixel; at the edges of things `edge_samples` over the pixel.
cv::Mat DrawSharp(const FrameDrawing& drawing, int edge_samples);

/// A ray for every moment of a row through each of its pixels, spread over the pixel.
cv::Mat DrawBlurred(const FrameDrawing& drawing);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/rendering/scene.h"

namespace turnscale {

struct RenderOptions {
  /// Samples of a pixel at an edge of something; one elsewhere.
  int edge_samples = 8;
  /// Samples of every pixel where the exposure is not instantaneous.
  int blur_samples = 8;
  /// Threads that share the rows; the image does not depend on them.
  int threads = 2;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// When which row of the image is exposed, around the frame's time.
struct Shutter {
  double exposure = 0;  ///< seconds that each row gathers light; its middle is the row's time
  double readout = 0;   ///< seconds from the first row's time to the last one's; the middle row's is the frame's
};

/// What there is to a frame: poses as functions of the time since the frame's own (s).
struct View {
  std::function<RigidTransform(double)> world_from_camera;
  /// World from each of Scene::movable. Empty where there are none.
  std::vector<std::function<RigidTransform(double)>> world_from_movable;
  Shutter shutter;
  /// CV_8U of the camera's size: pixels other than 0 are not drawn but stay black, as something hides them. Empty:
  /// none.
  cv::Mat covered = {};
};

/// Draws a scene through a camera by casting rays (Embree). Same scene, same view, same image, on any number of
/// threads.
class Renderer {
 public:
  /// Takes light to every vertex of the scene (ambient light where nothing is near, lamps with soft shadows).
  Renderer(const RenderOptions& options, Scene scene);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  /// CV_32F brightness, linear: 1 is a white surface in full light. Pixel centres at integer coordinates.
  /// Black where the lens sees nothing.
  cv::Mat Render(const CameraModel& camera, const View& view) const;

  /// Distance along the ray of a pixel to what it shows at the frame's time, metres; infinite for the sky.
  double Distance(const CameraModel& camera, const View& view, const Eigen::Vector2d& pixel) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace turnscale

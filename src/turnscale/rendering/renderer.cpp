// SPDX-License-Identifier: MIT
#include "turnscale/rendering/renderer.h"

#include <limits>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/rendering/frame_drawing.h"
#include "turnscale/rendering/light.h"
#include "turnscale/rendering/ray_scene.h"
#include "turnscale/rendering/tracer.h"

namespace turnscale {
namespace {

// Poses of a movable mesh that are handed to the ray caster when the shutter takes time: between them it moves evenly.
constexpr int kPosesInMotion = 5;

void CheckScene(const Scene& scene) {
  const int materials = static_cast<int>(scene.materials.size());
  CheckMesh(scene.fixed, materials);
  for (const Mesh& mesh : scene.movable) CheckMesh(mesh, materials);
  for (const Material& material : scene.materials)
    if (material.pattern < 0 || static_cast<size_t>(material.pattern) >= scene.patterns.size())
      throw InternalError("a material has no such pattern");
}

Scene Baked(const RayScene& rays, int threads, Scene scene) {
  BakeLight(rays, threads, scene);
  return scene;
}

}  // namespace

struct Renderer::State {
  State(const RenderOptions& given, Scene scene)
      : options(given), rays(scene), lit(Baked(rays, given.threads, std::move(scene)), given.threads) {}

  Tracer TracerFor(const View& view) const {
    if (view.world_from_movable.size() != lit.scene.movable.size())
      throw InternalError("a view has a pose for each movable mesh");
    const double span = view.shutter.exposure + view.shutter.readout;
    const int count = span > 0 ? kPosesInMotion : 1;
    std::vector<std::vector<RigidTransform>> poses;
    std::vector<Eigen::Matrix3f> rotations;
    for (const auto& world_from_mesh : view.world_from_movable) {
      std::vector<RigidTransform>& steps = poses.emplace_back();
      for (int i = 0; i < count; ++i)
        steps.push_back(world_from_mesh(count > 1 ? span * (static_cast<double>(i) / (count - 1) - 0.5) : 0.0));
      rotations.push_back(steps[count / 2].rotation.toRotationMatrix().cast<float>());
    }
    return {lit, rays.Place(poses), rotations};
  }

  RenderOptions options;
  RayScene rays;
  LitScene lit;
  mutable RayTableCache tables;
};

void RenderOptions::Check() const {
  if (edge_samples < 1 || edge_samples > 256) throw InputError("render.edge_samples: has to be in 1...256");
  if (blur_samples < 1 || blur_samples > 256) throw InputError("render.blur_samples: has to be in 1...256");
  if (threads < 1 || threads > 1024) throw InputError("render.threads: has to be in 1...1024");
}

Renderer::Renderer(const RenderOptions& options, Scene scene) {
  options.Check();
  CheckScene(scene);
  state_ = std::make_unique<State>(options, std::move(scene));
}

Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

cv::Mat Renderer::Render(const CameraModel& camera, const View& view) const {
  if (!view.covered.empty() &&
      (view.covered.type() != CV_8U || view.covered.size() != cv::Size(camera.width, camera.height)))
    throw InternalError("what covers a view has the size of its image");
  const std::shared_ptr<const RayTable> table = state_->tables.Get(camera, state_->options.threads);
  const Tracer tracer = state_->TracerFor(view);
  const bool blurred = view.shutter.exposure > 0;
  const FrameDrawing drawing = {tracer, *table,
                                RowPoses(view, camera.height, blurred ? state_->options.blur_samples : 1),
                                state_->options.threads, view.covered};
  return blurred ? DrawBlurred(drawing) : DrawSharp(drawing, state_->options.edge_samples);
}

double Renderer::Distance(const CameraModel& camera, const View& view, const Eigen::Vector2d& pixel) const {
  const std::optional<Eigen::Vector3d> direction = RayOf(camera, pixel);
  if (!direction) return std::numeric_limits<double>::infinity();
  View still = view;
  still.shutter = {};
  const RigidTransform world_from_camera = view.world_from_camera(0);
  Ray ray;
  ray.origin = world_from_camera.translation.cast<float>();
  ray.direction = (world_from_camera.rotation * *direction).cast<float>();
  Seen seen;
  state_->TracerFor(still).Trace({&ray, 1}, {&seen, 1});
  return seen.distance;
}

}  // namespace turnscale

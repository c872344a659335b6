// SPDX-License-Identifier: MIT
#include "turnscale/export/blender_scene.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include <nlohmann/json.hpp>

#include "turnscale/base/base64.h"
#include "turnscale/base/error.h"
#include "turnscale/geometry/level_frame.h"

namespace turnscale {
namespace {

using Json = nlohmann::ordered_json;

// Numbers of the glTF format.
constexpr int kFloat = 5126;
constexpr int kPoints = 0;
constexpr int kLineStrip = 3;

// Collects arrays of floats in one buffer.
class Buffer {
 public:
  Json views = Json::array();
  Json accessors = Json::array();

  // Returns the accessor's number.
  int Add(const std::vector<float>& values, int width) {
    const size_t begin = bytes_.size();
    for (const float value : values) {
      const auto bits = std::bit_cast<uint32_t>(value);
      for (int shift = 0; shift < 32; shift += 8) bytes_ += static_cast<char>(bits >> shift & 0xFFU);
    }
    std::vector<float> low(width, std::numeric_limits<float>::max());
    std::vector<float> high(width, std::numeric_limits<float>::lowest());
    for (size_t i = 0; i < values.size(); ++i) {
      low[i % width] = std::min(low[i % width], values[i]);
      high[i % width] = std::max(high[i % width], values[i]);
    }
    views.push_back({{"buffer", 0}, {"byteOffset", begin}, {"byteLength", bytes_.size() - begin}});
    constexpr std::array kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    accessors.push_back({{"bufferView", views.size() - 1},
                         {"componentType", kFloat},
                         {"count", values.size() / width},
                         {"type", kTypes[width - 1]},
                         {"min", low},
                         {"max", high}});
    return static_cast<int>(accessors.size()) - 1;
  }

  Json Whole() const {
    return {{"byteLength", bytes_.size()}, {"uri", "data:application/octet-stream;base64," + Base64(bytes_)}};
  }

 private:
  std::string bytes_;
};

void Append(std::vector<float>& values, const Eigen::Vector3d& vector) {
  for (int axis = 0; axis < 3; ++axis) values.push_back(static_cast<float>(vector[axis]));
}

// Level axes (right, ahead, up) to glTF's (right, up, back), with the first pose at the origin.
struct SceneAxes {
  Eigen::Quaterniond from_world;
  Eigen::Vector3d origin;

  Eigen::Vector3d operator*(const Eigen::Vector3d& in_world) const { return from_world * (in_world - origin); }
};

SceneAxes AxesOf(const Trajectory& poses, const Eigen::Quaterniond& vehicle_from_body) {
  Eigen::Matrix3d scene_from_level;
  scene_from_level << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return {Eigen::Quaterniond(scene_from_level) * LevelFromWorld(poses, vehicle_from_body),
          poses.front().world_from_camera.translation};
}

// Numbers of the accessors of an animation.
struct CameraMotion {
  int time = 0;  // seconds since the first pose
  int position = 0;
  int rotation = 0;
};

CameraMotion AddMotion(const Trajectory& poses, const SceneAxes& axes, Buffer& buffer) {
  // The camera of glTF looks along its -z, with y up.
  const Eigen::Quaterniond camera_from_gltf(Eigen::Vector4d(1, 0, 0, 0));
  std::vector<float> times;
  std::vector<float> positions;
  std::vector<float> rotations;
  Eigen::Quaterniond last = Eigen::Quaterniond::Identity();
  for (const StampedPose& pose : poses) {
    times.push_back(static_cast<float>(pose.time - poses.front().time));
    Append(positions, axes * pose.world_from_camera.translation);
    Eigen::Quaterniond rotation = (axes.from_world * pose.world_from_camera.rotation * camera_from_gltf).normalized();
    // Of the two quaternions of a rotation the one near the last: they are interpolated.
    if (rotation.dot(last) < 0) rotation.coeffs() = -rotation.coeffs();
    last = rotation;
    for (int k = 0; k < 4; ++k) rotations.push_back(static_cast<float>(rotation.coeffs()[k]));
  }
  // One after the other: the order of the arrays in the file.
  const int time = buffer.Add(times, 1);
  const int position = buffer.Add(positions, 3);
  return {time, position, buffer.Add(rotations, 4)};
}

std::vector<float> LandmarkPoints(const std::vector<Eigen::Vector3f>& landmarks, const SceneAxes& axes, int most) {
  std::vector<float> points;
  const size_t stride = landmarks.size() / most + 1;
  for (size_t i = 0; i < landmarks.size(); i += stride) Append(points, axes * landmarks[i].cast<double>());
  return points;
}

Json Mesh(const char* name, int positions, int mode) {
  return {{"name", name}, {"primitives", {{{"attributes", {{"POSITION", positions}}}, {"mode", mode}}}}};
}

// Of the first node, which is the camera.
Json Animation(const CameraMotion& motion) {
  const auto channel = [](int sampler, const char* path) {
    return Json{{"sampler", sampler}, {"target", {{"node", 0}, {"path", path}}}};
  };
  const auto sampler = [&](int output) {
    return Json{{"input", motion.time}, {"output", output}, {"interpolation", "LINEAR"}};
  };
  return {{"name", "drive"},
          {"channels", Json::array({channel(0, "translation"), channel(1, "rotation")})},
          {"samplers", Json::array({sampler(motion.position), sampler(motion.rotation)})}};
}

Json Camera(double horizontal_fov, double aspect) {
  const double vertical_fov = 2 * std::atan(std::tan(0.5 * horizontal_fov) / aspect);
  return {{"type", "perspective"}, {"perspective", {{"aspectRatio", aspect}, {"yfov", vertical_fov}, {"znear", 0.1}}}};
}

}  // namespace

std::string BlenderScene(const ResultFolder& results, const std::string& name, double horizontal_fov, double aspect,
                         int most_landmarks) {
  const Trajectory poses = results.Poses();
  if (poses.empty()) throw InputError(name + ": the run has no path");
  if (results.poses_of_vehicle) {
    throw InputError(name +
                     ": the poses are those of the rear axle, not of the camera; run again without --frame vehicle");
  }
  const SceneAxes axes = AxesOf(poses, results.vehicle_from_body);
  Buffer buffer;
  const CameraMotion motion = AddMotion(poses, axes, buffer);
  Json meshes = Json::array({Mesh("path", motion.position, kLineStrip)});
  Json nodes = {{{"name", "camera"}, {"camera", 0}}, {{"name", "path"}, {"mesh", 0}}};
  if (const auto landmarks = LandmarkPoints(results.landmarks, axes, most_landmarks); !landmarks.empty()) {
    meshes.push_back(Mesh("landmarks", buffer.Add(landmarks, 3), kPoints));
    nodes.push_back({{"name", "landmarks"}, {"mesh", 1}});
  }
  Json scene_nodes = Json::array();
  for (size_t i = 0; i < nodes.size(); ++i) scene_nodes.push_back(i);
  const Json gltf = {{"asset", {{"version", "2.0"}, {"generator", "turnscale"}}},
                     {"scene", 0},
                     {"scenes", Json::array({{{"name", name}, {"nodes", scene_nodes}}})},
                     {"nodes", nodes},
                     {"cameras", Json::array({Camera(horizontal_fov, aspect)})},
                     {"meshes", meshes},
                     {"animations", Json::array({Animation(motion)})},
                     {"accessors", buffer.accessors},
                     {"bufferViews", buffer.views},
                     {"buffers", Json::array({buffer.Whole()})}};
  return gltf.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace turnscale

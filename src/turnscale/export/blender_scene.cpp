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

}  // namespace

std::string BlenderScene(const ResultFolder& results, const std::string& name, double horizontal_fov, double aspect,
                         int most_landmarks) {
  const Trajectory poses = results.Poses();
  if (poses.empty()) throw InputError(name + ": the run has no path");
  if (results.poses_of_vehicle) {
    throw InputError(name +
                     ": the poses are those of the rear axle, not of the camera; run again without --frame vehicle");
  }
  // Level axes (right, ahead, up) to glTF's (right, up, back); and the camera looks along its -z there, with y up.
  Eigen::Matrix3d scene_from_level;
  scene_from_level << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  const Eigen::Quaterniond scene_from_world =
      Eigen::Quaterniond(scene_from_level) * LevelFromWorld(poses, results.vehicle_from_body);
  const Eigen::Quaterniond camera_from_gltf(Eigen::Vector4d(1, 0, 0, 0));
  const Eigen::Vector3d origin = poses.front().world_from_camera.translation;

  std::vector<float> times;
  std::vector<float> positions;
  std::vector<float> rotations;
  Eigen::Quaterniond last = Eigen::Quaterniond::Identity();
  for (const StampedPose& pose : poses) {
    times.push_back(static_cast<float>(pose.time - poses.front().time));
    Append(positions, scene_from_world * (pose.world_from_camera.translation - origin));
    Eigen::Quaterniond rotation = (scene_from_world * pose.world_from_camera.rotation * camera_from_gltf).normalized();
    // Of the two quaternions of a rotation the one near the last: they are interpolated.
    if (rotation.dot(last) < 0) rotation.coeffs() = -rotation.coeffs();
    last = rotation;
    for (int k = 0; k < 4; ++k) rotations.push_back(static_cast<float>(rotation.coeffs()[k]));
  }
  std::vector<float> landmarks;
  const size_t stride = results.landmarks.size() / most_landmarks + 1;
  for (size_t i = 0; i < results.landmarks.size(); i += stride)
    Append(landmarks, scene_from_world * (results.landmarks[i].cast<double>() - origin));

  Buffer buffer;
  const int time = buffer.Add(times, 1);
  const int position = buffer.Add(positions, 3);
  const int rotation = buffer.Add(rotations, 4);
  Json meshes = {
      {{"name", "path"}, {"primitives", {{{"attributes", {{"POSITION", position}}}, {"mode", kLineStrip}}}}}};
  Json nodes = {{{"name", "camera"}, {"camera", 0}}, {{"name", "path"}, {"mesh", 0}}};
  if (!landmarks.empty()) {
    meshes.push_back({{"name", "landmarks"},
                      {"primitives", {{{"attributes", {{"POSITION", buffer.Add(landmarks, 3)}}}, {"mode", kPoints}}}}});
    nodes.push_back({{"name", "landmarks"}, {"mesh", 1}});
  }
  Json scene_nodes = Json::array();
  for (size_t i = 0; i < nodes.size(); ++i) scene_nodes.push_back(i);
  const auto channel = [](int sampler, const char* path) {
    return Json{{"sampler", sampler}, {"target", {{"node", 0}, {"path", path}}}};
  };
  const double vertical_fov = 2 * std::atan(std::tan(0.5 * horizontal_fov) / aspect);
  const Json gltf = {
      {"asset", {{"version", "2.0"}, {"generator", "turnscale"}}},
      {"scene", 0},
      {"scenes", Json::array({{{"name", name}, {"nodes", scene_nodes}}})},
      {"nodes", nodes},
      {"cameras", Json::array({{{"type", "perspective"},
                                {"perspective", {{"aspectRatio", aspect}, {"yfov", vertical_fov}, {"znear", 0.1}}}}})},
      {"meshes", meshes},
      {"animations",
       Json::array(
           {{{"name", "drive"},
             {"channels", Json::array({channel(0, "translation"), channel(1, "rotation")})},
             {"samplers", Json::array({{{"input", time}, {"output", position}, {"interpolation", "LINEAR"}},
                                       {{"input", time}, {"output", rotation}, {"interpolation", "LINEAR"}}})}}})},
      {"accessors", buffer.accessors},
      {"bufferViews", buffer.views},
      {"buffers", Json::array({buffer.Whole()})}};
  return gltf.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace turnscale

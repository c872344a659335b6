// SPDX-License-Identifier: MIT
#include "turnscale/camera/camera_file.h"

#include <array>
#include <cmath>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/parse.h"
#include "turnscale/camera/camera_yaml.h"

namespace turnscale {
namespace {

// One line "P0:" and twelve numbers: the rectified camera matrix.
CameraModel CameraFromProjection(const std::string& where, std::string_view line) {
  const auto words = SplitWords(line);
  if (words.size() != 13) {
    throw InputError(where + ": P0 has " + std::to_string(words.size() - 1) + " numbers; a 3x4 matrix has 12");
  }
  std::array<double, 12> p{};
  for (size_t i = 0; i < p.size(); ++i) {
    const auto value = ParseNumber<double>(words[i + 1]);
    if (!value || !std::isfinite(*value)) {
      throw InputError(where + ": P0: '" + std::string(words[i + 1]) + "' at position " + std::to_string(i + 1) +
                       " is not a finite number");
    }
    p[i] = *value;
  }
  if (!(p[0] > 0) || !(p[5] > 0)) {
    throw InputError(where + ": P0: focal length " + std::string(words[1]) + " x " + std::string(words[6]) +
                     " is not above 0; correct the first and sixth number");
  }
  if (p[1] != 0 || p[4] != 0 || p[8] != 0 || p[9] != 0 || p[10] != 1) {
    throw InputError(where + ": P0 is not a [fx 0 cx; 0 fy cy; 0 0 1] camera matrix; skewed cameras are not supported");
  }
  CameraModel camera;
  camera.pinhole = {p[0], p[5], p[2], p[6]};
  return camera;
}

struct ProjectionLine {
  int number = 0;
  std::string text;
};

// The file's "P0:" line. Number 0 where the file is no KITTI calibration at all.
ProjectionLine FindProjection(const std::filesystem::path& path) {
  std::ifstream stream(path);
  if (!stream) throw InputError(path.string() + ": cannot be read; check the name and the permissions");
  bool has_other_cameras = false;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.starts_with("P0:")) return {number, line};
    has_other_cameras |= line.starts_with("P1:") || line.starts_with("P2:") || line.starts_with("P3:");
  }
  if (has_other_cameras) throw InputError(path.string() + ": P0 is missing; add the line 'P0:' with 12 numbers");
  return {};
}

std::string Joined(std::span<const double> numbers, const char* separator) {
  std::string text;
  for (const double number : numbers) text += (text.empty() ? "" : separator) + NumberText(number);
  return text;
}

}  // namespace

CameraModel ReadCameraFile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) throw InputError(path.string() + ": no such camera file");
  if (std::filesystem::is_directory(path, error)) throw InputError(path.string() + ": is a folder, not a camera file");
  const ProjectionLine line = FindProjection(path);
  if (line.number > 0) return CameraFromProjection(path.string() + ":" + std::to_string(line.number), line.text);
  return CameraFromYaml(YamlMap(path));
}

std::string CameraFileText(const CameraModel& camera) {
  const Pinhole& p = camera.pinhole;
  const bool fisheye = camera.lens == LensModel::kEquidistant;
  const int coefficients = fisheye ? 4 : 5;
  const std::span<const double> distortion(camera.distortion.data(), coefficients);
  const std::array<double, 9> matrix = {p.fx, 0, p.cx, 0, p.fy, p.cy, 0, 0, 1};
  return "image_width: " + std::to_string(camera.width) + "\nimage_height: " + std::to_string(camera.height) +
         "\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [" + Joined(matrix, ", ") +
         "]\ndistortion_model: " + (fisheye ? "equidistant" : "plumb_bob") +
         "\ndistortion_coefficients:\n  rows: 1\n  cols: " + std::to_string(coefficients) + "\n  data: [" +
         Joined(distortion, ", ") + "]\n";
}

std::string KittiCalibrationText(const Pinhole& p) {
  const std::array<double, 12> projection = {p.fx, 0, p.cx, 0, 0, p.fy, p.cy, 0, 0, 0, 1, 0};
  std::string text;
  for (int camera = 0; camera < 4; ++camera) {
    text.append("P").append(std::to_string(camera)).append(": ").append(Joined(projection, " ")).append("\n");
  }
  return text;
}

}  // namespace turnscale

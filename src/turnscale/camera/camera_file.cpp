// SPDX-License-Identifier: MIT
#include "turnscale/camera/camera_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/text_lines.h"
#include "turnscale/config/yaml_map.h"

namespace turnscale {
namespace {

using Names = std::vector<std::string>;

std::string HoldsNumbers(const std::vector<double>& numbers) {
  return std::string("holds ") + std::to_string(numbers.size()) + " numbers";
}

std::string FocalLengthComplaint(double fx, double fy) {
  return std::string("focal length ") + NumberText(fx) + " x " + NumberText(fy) + " is not above 0; correct it";
}

// Stores coefficients in the model's order; a lens whose coefficients are all zero is the plain pinhole.
void SetDistortion(CameraModel& camera, LensModel lens, const std::vector<double>& coefficients) {
  std::copy_n(coefficients.begin(), std::min(coefficients.size(), camera.distortion.size()), camera.distortion.begin());
  const bool plain = std::all_of(coefficients.begin(), coefficients.end(), [](double k) { return k == 0; });
  // The equidistant lens bends rays even with zero coefficients.
  camera.lens = lens == LensModel::kRadialTangential && plain ? LensModel::kPinhole : lens;
}

int ImageSide(const YamlMap& map, const std::string& key) {
  const int side = map.Integer(key);
  if (side <= 0) map.Reject(key, std::string("is ") + std::to_string(side) + "; give the image size in pixels");
  return side;
}

// The image size may be missing, but not one of its two numbers.
void SetImageSize(const YamlMap& map, const std::string& width, const std::string& height, CameraModel& camera) {
  if (!map.Has(width) && !map.Has(height)) return;
  if (!map.Has(width)) map.Reject(width, "is missing; give it as well as " + height + ", or neither");
  if (!map.Has(height)) map.Reject(height, "is missing; give it as well as " + width + ", or neither");
  camera.width = ImageSide(map, width);
  camera.height = ImageSide(map, height);
}

// Settings of ORB-SLAM's other parts, which are not about the camera.
bool OfAnotherPart(const std::string& key) {
  static const Names prefixes = {"Camera2.", "ORBextractor.", "Viewer.",    "IMU.",   "System.",
                                 "Stereo.",  "RGBD.",         "LEFT.",      "RIGHT.", "File.",
                                 "Atlas.",   "Initializer.",  "LoopClosing"};
  static const Names whole = {"ThDepth", "DepthMapFactor", "thFarPoints", "loopClosing"};
  return std::any_of(prefixes.begin(), prefixes.end(), [&](const auto& prefix) { return key.starts_with(prefix); }) ||
         std::find(whole.begin(), whole.end(), key) != whole.end();
}

void CheckOrbSlamKeys(const YamlMap& file, const std::string& lens_prefix) {
  Names known;
  for (const char* name : {"type", "width", "height", "fps", "bf", "RGB", "newWidth", "newHeight", "imageScale",
                           "lappingBegin", "lappingEnd"}) {
    known.push_back(std::string("Camera.") + name);
  }
  for (const char* name :
       {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", "p1", "p2", "overlappingBegin", "overlappingEnd"}) {
    known.push_back(lens_prefix + name);
  }
  for (const std::string& key : file.Keys()) {
    if (OfAnotherPart(key)) known.push_back(key);
  }
  file.AllowOnly(known);
}

CameraModel OrbSlamCamera(const YamlMap& file) {
  const Names keys = file.Keys();
  const bool third = std::any_of(keys.begin(), keys.end(), [](const auto& key) { return key.starts_with("Camera1."); });
  const std::string prefix = third ? "Camera1." : "Camera.";
  CheckOrbSlamKeys(file, prefix);
  CameraModel camera;
  camera.pinhole = {file.Positive(prefix + "fx"), file.Positive(prefix + "fy"), file.Number(prefix + "cx"),
                    file.Number(prefix + "cy")};
  SetImageSize(file, "Camera.width", "Camera.height", camera);
  const auto coefficient = [&](const std::string& name, bool required) {
    return required || file.Has(prefix + name) ? file.Number(prefix + name) : 0.0;
  };
  const std::string type = file.Has("Camera.type") ? file.Text("Camera.type") : "PinHole";
  if (type == "PinHole" || type == "Rectified") {
    const bool bent = file.Has(prefix + "k1");
    SetDistortion(camera, LensModel::kRadialTangential,
                  {coefficient("k1", false), coefficient("k2", bent), coefficient("p1", false),
                   coefficient("p2", false), coefficient("k3", false)});
  } else if (type == "KannalaBrandt8") {
    SetDistortion(camera, LensModel::kEquidistant,
                  {coefficient("k1", true), coefficient("k2", true), coefficient("k3", true), coefficient("k4", true)});
  } else {
    file.Reject("Camera.type", "'" + Excerpt(type) + "' is not supported; use PinHole or KannalaBrandt8");
  }
  return camera;
}

// OpenCV's matrices and ROS's maps both keep their numbers under "data".
std::vector<double> MatrixOf(const YamlMap& file, const std::string& key) {
  return file.IsMap(key) ? file.Map(key).Numbers("data") : file.Numbers(key);
}

std::string DistortionKey(const YamlMap& file) {
  return file.Has("distortion_coefficients") ? "distortion_coefficients" : "dist_coeffs";
}

void SetOpenCvDistortion(const YamlMap& file, CameraModel& camera) {
  const std::string key = DistortionKey(file);
  if (!file.Has(key)) file.Reject("distortion_coefficients", "is missing; add it (zeros for a rectified camera)");
  const std::vector<double> k = MatrixOf(file, key);
  const std::string model = file.Has("distortion_model") ? file.Text("distortion_model") : "";
  const bool fisheye =
      (file.Has("fisheye_model") && file.Integer("fisheye_model") != 0) || model == "equidistant" || model == "fisheye";
  if (fisheye) {
    if (k.size() != 4) file.Reject(key, HoldsNumbers(k) + "; a fisheye has 4");
    SetDistortion(camera, LensModel::kEquidistant, k);
    return;
  }
  static const Names radial_models = {"", "plumb_bob", "radtan", "rational_polynomial"};
  if (std::find(radial_models.begin(), radial_models.end(), model) == radial_models.end()) {
    file.Reject("distortion_model", "'" + Excerpt(model) + "' is not supported; use plumb_bob or equidistant");
  }
  if (k.size() < 4 ||
      std::any_of(k.begin() + std::min<size_t>(k.size(), 5), k.end(), [](double x) { return x != 0; })) {
    file.Reject(key, HoldsNumbers(k) + "; only k1 k2 p1 p2 [k3] are supported");
  }
  SetDistortion(camera, LensModel::kRadialTangential, k);
}

struct NamedDirection {
  const char* name;
  ReadDirection direction;
};
constexpr std::array<NamedDirection, 4> kReadDirections = {
    {{"down", {0, 1}}, {"up", {0, -1}}, {"right", {1, 0}}, {"left", {-1, 0}}}};

// The direction of the readout, if the file states it.
void SetReadDirection(const YamlMap& file, CameraModel& camera) {
  if (!file.Has("readout_direction")) return;
  const std::string name = file.Text("readout_direction");
  const auto named = std::ranges::find(kReadDirections, name, &NamedDirection::name);
  if (named == kReadDirections.end())
    file.Reject("readout_direction", "is '" + Excerpt(name) + "'; give down, up, right or left");
  camera.read_direction = named->direction;
  camera.is_read_direction_stated = true;
}

// The readout of a rolling shutter, if the file has one: as turnscale writes it, or by Kalibr's line delay (seconds).
void SetReadout(const YamlMap& file, CameraModel& camera) {
  constexpr double kLongestMs = 200;
  constexpr double kSigmaIfNotStatedMs = 0.5;
  const bool is_line_delay = !file.Has("readout_ms") && file.Has("line_delay");
  const std::string time = is_line_delay ? "line_delay" : "readout_ms";
  for (const char* key : {"readout_sigma_ms", "readout_direction"})
    if (file.Has(key) && !file.Has(time)) file.Reject(key, "needs readout_ms");
  if (!file.Has(time)) return;
  SetReadDirection(file, camera);
  const int lines = camera.read_direction.x == 0 ? camera.height : camera.width;
  const double readout_ms = file.Number(time) * (is_line_delay ? 1e3 * lines : 1);
  if (std::abs(readout_ms) > kLongestMs)
    file.Reject(time, "is longer than " + NumberText(kLongestMs) + " ms, from the first row to the last one");
  const double sigma_ms = file.Has("readout_sigma_ms") ? file.Number("readout_sigma_ms") : kSigmaIfNotStatedMs;
  if (!(sigma_ms >= 0)) file.Reject("readout_sigma_ms", "must not be negative");
  camera.readout = readout_ms / 1e3;
  // Of a global shutter, 0 would be that of a readout that is not known.
  constexpr double kLeastSigmaOfNoneMs = 0.01;
  camera.readout_sigma = (readout_ms == 0 ? std::max(sigma_ms, kLeastSigmaOfNoneMs) : sigma_ms) / 1e3;
}

CameraModel OpenCvCamera(const YamlMap& file) {
  static const Names known = {"camera_matrix",
                              "distortion_coefficients",
                              "dist_coeffs",
                              "distortion_model",
                              "image_width",
                              "image_height",
                              "camera_name",
                              "fisheye_model",
                              "rectification_matrix",
                              "projection_matrix",
                              "calibration_time",
                              "nframes",
                              "nr_of_frames",
                              "board_width",
                              "board_height",
                              "square_size",
                              "marker_size",
                              "aspectRatio",
                              "aspect_ratio",
                              "fix_aspect_ratio",
                              "flags",
                              "flagValue",
                              "avg_reprojection_error",
                              "per_view_reprojection_errors",
                              "extrinsic_parameters",
                              "image_points",
                              "grid_points",
                              "rms",
                              "header",
                              "frame_id",
                              "focal_length_sigma",
                              "pixel_aspect_sigma",
                              "principal_point_sigma",
                              "readout_ms",
                              "readout_sigma_ms",
                              "readout_direction"};
  file.AllowOnly(known);
  const std::vector<double> k = MatrixOf(file, "camera_matrix");
  if (k.size() != 9) file.Reject("camera_matrix", HoldsNumbers(k) + "; a 3x3 matrix has 9");
  if (!(k[0] > 0) || !(k[4] > 0)) {
    file.Reject("camera_matrix", FocalLengthComplaint(k[0], k[4]));
  }
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    file.Reject("camera_matrix", "is not of the form [fx 0 cx; 0 fy cy; 0 0 1]; skewed cameras are not supported");
  }
  CameraModel camera;
  camera.pinhole = {k[0], k[4], k[2], k[5]};
  SetImageSize(file, "image_width", "image_height", camera);
  SetOpenCvDistortion(file, camera);
  if (file.Has("focal_length_sigma")) camera.focal_sigma = file.Number("focal_length_sigma");
  if (!(camera.focal_sigma >= 0)) file.Reject("focal_length_sigma", "must not be negative");
  if (file.Has("pixel_aspect_sigma")) camera.aspect_sigma = file.Number("pixel_aspect_sigma");
  if (!(camera.aspect_sigma >= 0)) file.Reject("pixel_aspect_sigma", "must not be negative");
  SetReadout(file, camera);
  return camera;
}

CameraModel KalibrCamera(const YamlMap& cam) {
  static const Names known = {"camera_model", "intrinsics", "distortion_model",  "distortion_coeffs",
                              "resolution",   "rostopic",   "cam_overlaps",      "T_cam_imu",
                              "T_imu_cam",    "T_cn_cnm1",  "timeshift_cam_imu", "rolling_shutter",
                              "line_delay",   "readout_ms", "readout_sigma_ms",  "readout_direction"};
  cam.AllowOnly(known);
  if (const std::string model = cam.Text("camera_model"); model != "pinhole") {
    cam.Reject("camera_model", "'" + Excerpt(model) + "' is not supported; calibrate with 'pinhole'");
  }
  const std::vector<double> k = cam.Numbers("intrinsics");
  if (k.size() != 4) cam.Reject("intrinsics", HoldsNumbers(k) + "; give [fx, fy, cx, cy]");
  if (!(k[0] > 0) || !(k[1] > 0)) {
    cam.Reject("intrinsics", FocalLengthComplaint(k[0], k[1]));
  }
  CameraModel camera;
  camera.pinhole = {k[0], k[1], k[2], k[3]};
  const std::vector<double> size = cam.Numbers("resolution");
  const auto is_side = [](double side) {
    return side >= 1 && side <= std::numeric_limits<int>::max() && side == std::floor(side);
  };
  if (size.size() != 2 || !is_side(size[0]) || !is_side(size[1]))
    cam.Reject("resolution", "give [width, height] in whole pixels");
  camera.width = static_cast<int>(size[0]);
  camera.height = static_cast<int>(size[1]);
  SetReadout(cam, camera);
  const std::string model = cam.Text("distortion_model");
  if (model == "none") return camera;
  if (model != "radtan" && model != "equidistant") {
    cam.Reject("distortion_model", "'" + Excerpt(model) + "' is not supported; use radtan, equidistant or none");
  }
  const std::vector<double> coefficients = cam.Numbers("distortion_coeffs");
  if (coefficients.size() != 4) {
    cam.Reject("distortion_coeffs", HoldsNumbers(coefficients) + "; " + model + " has 4");
  }
  SetDistortion(camera, model == "radtan" ? LensModel::kRadialTangential : LensModel::kEquidistant, coefficients);
  return camera;
}

bool IsKeyOfCamera(const std::string& key) {
  return key == "cam0" || key == "camera_matrix" || key == "P0" || key.starts_with("Camera");
}

// A run writes car.yaml and settings.yaml beside camera.yaml.
void RefuseOtherFiles(const YamlMap& file) {
  for (const char* key : {"lever_arm", "side_slip", "yaw_deg"})
    if (file.Has(key))
      file.Reject(key, "is of a car's file, which --vehicle takes; give --camera a camera's, such as camera.yaml");
  for (const char* key : {"vehicle", "images", "scale"})
    if (file.IsMap(key))
      file.Reject(key,
                  "is of a file of settings, which --settings takes; give --camera a camera's, such as camera.yaml");
}

// For a file that may not be meant as a camera at all.
template <class Read>
auto OrSayWhatIsOne(const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) +
                     " (a camera file is a KITTI calib.txt or a YAML file of OpenCV, ORB-SLAM or Kalibr)");
  }
}

// Camera of a YAML file in the dialect of Kalibr, OpenCV, ROS or ORB-SLAM. Throws InputError.
CameraModel CameraFromYaml(const YamlMap& file) {
  const Names keys = file.Keys();
  if (file.IsMap("cam0")) return KalibrCamera(file.Map("cam0"));
  if (file.Has("camera_matrix")) return OpenCvCamera(file);
  if (std::any_of(keys.begin(), keys.end(), [](const auto& key) { return key.starts_with("Camera"); })) {
    return OrbSlamCamera(file);
  }
  RefuseOtherFiles(file);
  return OrSayWhatIsOne([&]() -> CameraModel {
    file.AllowOnly(Names{"cam0", "camera_matrix", "distortion_coefficients", "image_width", "image_height", "Camera.fx",
                         "Camera.fy", "Camera.cx", "Camera.cy", "Camera.type"});
    file.Reject("camera_matrix", "is missing");
  });
}

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
      throw InputError(where + ": P0: '" + Excerpt(words[i + 1]) + "' at position " + std::to_string(i + 1) +
                       " is not a finite number");
    }
    p[i] = *value;
  }
  if (!(p[0] > 0) || !(p[5] > 0)) {
    throw InputError(where + ": P0: focal length " + Excerpt(words[1]) + " x " + Excerpt(words[6]) +
                     " is not above 0; correct the first and sixth number");
  }
  if (p[1] != 0 || p[4] != 0 || p[8] != 0 || p[9] != 0 || p[10] != 1) {
    throw InputError(where + ": P0 is not a [fx 0 cx; 0 fy cy; 0 0 1] camera matrix; skewed cameras are not supported");
  }
  CameraModel camera;
  camera.pinhole = {p[0], p[5], p[2], p[6]};
  return camera;
}

// The camera of the file's "P0:" line; nothing where the file is no KITTI calibration at all.
std::optional<CameraModel> FindProjection(const std::filesystem::path& path) {
  bool has_other_cameras = false;
  for (TextLines lines(path, "camera file"); lines.Next();) {
    const std::string& line = lines.Line();
    if (line.starts_with("P0:")) return CameraFromProjection(lines.Where(), line);
    has_other_cameras |= line.starts_with("P1:") || line.starts_with("P2:") || line.starts_with("P3:");
  }
  if (has_other_cameras) throw InputError(path.string() + ": P0 is missing; add the line 'P0:' with 12 numbers");
  return std::nullopt;
}

std::string Joined(std::span<const double> numbers, const char* separator) {
  std::string text;
  for (const double number : numbers) text += (text.empty() ? "" : separator) + NumberText(number);
  return text;
}

}  // namespace

CameraModel ReadCameraFile(const std::filesystem::path& path) {
  if (const std::optional<CameraModel> camera = FindProjection(path)) return *camera;
  return CameraFromYaml(OrSayWhatIsOne([&] { return YamlMap(path); }));
}

std::string DoubtOfLens(const std::filesystem::path& path) {
  constexpr double kLargestTangential = 0.02;  // of lenses that are mounted straight
  if (FindProjection(path)) return {};
  const YamlMap file(path);
  const bool is_stated = file.Has("distortion_model") || file.Has("fisheye_model");
  const std::string key = DistortionKey(file);
  if (file.IsMap("cam0") || !file.Has("camera_matrix") || !file.Has(key) || is_stated) return {};
  const std::vector<double> k = MatrixOf(file, key);
  if (k.size() != 4 || std::max(std::abs(k[2]), std::abs(k[3])) <= kLargestTangential) return {};
  return path.string() + ": " + key + " are read as k1 k2 p1 p2, but p1 = " + NumberText(k[2]) +
         " and p2 = " + NumberText(k[3]) +
         " are unusually large; if they are of a fisheye lens, add distortion_model: equidistant, else plumb_bob";
}

void RefuseCameraFile(const YamlMap& file, const std::string& wanted) {
  for (const std::string& key : file.Keys())
    if (IsKeyOfCamera(key)) file.Reject(key, "is of a camera's file, which --camera takes; give " + wanted);
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
         Joined(distortion, ", ") + "]\n" +
         (camera.focal_sigma > 0 ? "focal_length_sigma: " + NumberText(camera.focal_sigma) + "\n" : "") +
         (camera.aspect_sigma > 0 ? "pixel_aspect_sigma: " + NumberText(camera.aspect_sigma) + "\n" : "") +
         (camera.is_readout_known() ? "readout_ms: " + NumberText(1e3 * camera.readout) +
                                          "\nreadout_sigma_ms: " + NumberText(1e3 * camera.readout_sigma) +
                                          "\nreadout_direction: " + ReadDirectionName(camera.read_direction) + "\n"
                                    : "");
}

std::string ReadDirectionName(const ReadDirection& direction) {
  const auto* const named = std::ranges::find(kReadDirections, direction, &NamedDirection::direction);
  return named == kReadDirections.end() ? "" : named->name;
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

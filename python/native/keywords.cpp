// SPDX-License-Identifier: MIT
#include "keywords.h"

#include <fmt/format.h>

namespace py = pybind11;

namespace turnscale {
namespace {

void TakeImages(Keywords& keywords, ImageArguments& images) {
  keywords.Take("inputs", images.inputs);
  keywords.Take("topic", images.topic);
  keywords.Take("camera", images.camera);
  std::optional<CameraModel> camera;
  keywords.Take("camera_object", camera);
  if (camera) images.camera_object = {kCameraObject, *camera, /*is_of_stored=*/false};
  keywords.Take("fov", images.field_of_view);
  keywords.Take("camera_refine", images.refine_camera);
  keywords.Take("timestamps", images.timestamps);
  keywords.Take("fps", images.fps);
  keywords.Take("rotate", images.rotate);
  keywords.Take("settings", images.settings);
  keywords.Take("mask", images.mask);
  keywords.Take("start", images.start);
  keywords.Take("end", images.end);
  keywords.Take("max_frames", images.max_frames);
  keywords.Take("quiet", images.quiet);
}

void TakeCar(Keywords& keywords, CarArguments& car) {
  keywords.Take("lever_arm", car.lever_arm);
  keywords.Take("lever_arm_sigma", car.lever_arm_sigma);
  keywords.Take("camera_height", car.camera_height);
  keywords.Take("vehicle", car.vehicle);
  keywords.Take("side_slip", car.side_slip);
  keywords.Take("side_slip_sigma", car.side_slip_sigma);
  keywords.Take("camera_rotation", car.camera_rotation);
  keywords.Take("method", car.method);
}

}  // namespace

void Keywords::RefuseKind(const char* name, const char* expected, const py::object& value) {
  constexpr size_t kMostShown = 60;
  std::string shown = py::repr(value).cast<std::string>();
  shown = shown.size() > kMostShown || shown.find('\n') != std::string::npos ? "" : " " + shown;
  throw py::type_error(fmt::format("{}: expected {}, got {}{}", name, expected,
                                   py::type::of(value).attr("__name__").cast<std::string>(), shown));
}

void Keywords::RefuseOthers() const {
  for (const auto& [name, value] : given_)
    throw py::type_error("there is no option " + py::repr(name).cast<std::string>());
}

RunArguments RunArgumentsFrom(const py::dict& given) {
  Keywords keywords(given);
  RunArguments arguments;
  TakeImages(keywords, arguments.images);
  TakeCar(keywords, arguments.car);
  keywords.Take("frame", arguments.frame);
  keywords.Take("threads", arguments.threads);
  keywords.Take("out", arguments.out);
  keywords.Take("truth", arguments.truth.truth);
  keywords.Take("floor_plan", arguments.truth.floor_plan);
  keywords.Take("no_report", arguments.no_report);
  keywords.RefuseOthers();
  return arguments;
}

CalibrateArguments CalibrateArgumentsFrom(const py::dict& given) {
  Keywords keywords(given);
  CalibrateArguments arguments;
  arguments.out.clear();
  arguments.keep_history = true;
  TakeImages(keywords, arguments.images);
  keywords.Take("trajectory", arguments.trajectory);
  keywords.Take("axes", arguments.axes);
  keywords.Take("speed", arguments.speed);
  keywords.Take("distance", arguments.distance);
  keywords.Take("metric", arguments.metric);
  keywords.Take("lever_arm", arguments.lever_arm);
  keywords.Take("side_slip", arguments.side_slip);
  keywords.Take("fit_side_slip", arguments.fit_side_slip);
  keywords.Take("history", arguments.history);
  keywords.Take("out", arguments.out);
  keywords.RefuseOthers();
  return arguments;
}

RescaleArguments RescaleArgumentsFrom(const py::dict& given) {
  Keywords keywords(given);
  RescaleArguments arguments;
  arguments.out.clear();
  keywords.Take("input", arguments.input);
  keywords.Take("lever_arm", arguments.lever_arm);
  keywords.Take("lever_arm_sigma", arguments.lever_arm_sigma);
  keywords.Take("heights", arguments.heights);
  keywords.Take("camera_height", arguments.camera_height);
  keywords.Take("side_slip", arguments.side_slip);
  keywords.Take("side_slip_sigma", arguments.side_slip_sigma);
  keywords.Take("camera_rotation", arguments.camera_rotation);
  keywords.Take("fps", arguments.fps);
  keywords.Take("timestamps", arguments.timestamps);
  keywords.Take("drift", arguments.drift);
  keywords.Take("out", arguments.out);
  keywords.Take("report", arguments.report);
  keywords.RefuseOthers();
  return arguments;
}

EvaluateArguments EvaluateArgumentsFrom(const py::dict& given) {
  Keywords keywords(given);
  EvaluateArguments arguments;
  keywords.Take("estimate", arguments.estimate);
  keywords.Take("ground_truth", arguments.ground_truth);
  keywords.Take("timestamps", arguments.timestamps);
  keywords.Take("time_tolerance", arguments.time_tolerance);
  keywords.Take("keyframes", arguments.keyframes);
  keywords.Take("camera_rotation", arguments.camera_rotation);
  std::filesystem::path json;
  keywords.Take("json", json);
  arguments.json = json.string();
  keywords.Take("picture", arguments.picture);
  keywords.Take("report", arguments.report);
  keywords.Take("floor_plan", arguments.floor_plan);
  keywords.RefuseOthers();
  return arguments;
}

OdometryArguments OdometryArgumentsFrom(const py::dict& given) {
  Keywords keywords(given);
  OdometryArguments arguments;
  TakeCar(keywords, arguments.car);
  keywords.Take("camera_name", arguments.camera_name);
  keywords.Take("settings", arguments.settings);
  keywords.Take("mask", arguments.mask);
  keywords.Take("threads", arguments.threads);
  keywords.RefuseOthers();
  return arguments;
}

}  // namespace turnscale

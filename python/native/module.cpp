// SPDX-License-Identifier: MIT
#include <cmath>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "frame_by_frame.h"
#include "keywords.h"
#include "python_hooks.h"
#include "turnscale/base/error.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/commands/rescale_report.h"
#include "turnscale/commands/version.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/run/run_summary.h"

namespace py = pybind11;

namespace turnscale {
namespace {

using Matrix4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

template <class Matrix>
py::array_t<double> Array(const Matrix& matrix) {
  return py::array_t<double>({matrix.rows(), matrix.cols()}, matrix.data());
}

py::object PoseOf(const LiveFrame& frame) {
  if (!frame.result.world_from_camera) return py::none();
  Matrix4 matrix = Matrix4::Identity();
  matrix.topLeftCorner<3, 3>() = frame.result.world_from_camera->rotation.toRotationMatrix();
  matrix.topRightCorner<3, 1>() = frame.result.world_from_camera->translation;
  return Array(matrix);
}

template <class Scalar>
py::array_t<Scalar> Points(const std::vector<Eigen::Matrix<Scalar, 3, 1>>& points) {
  static_assert(sizeof(points[0]) == 3 * sizeof(Scalar));
  return py::array_t<Scalar>({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}},
                             points.empty() ? nullptr : points[0].data());
}

// Without a copy: the array keeps the image.
py::object PixelsOf(const cv::Mat& gray) {
  if (gray.empty()) return py::none();
  const auto* kept = new cv::Mat(gray);
  const py::capsule owner(kept, [](void* image) { delete static_cast<cv::Mat*>(image); });
  const py::ssize_t step = static_cast<py::ssize_t>(gray.step[0]);
  return py::array_t<uint8_t>({py::ssize_t{gray.rows}, py::ssize_t{gray.cols}}, {step, py::ssize_t{1}}, gray.data,
                              owner);
}

CameraModel MakeCamera(double fx, double fy, double cx, double cy, int width, int height,
                       const std::vector<double>& distortion, const std::string& lens) {
  CameraModel camera;
  camera.pinhole = {fx, fy, cx, cy};
  if (!(std::isfinite(fx) && std::isfinite(fy) && fx > 0 && fy > 0))
    throw InputError("Camera: fx and fy have to be above 0, in pixels");
  if (!(std::isfinite(cx) && std::isfinite(cy))) throw InputError("Camera: cx and cy have to be finite, in pixels");
  if (width < 0 || height < 0 || (width == 0) != (height == 0))
    throw InputError("Camera: give width and height in pixels, or neither");
  camera.width = width;
  camera.height = height;
  const bool bent = std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0; });
  if (lens == "equidistant") {
    camera.lens = LensModel::kEquidistant;
  } else if (lens == "radial-tangential") {
    camera.lens = bent ? LensModel::kRadialTangential : LensModel::kPinhole;
  } else if (lens != "pinhole" || bent) {
    throw InputError("Camera: lens '" + lens +
                     "': give 'radial-tangential' or 'equidistant' with a distortion, or 'pinhole' without");
  }
  const size_t most = lens == "equidistant" ? 4 : camera.distortion.size();
  if (distortion.size() > most)
    throw InputError("Camera: distortion has " + std::to_string(distortion.size()) + " numbers; a lens '" + lens +
                     "' has at most " + std::to_string(most));
  for (size_t i = 0; i < distortion.size(); ++i) {
    if (!std::isfinite(distortion[i])) throw InputError("Camera: distortion has to be finite");
    camera.distortion[i] = distortion[i];
  }
  return camera;
}

std::string CameraRepr(const CameraModel& camera) {
  const Pinhole& pinhole = camera.pinhole;
  py::list distortion;
  for (const double k : camera.distortion) distortion.append(k);
  return py::str("Camera(fx={}, fy={}, cx={}, cy={}, width={}, height={}, distortion={}, lens='{}')")
      .format(pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy, camera.width, camera.height, distortion,
              LensModelName(camera.lens))
      .cast<std::string>();
}

// Runs a command without Python's lock. `work` is given the hooks.
template <class Hooks = CommandHooks, class Work>
void Execute(const Work& work) {
  PythonHooks python;
  Hooks hooks;
  python.Join(hooks);
  try {
    const py::gil_scoped_release release;
    const QuietLibraries quiet;
    work(hooks);
  } catch (const Interruption&) {
    // What has interrupted it is raised below.
  } catch (...) {
    python.Raise();
    throw;
  }
  python.Raise();
}

void RunDriveFor(const py::dict& given, bool keeps_folder) {
  const RunArguments arguments = RunArgumentsFrom(given);
  std::optional<RunFailure> failure;
  Execute<RunHooks>([&](const RunHooks& hooks) {
    failure = FailureOfRun(ExecuteRun(arguments, hooks));
    if (!failure) return;
    for (const std::string& other : failure->others) Warn(hooks, other);
  });
  if (!failure) return;
  if (failure->kept && keeps_folder) failure->first.message += "; the results so far are in " + arguments.out.string();
  throw FailedCommand{failure->first};
}

py::dict AnglesOf(const YawPitchRoll& angles, const char* suffix) {
  py::dict degrees;
  degrees[(std::string("yaw") + suffix).c_str()] = angles.yaw * kDegreesPerRadian;
  degrees[(std::string("pitch") + suffix).c_str()] = angles.pitch * kDegreesPerRadian;
  degrees[(std::string("roll") + suffix).c_str()] = angles.roll * kDegreesPerRadian;
  return degrees;
}

py::dict CalibrateFor(const py::dict& given) {
  const CalibrateArguments arguments = CalibrateArgumentsFrom(given);
  CalibrateOutcome outcome;
  Execute([&](const CommandHooks& hooks) { outcome = ExecuteCalibrate(arguments, hooks); });
  if (outcome.stopped) throw FailedCommand{*outcome.stopped};
  const CalibrationReport& report = *outcome.report;
  const Calibration& found = report.calibration;
  py::dict result = AnglesOf(found.angles, "_deg");
  result.attr("update")(AnglesOf(found.sigma, "_sigma_deg"));
  result["vehicle_from_camera"] = Array(Matrix3(found.vehicle_from_camera.toRotationMatrix()));
  const auto& arm = report.lever_arm;
  const auto number = [](bool known, double value) { return known ? py::object(py::float_(value)) : py::none(); };
  result["lever_arm"] = number(arm.has_value(), arm ? arm->lever_arm.length : 0);
  result["lever_arm_sigma"] = number(arm && arm->turning_steps > 0, arm ? arm->sigma_length : 0);
  result["side_slip"] = number(arm.has_value(), arm ? arm->lever_arm.side_slip : 0);
  result["side_slip_sigma"] = number(arm && arm->sigma_side_slip > 0, arm ? arm->sigma_side_slip : 0);
  result["lever_arm_slip_correlation"] = arm ? arm->slip_correlation : 0.0;
  result["confidence"] = found.linear.confidence;
  result["frames"] = report.frames;
  result["steps"] = found.steps;
  result["turns"] = found.turns;
  result["turning_deg"] = found.turning * kDegreesPerRadian;
  result["note"] = outcome.note;
  result["history"] = HistoryCsv(outcome.history);
  result["yaml"] = CalibrationYaml(report);
  return result;
}

py::dict RescaleFor(const py::dict& given) {
  const RescaleArguments arguments = RescaleArgumentsFrom(given);
  py::dict result;
  std::string tum;
  std::string scale;
  std::string turns;
  std::string summary;
  Execute([&](const CommandHooks& hooks) {
    const RescaleOutcome outcome = ExecuteRescale(arguments, hooks);
    const RescaleResult& rescaled = outcome.result;
    for (const StampedPose& pose : rescaled.metric) tum += TumLine(pose);
    scale = PoseScaleTable(rescaled);
    turns = TurnScaleTable(rescaled);
    summary = RescaleJson(rescaled, TrajectoryOf(arguments.input).string(), outcome.timed, outcome.warnings);
  });
  result["tum"] = tum;
  result["scale"] = scale;
  result["turns"] = turns;
  result["summary"] = py::bytes(summary);
  return result;
}

py::bytes EvaluateFor(const py::dict& given) {
  const EvaluateArguments arguments = EvaluateArgumentsFrom(given);
  std::string json;
  Execute([&](const CommandHooks& hooks) { json = ComparisonJson(ExecuteEvaluate(arguments, hooks)); });
  return json;
}

// Images of a drive, decoded ahead on a thread of their own.
class DriveReader {
 public:
  explicit DriveReader(const py::dict& given) : arguments_(RunArgumentsFrom(given).images) {
    CheckImageArguments(arguments_);
    Execute([&](const CommandHooks& hooks) {
      images_ = std::make_unique<DriveImages>(OpenImages(arguments_, kUnscaled));
      for (const std::string& clip : images_->source.left_out()) Warn(hooks, clip);
      if (!images_->source.notice().empty()) Warn(hooks, images_->source.notice());
    });
  }
  ~DriveReader() {
    const py::gil_scoped_release release;
    images_.reset();
  }
  DriveReader(const DriveReader&) = delete;
  DriveReader& operator=(const DriveReader&) = delete;

  SourceFrame Next() {
    std::optional<SourceFrame> frame;
    Execute([&](const CommandHooks& hooks) {
      std::vector<std::string> notices;
      frame = Read(notices);
      for (const std::string& notice : notices)
        if (!notice.empty()) Warn(hooks, notice);
    });
    if (!frame) throw py::stop_iteration();
    return *std::move(frame);
  }
  int expected() const { return images_->expected; }
  std::optional<CameraModel> camera() const {
    if (images_->given.name.empty()) return std::nullopt;
    return images_->given.model;
  }

 private:
  // Two threads of Python may iterate at the same time: the second waits here. Adds what there is to say.
  std::optional<SourceFrame> Read(std::vector<std::string>& notices) {
    const std::lock_guard alone(busy_);
    if (ended_ || (arguments_.max_frames && read_ >= *arguments_.max_frames)) return std::nullopt;
    ImageSource& source = images_->source;
    std::optional<SourceFrame> frame = source.Next();
    ended_ = !frame;
    if (frame) {
      ++read_;
      notices.push_back(frame->notice);
    } else {
      notices = {source.NoticeAtEnd(), source.EndsEarly()};
    }
    return frame;
  }

  ImageArguments arguments_;
  std::unique_ptr<DriveImages> images_;
  std::mutex busy_;
  int read_ = 0;
  bool ended_ = false;  ///< what is to be said at the end has been said
};

py::dict Headers() {
  py::dict headers;
  headers["trajectory"] = FrameTableHeader();
  headers["turns"] = TurnTable({});
  headers["speed"] = SpeedTable({});
  headers["scale"] = ScaleTable(Map(), RefinedScale());
  headers["camera_rotation"] = RotationTable({});
  return headers;
}

}  // namespace

PYBIND11_MODULE(_native, module) {
  module.doc() = "The C++ part of turnscale.";
  TranslateErrors();
  module.attr("__version__") = Version();

  py::class_<CameraModel>(module, "Camera",
                          "A calibrated camera: intrinsics in pixels, lens model and image size.\n\n"
                          "fx, fy, cx, cy: focal lengths and principal point, pixels; pixel centres are at integers.\n"
                          "width, height: image size, pixels; 0: that of the first image.\n"
                          "distortion: k1 k2 p1 p2 k3 of the lens 'radial-tangential' (OpenCV, Kalibr's radtan), or\n"
                          "k1 k2 k3 k4 of 'equidistant' (OpenCV's fisheye).\n"
                          "lens: 'pinhole', 'radial-tangential' or 'equidistant'.\n\n"
                          "Raises ValueError where the camera makes no sense.")
      .def(py::init(&MakeCamera), py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"), py::kw_only(),
           py::arg("width") = 0, py::arg("height") = 0, py::arg("distortion") = std::vector<double>(),
           py::arg("lens") = "radial-tangential")
      .def_static("read", &ReadCameraFile, py::arg("path"),
                  "Reads a calibration: KITTI calib.txt, OpenCV, ORB-SLAM or Kalibr YAML.")
      .def_property_readonly(
          "fx", [](const CameraModel& camera) { return camera.pinhole.fx; }, "Pixels.")
      .def_property_readonly(
          "fy", [](const CameraModel& camera) { return camera.pinhole.fy; }, "Pixels.")
      .def_property_readonly(
          "cx", [](const CameraModel& camera) { return camera.pinhole.cx; }, "Pixels.")
      .def_property_readonly(
          "cy", [](const CameraModel& camera) { return camera.pinhole.cy; }, "Pixels.")
      .def_readonly("width", &CameraModel::width, "Pixels; 0 if not known.")
      .def_readonly("height", &CameraModel::height, "Pixels; 0 if not known.")
      .def_property_readonly(
          "distortion",
          [](const CameraModel& camera) {
            return py::make_tuple(camera.distortion[0], camera.distortion[1], camera.distortion[2],
                                  camera.distortion[3], camera.distortion[4]);
          },
          "In the lens model's order, filled with zeros to five.")
      .def_property_readonly("lens", [](const CameraModel& camera) { return LensModelName(camera.lens); })
      .def(
          "__eq__", [](const CameraModel& one, const CameraModel& other) { return one == other; }, py::is_operator())
      .def("__repr__", &CameraRepr);

  py::class_<LiveFrame>(module, "FrameResult", "What the odometry says of a frame when it has seen it.")
      .def_property_readonly(
          "frame", [](const LiveFrame& f) { return f.result.frame; }, "Number of the frame, from 0.")
      .def_property_readonly(
          "time", [](const LiveFrame& f) { return f.result.time; }, "Seconds.")
      .def_property_readonly(
          "state", [](const LiveFrame& f) { return TrackingStateName(f.result.state); },
          "'initializing', 'tracked', 'repeated', 'bridged' or 'unreadable'.")
      .def_property_readonly("pose", &PoseOf,
                             "world_from_camera as float64 of shape (4, 4): camera to world, axes x right, y down, z\n"
                             "forward. In metres if `metric`, else in the map's unit. None while there is no map.")
      .def_property_readonly(
          "metric", [](const LiveFrame& f) { return f.result.scale_state != ScaleState::kPending; },
          "Whether the pose is in metres.")
      .def_property_readonly(
          "scale_state", [](const LiveFrame& f) { return ScaleStateName(f.result.scale_state); },
          "'pending', 'observed', 'held' or 'road'.")
      .def_readonly("scale", &LiveFrame::scale, "Metres per unit of the map at the last keyframe; NaN while pending.")
      .def_property_readonly(
          "sigma", [](const LiveFrame& f) { return f.result.scale_sigma; },
          "Relative standard deviation of the scale; inf while pending.")
      .def_property_readonly("keyframe", [](const LiveFrame& f) { return f.result.keyframe; })
      .def_property_readonly(
          "tracked", [](const LiveFrame& f) { return f.result.tracked; }, "Features tracked into this frame.")
      .def_property_readonly(
          "inliers", [](const LiveFrame& f) { return f.result.inliers; }, "Landmarks that agree with the pose.")
      .def_property_readonly(
          "psi_deg", [](const LiveFrame& f) { return InDegrees(f.result.psi); },
          "Turning angle since the last keyframe, degrees; NaN unless a keyframe.")
      .def_property_readonly(
          "theta_deg", [](const LiveFrame& f) { return InDegrees(f.result.theta); },
          "Direction of travel, degrees; NaN unless a keyframe.")
      .def_property_readonly(
          "turning", [](const LiveFrame& f) { return f.result.turning; },
          "The step to the frame's keyframe belongs to a turn.")
      .def_property_readonly(
          "vehicle_from_camera",
          [](const LiveFrame& f) { return Array(Matrix3(f.result.vehicle_from_camera.toRotationMatrix())); },
          "Camera-to-vehicle rotation as far as it is known, float64 of shape (3, 3).")
      .def("__repr__", [](const LiveFrame& f) {
        return py::str("FrameResult(frame={}, time={}, state='{}', scale_state='{}', sigma={})")
            .format(f.result.frame, f.result.time, TrackingStateName(f.result.state),
                    ScaleStateName(f.result.scale_state), f.result.scale_sigma);
      });

  py::class_<DriveTables>(module, "Tables")
      .def_readonly("trajectory", &DriveTables::trajectory)
      .def_readonly("turns", &DriveTables::turns)
      .def_readonly("speed", &DriveTables::speed)
      .def_readonly("scale", &DriveTables::scale)
      .def_readonly("camera_rotation", &DriveTables::camera_rotation)
      .def_readonly("live", &DriveTables::live)
      .def_property_readonly("summary", [](const DriveTables& tables) { return py::bytes(tables.summary); })
      .def_readonly("warnings", &DriveTables::warnings)
      .def_property_readonly("landmarks", [](const DriveTables& tables) { return Points(tables.map.landmarks); })
      .def_property_readonly("cameras", [](const DriveTables& tables) { return Points(tables.map.cameras); });

  py::class_<FrameByFrame>(module, "FrameByFrame")
      .def(py::init([](const CameraModel& camera, const py::dict& options) {
        return std::make_unique<FrameByFrame>(camera, OdometryArgumentsFrom(options));
      }))
      .def("set_mask", &FrameByFrame::SetMask)
      .def("process", &FrameByFrame::Process)
      .def("process_unreadable", &FrameByFrame::ProcessUnreadable)
      .def("finish", &FrameByFrame::Finish)
      .def("tables", &FrameByFrame::Tables)
      .def_property_readonly("camera", &FrameByFrame::camera)
      .def_property_readonly("scale_state", &FrameByFrame::scale_state)
      .def_property_readonly("frames", &FrameByFrame::frames);

  py::class_<SourceFrame>(module, "Frame", "An image of a drive.")
      .def_readonly("index", &SourceFrame::index, "From 0 at the first one read.")
      .def_readonly("time", &SourceFrame::time, "Seconds.")
      .def_property_readonly(
          "image", [](const SourceFrame& frame) { return PixelsOf(frame.gray); },
          "Gray pixels, uint8 of shape (height, width); None where the image is unusable.")
      .def_readonly("problem", &SourceFrame::problem, "Why there is no image; empty if there is.")
      .def_readonly("notice", &SourceFrame::notice, "What to know before this frame, such as a gap; may be empty.");

  py::class_<DriveReader>(module, "DriveReader")
      .def(py::init<const py::dict&>())
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", &DriveReader::Next)
      .def_property_readonly("expected", &DriveReader::expected)
      .def_property_readonly("camera", &DriveReader::camera);

  module.def("run", &RunDriveFor);
  module.def("calibrate", &CalibrateFor);
  module.def("rescale", &RescaleFor);
  module.def("evaluate", &EvaluateFor);
  module.def("headers", &Headers);
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "frame_by_frame.h"

#include <utility>

#include <fmt/format.h>
#include <opencv2/core/utility.hpp>

#include "turnscale/base/error.h"
#include "turnscale/commands/argument_checks.h"
#include "turnscale/commands/version.h"
#include "turnscale/frames/mask_file.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/odometry/drive_speed.h"
#include "turnscale/odometry/results.h"
#include "turnscale/run/scale_summary.h"

namespace py = pybind11;

namespace turnscale {
namespace {

OdometryOptions CheckedOptions(const OdometryArguments& arguments) {
  CheckThreads(arguments.threads);
  return SettingsFrom(arguments.car, arguments.settings).odometry;
}

std::string ShapeOf(const py::array& image) {
  return py::str(image.attr("dtype")).cast<std::string>() + " of shape " +
         py::str(image.attr("shape")).cast<std::string>();
}

}  // namespace

cv::Mat GrayView(const py::array& image, const std::string& name) {
  if (!image.dtype().equal(py::dtype::of<uint8_t>()) || image.ndim() != 2 || image.size() == 0)
    throw InputError(name + ": is " + ShapeOf(image) + "; give gray pixels: uint8 of shape (height, width)");
  const bool dense = image.shape(1) == 1 || image.strides(1) == 1;
  const bool in_order = image.shape(0) == 1 || image.strides(0) >= image.shape(1);
  if (!dense || !in_order)
    throw InputError(
        fmt::format("{0}: has strides ({1}, {2}); the pixels of a row have to lie side by side and the "
                    "rows in order: give numpy.ascontiguousarray({0})",
                    name, image.strides(0), image.strides(1)));
  constexpr py::ssize_t kLongest = 1 << 20;
  if (image.shape(0) > kLongest || image.shape(1) > kLongest)
    throw InputError(name + ": is " + ShapeOf(image) + "; that is too large");
  const auto step = static_cast<size_t>(image.shape(0) == 1 ? image.shape(1) : image.strides(0));
  // The odometry only reads it, and keeps no reference.
  return {static_cast<int>(image.shape(0)), static_cast<int>(image.shape(1)), CV_8UC1, const_cast<void*>(image.data()),
          step};
}

FrameByFrame::FrameByFrame(const CameraModel& camera, const OdometryArguments& arguments)
    : odometry_(CheckedOptions(arguments), camera), camera_name_(arguments.camera_name.string()) {
  if (arguments.car.vehicle) vehicle_file_ = arguments.car.vehicle->string();
  cv::setNumThreads(arguments.threads);
  if (!arguments.mask) return;
  mask_ = arguments.mask->string();
  const cv::Mat mask = ReadMask(*arguments.mask);
  CheckMaskSize(*arguments.mask, mask,
                {camera.width > 0 ? camera.width : mask.cols, camera.width > 0 ? camera.height : mask.rows});
  odometry_.SetMask(mask);
}

// Two threads of Python may call at the same time: the second waits here, without Python's lock.
template <class Work>
auto FrameByFrame::WithoutLock(const Work& work) {
  const py::gil_scoped_release release;
  const std::lock_guard alone(busy_);
  return work();
}

void FrameByFrame::RefuseAfterEnd() const {
  if (finished_) throw InputError("process: the drive has been finished; begin a new Odometry");
}

void FrameByFrame::SetMask(const py::array& mask) {
  const cv::Mat pixels = GrayView(mask, "mask").clone();
  WithoutLock([&] {
    if (recorder_.frames() > 0) throw InputError("mask: has to be set before the first image");
    odometry_.SetMask(pixels);
    mask_ = "array";
  });
}

void FrameByFrame::NoteMoves() {
  for (std::string& warning : recorder_.TakeMoveWarnings()) warnings_.push_back(std::move(warning));
}

LiveFrame FrameByFrame::Keep(const FrameResult& result) {
  NoteMoves();
  if (result.world_from_camera) live_ += TumLine({result.time, *result.world_from_camera});
  LiveFrame frame;
  frame.result = result;
  const MetricPath& path = odometry_.live_path();
  if (odometry_.scale_state() != ScaleState::kPending && !path.metres_per_unit.empty())
    frame.scale = path.metres_per_unit.back();
  return frame;
}

LiveFrame FrameByFrame::Process(const py::array& image, double time) {
  const cv::Mat gray = GrayView(image, "image");
  return WithoutLock([&] {
    RefuseAfterEnd();
    return Keep(recorder_.Process(gray, time));
  });
}

LiveFrame FrameByFrame::ProcessUnreadable(double time) {
  return WithoutLock([&] {
    RefuseAfterEnd();
    return Keep(recorder_.ProcessUnreadable(time, "no image"));
  });
}

void FrameByFrame::Finish() {
  WithoutLock([&] {
    if (finished_) return;
    recorder_.Finish();
    NoteMoves();
    finished_ = true;
  });
}

RunSummary FrameByFrame::SummaryOf(const RefinedResults& results) const {
  RunInput given;
  given.version = Version();
  given.pose_frame = "camera";
  given.camera = camera_name_;
  given.mask = mask_;
  given.vehicle_file = vehicle_file_;
  if (!results.frames.empty()) given.first_time = results.frames.front().time;
  RunSummary summary = recorder_.Summary(given, results);
  summary.warnings.insert(summary.warnings.begin(), warnings_.begin(), warnings_.end());
  return summary;
}

const char* FrameByFrame::scale_state() {
  return WithoutLock([&] { return ScaleStateName(odometry_.scale_state()); });
}

CameraModel FrameByFrame::camera() {
  return WithoutLock([&] { return odometry_.camera(); });
}

int FrameByFrame::frames() {
  return WithoutLock([&] { return recorder_.frames(); });
}

DriveTables FrameByFrame::Tables() {
  return WithoutLock([&] {
    const RefinedResults results = recorder_.Refined();
    const RefinedScale& refined = results.scale;
    DriveTables tables;
    tables.trajectory = FrameTableHeader();
    for (const FrameResult& frame : results.frames) tables.trajectory += FrameTableLine(frame, frame.world_from_camera);
    tables.turns = TurnTable(refined.turns);
    tables.speed = SpeedTable(SpeedsOf(results.frames, odometry_.options().vehicle.lever_arm.value_or(0.0)));
    tables.scale = ScaleTable(odometry_.map(), refined.estimate ? refined : RefinedScale());
    tables.camera_rotation = RotationTable(recorder_.rotations());
    tables.live = live_;
    const RunSummary summary = SummaryOf(results);
    tables.summary = SummaryJson(summary);
    tables.warnings = summary.warnings;
    if (summary.drive.wants_metres() && !summary.scale.is_metric())
      tables.warnings.push_back(UpToScaleText(summary.scale.pending_reason));
    tables.map = odometry_.RefinedMap(refined);
    return tables;
  });
}

}  // namespace turnscale

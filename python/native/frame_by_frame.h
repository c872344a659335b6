// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <limits>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <pybind11/numpy.h>

#include "keywords.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/odometry/odometry.h"
#include "turnscale/run/drive_recorder.h"
#include "turnscale/run/run_summary.h"

namespace turnscale {

/// Result of a frame with the online scale.
struct LiveFrame {
  FrameResult result;
  double scale = std::numeric_limits<double>::quiet_NaN();  ///< metres per unit of the map; NaN while pending
};

/// The tables of a drive as the program writes them to its files.
struct DriveTables {
  std::string trajectory;
  std::string turns;
  std::string speed;
  std::string scale;
  std::string camera_rotation;
  std::string live;
  std::string summary;                ///< JSON
  std::vector<std::string> warnings;  ///< those of the summary, and that the trajectory is up to scale
  MapPoints map;
};

/// An image of numpy without a copy. Throws InputError, which calls it `name`, unless it is 8-bit gray with the pixels
/// of a row side by side.
cv::Mat GrayView(const pybind11::array& image, const std::string& name);

/// The odometry, one image after the other. Works without Python's lock, on one thread at a time.
class FrameByFrame {
 public:
  FrameByFrame(const CameraModel& camera, const OdometryArguments& arguments);

  void SetMask(const pybind11::array& mask);
  LiveFrame Process(const pybind11::array& image, double time);
  LiveFrame ProcessUnreadable(double time);
  void Finish();
  DriveTables Tables();
  CameraModel camera();
  const char* scale_state();
  int frames();

 private:
  template <class Work>
  auto WithoutLock(const Work& work);
  LiveFrame Keep(const FrameResult& result);
  void NoteMoves();
  void RefuseAfterEnd() const;
  RunSummary SummaryOf(const RefinedResults& results) const;

  std::mutex busy_;
  Odometry odometry_;
  DriveRecorder recorder_{odometry_};
  std::string camera_name_;
  std::string vehicle_file_;           ///< empty without one
  std::string mask_;                   ///< its file, or "array"; empty without one
  std::string live_;                   ///< live.tum
  std::vector<std::string> warnings_;  ///< of frames
  bool finished_ = false;
};

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <limits>
#include <mutex>
#include <string>
#include <vector>

#include <pybind11/numpy.h>

#include "keywords.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/io/run_writer.h"
#include "turnscale/odometry/odometry.h"

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
  MapPoints map;
};

/// An image of numpy without a copy. Throws InputError unless it is 8-bit gray with the pixels of a row side by side.
cv::Mat GrayView(const pybind11::array& image);

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
  void RefuseAfterEnd() const;

  std::mutex busy_;
  Odometry odometry_;
  std::vector<RotationRecord> rotations_;
  std::string live_;  ///< live.tum
  int frames_ = 0;
  bool finished_ = false;
};

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drive_images.h"
#include "turnscale/calibration/axis_convention.h"
#include "turnscale/geometry/trajectory.h"
#include "turnscale/io/message.h"

namespace turnscale {

/// A drive's camera motion, from wherever it is.
struct DriveMotion {
  std::string input;                  ///< as the user named it
  std::vector<Trajectory> stretches;  ///< of unbroken tracking, in one unit of length
  bool timed = true;                  ///< else the times are guessed
  std::string incomplete;             ///< why its length is not that of the whole drive; empty where it is
  std::optional<Failure> stopped;     ///< why it was not read to its end; empty where it was
  std::string note;                   ///< one line that the user should know; empty where there is none
};

/// Reads a TUM, KITTI or EuRoC trajectory, and turns body axes into camera axes: those given, or where none are, those
/// found. KITTI poses without times (given, or beside them) are taken as 10 a second. Throws InputError.
DriveMotion MotionFromTrajectory(const std::filesystem::path& path,
                                 const std::optional<std::filesystem::path>& timestamps, std::optional<double> fps,
                                 std::optional<AxisConvention> axes);

/// Runs the odometry over the images, without a lever arm: the unit of length is arbitrary. An interrupt, or whatever
/// is thrown on the way, ends the drive there; it is thrown on where there is no motion yet.
DriveMotion MotionFromImages(const ImageArguments& arguments);

}  // namespace turnscale

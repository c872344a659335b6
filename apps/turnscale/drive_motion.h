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

/// Camera motion of a drive, from images or from a trajectory file.
struct DriveMotion {
  std::string input;                  ///< as the user named it
  std::vector<Trajectory> stretches;  ///< segments of uninterrupted tracking, in one unit of length
  bool timed = true;                  ///< false: times are assumed
  std::string incomplete;             ///< why the path length is incomplete; empty if complete
  std::optional<Failure> stopped;     ///< why the drive was not processed to its end; empty if it was
  std::string note;                   ///< one line for the user; may be empty
};

/// Reads a TUM, KITTI or EuRoC trajectory and converts vehicle axes, given or detected, to camera axes.
/// KITTI poses without timestamps are assumed to be 10 per second. Throws InputError.
DriveMotion MotionFromTrajectory(const std::filesystem::path& path,
                                 const std::optional<std::filesystem::path>& timestamps, std::optional<double> fps,
                                 std::optional<AxisConvention> axes);

/// Runs the odometry on the images, without a lever arm: the result is up to scale. An interrupt or an exception ends
/// the drive there; the exception is thrown on if there is no motion yet.
DriveMotion MotionFromImages(const ImageArguments& arguments);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/geometry/rotation.h"
#include "turnscale/kinematics/speed_smoother.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// A line of scale.csv.
struct ScaleRow {
  int frame = 0;
  double time = 0;             ///< seconds
  double metres_per_unit = 0;  ///< smoothed
  double sigma = 0;            ///< relative
};

/// A line of camera_rotation.csv.
struct RotationRow {
  int frame = 0;
  double time = 0;                    ///< seconds
  YawPitchRoll angles;                ///< rad
  std::optional<YawPitchRoll> sigma;  ///< rad; empty if the rotation was not estimated
};

/// What a run has written to its folder, read back. Of each frame and turn, only what the tables hold is set.
struct ResultFolder {
  std::vector<FrameResult> frames;
  std::vector<TurnResult> turns;
  bool metric = false;               ///< poses, landmarks and speeds are in metres
  std::optional<bool> scale_known;   ///< ScaleSummary::is_known; empty where an earlier version did not say
  std::vector<SpeedReading> speeds;  ///< empty without metres, and where an earlier version wrote none
  std::vector<ScaleRow> scale;       ///< empty without metres
  std::vector<RotationRow> rotations;
  std::vector<Eigen::Vector3f> landmarks;
  /// Horizontal field of view (rad) and width over height of the images, as a pinhole camera; 0 if that is not known,
  /// or if the lens is a fisheye, which no pinhole camera resembles.
  double horizontal_fov = 0;
  double aspect = 0;
  bool poses_of_vehicle = false;  ///< of the rear axle (--frame vehicle), not of the camera
  /// When the drive begins by the recorder's clock, whatever its time zone, such as 2023-05-01T12:00:00; empty if that
  /// is not known.
  std::string recorded_from;
  std::string summary;   ///< summary.json
  std::string settings;  ///< settings.yaml
  /// Rotation from the bodies of the poses to the car's axes; identity where poses of the car were written.
  Eigen::Quaterniond vehicle_from_body = Eigen::Quaterniond::Identity();

  /// The poses of the frames that have one.
  Trajectory Poses() const;
};

/// Reads the results of `turnscale run`. Files that results of an earlier version lack (speed.csv, scale.csv,
/// camera_rotation.csv), map.ply and settings.yaml may be missing. Throws InputError that names the file where the
/// folder holds no results, or a file cannot be read.
ResultFolder ReadResultFolder(const std::filesystem::path& folder);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// A drive through rendered streets whose truth is known: straight ahead, a right turn, a street, a left turn, straight
/// ahead. The car rolls without slipping (1).
struct StreetDrive {
  CameraModel camera;  ///< that the images were made with
  std::vector<double> times;
  std::vector<RigidTransform> world_from_camera;
  std::vector<cv::Mat> images;
};

struct StreetDriveOptions {
  int frames = 1000;     ///< at most; the drive ends by itself
  double fps = 10;       ///< frames a second; of standing and braking there are as many at any rate
  int width = 480;       ///< pixels; the image is 81 degrees wide whatever their number
  int height = 192;      ///< pixels
  unsigned noise = 42;   ///< seed of the noise of the images
  double k1 = 0;         ///< radial distortion of the lens; of a fisheye its first coefficient
  bool fisheye = false;  ///< an equidistant lens
  /// Seconds from the first row to the last one, whose pose lies on the line between those of two frames. The time and
  /// the pose of a frame are those of its middle row. At most the interval of two frames.
  double readout = 0;
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  int standing_at = -1;     ///< frame at which the car stops
  int standing_frames = 0;  ///< for so long
  /// Frames over which the car brakes before that, and over which it drives off after. None: from speed to standstill
  /// from one frame to the next, as no car does.
  int braking_frames = 0;
  /// In the second turn, metres: from the point that does not slip to the camera. It changes on the street before.
  double second_lever_arm = 1.5;
};

constexpr double kStreetLeverArm = 1.5;  ///< metres
constexpr double kStreetInterval = 0.1;  ///< seconds between frames at the usual 10 a second, which the rest is of
constexpr int kStreetFirstTurn = 25;     ///< frame in which the first turn starts
constexpr int kStreetSecondTurn = 85;    ///< frame in which the second turn starts
constexpr int kStreetTurnFrames = 35;    ///< length of a turn
constexpr int kStreetFrames = 140;       ///< of a drive without standing or braking

/// Renders the drive. The same options give the same images.
StreetDrive RenderStreetDrive(const StreetDriveOptions& options);
/// One drive for each seed of the noise, in place of that of the options. Quicker than one by one.
std::vector<StreetDrive> RenderStreetDrives(const StreetDriveOptions& options, const std::vector<unsigned>& noises);
/// The same, with no images.
StreetDrive StreetDriveWithoutImages(const StreetDriveOptions& options);

/// The first frames of the plain drive, whose images the build has rendered (render_street_drive.cpp).
StreetDrive PlainStreetDrive(int frames = kStreetFrames);

}  // namespace turnscale

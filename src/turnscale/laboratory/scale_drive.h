// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "turnscale/laboratory/paper_drive.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// The paper's synthetic drive as a camera sees it (V-B, V-B 2, Fig. 8). What the paper leaves open stands here:
/// which frames are keyframes, where points are.
struct ScaleDriveOptions {
  PaperDriveOptions drive;
  Pinhole pinhole = {718.856, 718.856, 607.1928, 185.2157};  ///< of KITTI 00
  int image_width = 1241;                                    ///< pixels
  int image_height = 376;
  int points = 4000;
  double points_aside = 15;   ///< metres to either side of the path in which points lie
  double points_above = 6;    ///< metres above the camera up to which they lie
  double points_below = 1.5;  ///< metres below it
  double nearest = 2;         ///< metres of depth
  double view_limit = 100;    ///< metres of depth
  /// Keyframes: at least every so many frames (9 frames are 3.1 m, the step that the paper's Table I implies), and
  /// where the car has turned by so much since the last one (rad).
  int keyframe_frames = 9;
  double keyframe_angle = 8.0 / 57.295779513082320877;
  double pixel_noise = 1;                               ///< standard deviation of each pixel coordinate
  double rotation_noise = 0.5 / 57.295779513082320877;  ///< of the odometry's rotation about each axis, rad a step
  double scale_loss = 0.001;                            ///< share of the odometry's unit that each step loses
  std::uint64_t seed = 1;                               ///< of the points and of all noise

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// A drive whose truth is known, and what an odometry starts from.
struct ScaleDrive {
  std::vector<RigidTransform> world_from_camera;  ///< true, one a keyframe; metres
  std::vector<Eigen::Vector3d> points;            ///< true, of the map's landmarks; metres
  /// Keyframes where the noisy, drifting odometry has them, the true points' noisy pixels, and landmarks at a tenth of
  /// their depth from where they belong.
  Map map;
  double pixel_noise = 1;
};

/// Same options, same bits.
ScaleDrive MakeScaleDrive(const ScaleDriveOptions& options);

/// What a visual odometry makes of it: bundle adjustment of all keyframes and landmarks, the first keyframe fixed. Its
/// unit of length is what the start and the pixels leave: the pixels hold it together along the drive, but do not say
/// what it is.
Map AdjustedMap(const ScaleDrive& drive);

}  // namespace turnscale

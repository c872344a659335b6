// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "turnscale/geometry/angle.h"
#include "turnscale/laboratory/paper_drive.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

/// The paper's synthetic drive as a camera sees it (V-B, V-B 2, Fig. 8). What the paper leaves open stands here:
/// which frames are keyframes, where points are.
struct ScaleDriveOptions {
  PaperDriveOptions drive;
  Pinhole pinhole = {718.856, 718.856, 607.1928, 185.2157};  ///< of KITTI 00
  /// False: a camera sees everything in front of it up to the view limit, which is the only limit that the paper names.
  /// True: of that only what falls into an image of KITTI's size.
  bool within_image = true;
  int points = 4000;
  double points_aside = 8;    ///< metres to either side of the path in which points lie
  double points_above = 2;    ///< metres above the camera up to which they lie
  double points_below = 1.5;  ///< metres below it
  double points_beyond = 50;  ///< metres that the points go on beyond the end of the path
  double nearest = 1;         ///< metres of depth
  double view_limit = 100;    ///< metres from the camera
  /// Errors are measured over steps of so many frames: 3.1 m, the step that the paper's Table I implies.
  int step_frames = 9;
  /// Every so many frames are a keyframe; besides, the ends of those steps are.
  int keyframe_frames = 9;
  /// And every so many where the car turns, since the observer takes a step for an arc of a circle.
  int turning_keyframe_frames = 3;
  double pixel_noise = 1;                           ///< standard deviation of each pixel coordinate
  double rotation_noise = 0.5 / kDegreesPerRadian;  ///< of the odometry's rotation about each axis, rad a step
  /// Share of its length that the odometry's unit loses every `scale_loss_frames` frames: 32 % over the drive. The
  /// paper has "0.1 % per frame" and "33 %" in all, which agree only if a frame is a step of about 3.1 m.
  double scale_loss = 0.001;
  int scale_loss_frames = 9;
  std::uint64_t seed = 1;  ///< of the points and of all noise

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// A drive whose truth is known.
struct ScaleDrive {
  /// True keyframes and landmarks (metres) with noisy pixels: where an adjustment may start, as only its minimum
  /// counts.
  Map truth;
  /// world_from_camera of the keyframes as the paper's noisy odometry has them, whose unit shrinks: for comparison, as
  /// the recovery works on what the pixels give (PointOdometry, LoseScale).
  std::vector<RigidTransform> odometry;
  double pixel_noise = 1;
  /// Keyframes that are step_frames apart, over which errors are measured.
  std::vector<int> stations;
};

/// Same options, same bits. Throws InputError where an option makes no sense.
ScaleDrive MakeScaleDrive(const ScaleDriveOptions& options);

/// What a visual odometry makes of a synthetic drive: bundle adjustment of all keyframes and landmarks, the first
/// keyframe fixed. The pixels hold the unit of length together along the drive, but do not say what it is. Throws
/// NumericalError where the adjustment does not converge.
Map PointOdometry(const ScaleDrive& drive);

/// The same map as an odometry would give it whose unit shrinks by `loss` every so many frames; landmarks go with the
/// keyframe that saw them from closest by.
void LoseScale(double loss, int frames, Map& map);

}  // namespace turnscale

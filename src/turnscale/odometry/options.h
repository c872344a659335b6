// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "turnscale/features/corners.h"
#include "turnscale/features/optical_flow.h"
#include "turnscale/features/patch_alignment.h"
#include "turnscale/kinematics/lever_arm.h"
#include "turnscale/kinematics/pooled_scale.h"
#include "turnscale/kinematics/turn_detector.h"
#include "turnscale/mapping/landmarks.h"
#include "turnscale/mapping/lens_refinement.h"
#include "turnscale/mapping/local_bundle_adjustment.h"
#include "turnscale/mapping/pose_estimation.h"
#include "turnscale/mapping/two_view_initialization.h"
#include "turnscale/scale/absolute_scale_recovery.h"

namespace turnscale {

/// The car, as far as the camera's motion tells of it.
struct VehicleOptions {
  /// Distance from the rear axle forward to the camera, metres. Without it the path stays up to scale.
  std::optional<double> lever_arm;
  /// c in L_eff = L - c v^2, s^2/m: the rear axle's slip angle per lateral acceleration. With a sigma of 0, 0 is the
  /// paper's rigid car.
  double side_slip = kUsualSideSlip;
  /// Its standard deviation, which leaves the drive room to refine it: cars differ by a third of it. 0 where c is
  /// known.
  double side_slip_sigma = 0.0015;
  /// The paper's Q; where the camera is calibrated, what is assumed until the drive tells better.
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  /// Find Q from the drive.
  bool calibrate_camera = true;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// When a frame becomes a keyframe: any of these suffices.
struct KeyframeOptions {
  /// Rotation since the last keyframe, degrees. Gives turning steps above the turn detector's threshold.
  double min_rotation_deg = 2.5;
  /// Median angle by which features have moved since the last keyframe, beyond the rotation, degrees.
  double min_parallax_deg = 1.2;
  /// Share of the last keyframe's landmarks that are still tracked.
  double min_tracked_share = 0.5;
  /// A landmark that has grown by more than this since its reference keyframe is looked up in the latest one from now
  /// on: an enlarged old view is too blurred to compare with.
  double max_growth = 1.6;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// When tracking counts as lost, and what happens then.
struct TrackingOptions {
  /// A pose with fewer agreeing landmarks is not believed.
  int min_inliers = 25;
  /// Nor one with which fewer than this share of the tracked landmarks agree.
  double min_inlier_share = 0.35;
  /// Frames in a row without a pose after which the map starts anew, at the predicted pose and speed.
  int max_lost_frames = 4;
  /// A landmark that this many keyframes have not seen is no longer looked for.
  int memory_keyframes = 10;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// How the turns' scale is carried over the drive.
struct ScaleOptions {
  ScaleRecoveryOptions recovery;
  /// A turn's scale is what all turns together say of it, weighed by its variance. Otherwise it is held at what it says
  /// itself. The paper's per-frame observer holds steps and is not smoothed.
  bool smooth = true;
  /// How fast the odometry's scale is taken to drift between turns: relative standard deviation after one metre,
  /// growing with the root of the distance (0.001: 1 % after 100 m).
  double drift_per_root_metre = 0.001;
  /// Relative standard deviation that a loss of tracking adds: the scale is taken over from the speed, or from how far
  /// things are.
  double gap_sigma = 0.3;
  /// Where turns are not smoothed: one whose relative sigma is more than this many times that of the scale carried to
  /// it is not used.
  double max_sigma_ratio = 2.0;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Everything that can be set; the defaults are the one frozen configuration for all drives.
struct OdometryOptions {
  VehicleOptions vehicle;
  CornerOptions corners;
  FlowOptions flow;
  PatchAlignmentOptions alignment;
  TwoViewOptions initialization;
  PoseEstimationOptions pose;
  KeyframeOptions keyframes;
  LandmarkOptions landmarks;
  LocalBundleOptions local_bundle;
  LensRefinementOptions lens;
  TrackingOptions tracking;
  TurnDetectorOptions turns;
  PooledScaleOptions pooled_scale;
  ScaleOptions scale;
  /// Threads that image operations may use. Changes the time, never the result.
  int threads = 2;

  /// All turns together tell the scale (ScaleOptions::smooth), which steps held one by one do not allow.
  bool Smooths() const { return scale.smooth && pooled_scale.method == ScaleMethod::kPooledLine; }

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

}  // namespace turnscale

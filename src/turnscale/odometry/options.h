// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "turnscale/features/corners.h"
#include "turnscale/features/optical_flow.h"
#include "turnscale/features/patch_alignment.h"
#include "turnscale/geometry/angle.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/vehicle_step.h"
#include "turnscale/mapping/absolute_scale_recovery.h"
#include "turnscale/mapping/calibration_check_options.h"
#include "turnscale/mapping/landmarks.h"
#include "turnscale/mapping/lens_refinement.h"
#include "turnscale/mapping/local_bundle_adjustment.h"
#include "turnscale/mapping/pose_estimation.h"
#include "turnscale/mapping/two_view_initialization.h"
#include "turnscale/odometry/gap_rotation.h"
#include "turnscale/odometry/image_mask.h"
#include "turnscale/odometry/motion_model.h"
#include "turnscale/odometry/repeated_image.h"
#include "turnscale/odometry/road_observer.h"
#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// Parameters of the car and the camera mount.
struct VehicleOptions {
  /// Distance from the rear axle forward to the camera, metres. Without it the trajectory is up to scale.
  std::optional<double> lever_arm;
  /// Its standard deviation, metres, below the lever arm. TapeSigma of it if not given: a tape held from the camera to
  /// above the centre of the rear wheel.
  std::optional<double> lever_arm_sigma;
  /// c in L_eff = L - c v^2, s^2/m: the rear axle's slip angle per lateral acceleration. With a sigma of 0, 0 is the
  /// paper's rigid car.
  double side_slip = kUsualSideSlip;
  /// Its standard deviation. c is refined from the drive unless this is 0.
  double side_slip_sigma = kUsualSideSlipSigma;
  /// The paper's Q: given, or the initial value if it is estimated.
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  /// The initial value of Q was measured before: the standard deviations below hold before it is estimated, and it is
  /// averaged with the drive's.
  bool camera_known = false;
  /// Estimate Q from the drive.
  bool calibrate_camera = true;
  /// Standard deviation of the yaw of Q, given or estimated, rad (0.3 deg; if estimated, at least).
  double yaw_sigma = kEstimatedYawSigma;
  /// Standard deviations of the pitch and roll of Q where it was measured before, rad (1 deg).
  double known_pitch_sigma = 1 / kDegreesPerRadian;
  double known_roll_sigma = 1 / kDegreesPerRadian;
  /// Height of the camera above the road, metres. Estimated in turns if not given.
  std::optional<double> camera_height;
  std::optional<double> camera_height_sigma;  ///< its standard deviation, metres; 1 % of it if not given
  /// The height is as the images of this camera show it, not measured: it has the error of the pixels' aspect.
  bool height_from_images = false;
  double height_correlation = 0;          ///< of the errors of camera height and lever arm
  double height_slip_correlation = 0;     ///< of the errors of camera height and c
  double lever_arm_slip_correlation = 0;  ///< of the errors of lever arm and c
  double roll_height = kUsualRollHeight;  ///< height of the camera above the axis about which the body rolls, metres
                                          ///< (`calibrate` assumes the default)
  double roll_height_sigma = kUsualRollHeightSigma;  ///< its standard deviation, metres
  double image_lag = 0;                              ///< of the orientation of stabilised images (ImageLag), s
  /// Its standard deviation, s. 0: the images are not stabilised, as far as is known.
  double image_lag_sigma = 0;

  /// Standard deviation of the lever arm, metres. 0 without one.
  double LeverArmSigma() const { return lever_arm_sigma.value_or(TapeSigma(lever_arm.value_or(0))); }

  /// Standard deviation of the height, metres. 0 without one.
  double HeightSigma() const { return camera_height_sigma.value_or(kGivenHeightSigma * camera_height.value_or(0)); }

  /// Whether a height is given that was measured, not found in the images.
  bool has_measured_height() const { return camera_height && !height_from_images; }

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
  /// Share of its features, with or without a depth, that are still tracked: where frames are few, most go out of sight
  /// before they get a depth.
  double min_followed_share = 0.4;
  /// The camera stands while three quarters of the landmarks have moved by less than this since the last keyframe,
  /// pixels. After a second there are no new keyframes: from the same place, only what passes in front of the camera
  /// would seem to have a depth.
  double min_motion = 1;
  /// A landmark that has grown by more than this since its reference keyframe is looked up in the latest one from now
  /// on: an enlarged old view is too blurred to compare with.
  double max_growth = 1.6;
  /// As is one whose reference keyframe is so many keyframes old: the image of each reference keyframe is kept.
  int max_reference_age = 60;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// When tracking counts as lost, and what happens then.
struct TrackingOptions {
  /// A pose with fewer inliers is rejected.
  int min_inliers = 25;
  /// Also one with a lower share of inliers among the tracked landmarks (PoseEstimate::inlier_share).
  double min_inlier_share = 0.35;
  /// Seconds since the last measured pose after which the map starts anew, at the predicted pose and speed: what the
  /// last image showed is then mostly out of sight.
  double max_lost_seconds = 0.45;
  /// The same where the camera stood: what passes in front of it hides the scene, which is found again afterwards.
  double max_hidden_seconds = 5;
  /// At least so many frames in a row without a pose come before that, whatever the time between them.
  int min_lost_frames = 3;
  /// Relative standard deviation of a new map's unit of length where it is taken from the depth of the scene before and
  /// after, less than 1; averaged with the last speed (MotionModelOptions::speed_sigma). On KITTI 03 and 07 and a
  /// simulated drive it is off by 0.3 to 0.8 (root mean square), whatever the length of the gap.
  double depth_sigma = 0.5;
  /// A landmark that has not been observed in this many keyframes is no longer searched for.
  int memory_keyframes = 10;
  /// An image that is taken within so many seconds of the last one in which all landmarks were tracked gets its pose
  /// from a sample of them, and does not become a keyframe: at 50 and 60 images per second every other one. Less than
  /// the interval of 30 images per second, however uneven. 0: none.
  double sampled_interval = 0.024;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// How metric scale is obtained.
enum class ScaleMethod {
  kSmoothed,  ///< the map is not changed; one estimate of the scale along the drive, from all turns
  kTurns,     ///< the finished map is adjusted with each turn's length constrained to its single-turn scale
  kPaper,     ///< the same with each step of a turn constrained to the length from its own angles (22)
};

struct ScaleOptions {
  ScaleMethod method = ScaleMethod::kSmoothed;
  ScaleEstimatorOptions estimator;
  /// Of the finished map: methods kTurns and kPaper.
  ScaleRecoveryOptions recovery;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// All settings of the odometry; the defaults are used for all drives.
struct OdometryOptions {
  VehicleOptions vehicle;
  CornerOptions corners;
  FlowOptions flow;
  PatchAlignmentOptions alignment;
  TwoViewOptions initialization;
  PoseEstimationOptions pose;
  KeyframeOptions keyframes;
  LandmarkOptions landmarks;
  /// After each keyframe. The larger windows that follow are adjusted until they settle.
  LocalBundleOptions local_bundle{.max_iterations = 2, .relative_cost_tolerance = 1e-3, .use_exact_hessian = false};
  /// When a turn ends, for keyframes since the one before, and where they have become half of a window.
  LocalBundleOptions turn_bundle{.window = 120, .max_iterations = 10};
  /// For the whole drive, at its end, in sections of about a window.
  LocalBundleOptions final_bundle{.window = 150, .max_iterations = 40, .initial_damping = 1e-7};
  LensRefinementOptions lens;
  CalibrationCheckOptions calibration_check;
  TrackingOptions tracking;
  MotionModelOptions motion;
  RepeatOptions repeats;
  GapRotationOptions gap_rotation;
  StaticRegionOptions static_regions;
  RoadObserverOptions road;
  VehicleStepOptions steps;
  ScaleOptions scale;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The same without what gives the trajectory metres (lever arm and camera height): it is up to scale.
OdometryOptions WithoutMetres(OdometryOptions options);

}  // namespace turnscale

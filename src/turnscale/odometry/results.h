// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "turnscale/geometry/rigid_transform.h"

namespace turnscale {

/// What is known of the metre when a pose is given.
enum class ScaleState {
  kPending,   ///< no turn has shown the scale yet: the unit of length is arbitrary
  kObserved,  ///< within a turn whose evidence counts; live, up to the keyframe that ends it
  kHeld,      ///< between turns: the scale is that of the turns around; live, of those before
};

/// How a frame's pose came about.
enum class TrackingState {
  kInitializing,  ///< no map yet (standstill, pure rotation, too little parallax)
  kTracked,       ///< measured against the map
  kRepeated,      ///< the image shows what the one before did, though the car moves; the pose is the predicted one
  kBridged,       ///< the image was of no use; the pose is the predicted one
  kUnreadable,    ///< there was no image; the pose is the predicted one
};

/// What the odometry says of one frame.
struct FrameResult {
  int frame = 0;    ///< number of the image in the drive, from 0
  double time = 0;  ///< seconds
  TrackingState state = TrackingState::kInitializing;
  /// Metres where the scale is known, else the arbitrary unit of the start. Empty while there is no map.
  std::optional<RigidTransform> world_from_camera;
  /// How the camera is turned on the car at this frame, the paper's Q, as far as it is known.
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  ScaleState scale_state = ScaleState::kPending;
  double scale_sigma = std::numeric_limits<double>::infinity();  ///< relative standard deviation of the scale
  int tracked = 0;                                               ///< features found again in this frame
  int inliers = 0;                                               ///< landmarks that agree with the pose
  bool keyframe = false;
  double psi =
      std::numeric_limits<double>::quiet_NaN();  ///< turning angle since the last keyframe, rad; keyframes only
  double theta = std::numeric_limits<double>::quiet_NaN();  ///< direction of travel (19), rad; keyframes only
  /// The step that led to the frame's keyframe belongs to a turning region (F_t of Algorithm 1).
  bool turning = false;
};

/// One turn and what its pooled line says of the scale.
struct TurnResult {
  int first_frame = 0;
  int last_frame = 0;
  int first_keyframe = 0;
  int last_keyframe = 0;
  double angle = 0;  ///< whole turn, rad, positive to the right
  double speed = 0;  ///< root mean square, m/s; 0 while the scale is unknown
  /// Metres per unit of the map that the turn shows by itself, the car's constants being those of the drive; 0 where it
  /// shows none.
  double metres_per_unit = 0;
  double sigma = 0;  ///< standard deviation of metres_per_unit
  /// The same with the car's constants as they were given: what `--method turns` holds.
  double as_given = 0;
  bool followed = false;      ///< where the scale follows single turns: this one, at `as_given`
  double smoothed = 0;        ///< metres per unit of the drive's scale there
  double smoothed_sigma = 0;  ///< standard deviation of `smoothed`
  double deviation = 0;       ///< ln(smoothed / metres_per_unit) in standard deviations
  /// Lever arm that the turn shows at the scale of the whole drive, metres.
  double effective_lever_arm = 0;
  bool used = false;
  std::string reason;  ///< why the turn was not used; empty where it was
  /// Why the recovery (`--method turns`, `paper`) scaled the map around this used turn, but did not adjust it
  /// (RangeRecovery::reason); empty where it did, and with other methods.
  std::string unadjusted;
};

}  // namespace turnscale

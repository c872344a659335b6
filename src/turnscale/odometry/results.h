// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/scale/scale_state.h"

namespace turnscale {

/// How a pose was determined. If not measured, it is predicted; refined: interpolated, extrapolated only at the end.
enum class TrackingState {
  kInitializing,  ///< no map yet (standstill, pure rotation, too little parallax)
  kTracked,       ///< measured against the map
  kRepeated,      ///< duplicate image: shows what the previous one did, though the car moves; pose not measured
  kBridged,       ///< tracking failed in the image; pose not measured
  kUnreadable,    ///< no readable image; pose not measured
};

/// The name of a state in tables and summaries: "pending", "observed", "held" or "road".
const char* ScaleStateName(ScaleState state);
/// Likewise: "initializing", "tracked", "repeated", "bridged" or "unreadable".
const char* TrackingStateName(TrackingState state);
/// The state of that name; empty if there is none.
std::optional<ScaleState> ScaleStateNamed(std::string_view name);
std::optional<TrackingState> TrackingStateNamed(std::string_view name);

/// Result of one frame.
struct FrameResult {
  int frame = 0;    ///< number of the image in the drive, from 0
  double time = 0;  ///< seconds
  TrackingState state = TrackingState::kInitializing;
  /// In metres if the scale is known, else in the arbitrary unit of the map. Empty while there is no map.
  std::optional<RigidTransform> world_from_camera;
  /// The camera-to-vehicle rotation at this frame, the paper's Q, as far as it is known.
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
  ScaleState scale_state = ScaleState::kPending;
  double scale_sigma = std::numeric_limits<double>::infinity();  ///< relative standard deviation of the scale
  /// Features tracked into this frame; a sample of them where that sufficed (TrackingOptions::sampled_interval).
  int tracked = 0;
  int inliers = 0;  ///< landmarks that agree with the pose, of the tracked ones
  bool keyframe = false;
  double psi =
      std::numeric_limits<double>::quiet_NaN();  ///< turning angle since the last keyframe, rad; keyframes only
  double theta = std::numeric_limits<double>::quiet_NaN();  ///< direction of travel (19), rad; keyframes only
  /// The step that led to the frame's keyframe belongs to a turning region (F_t of Algorithm 1).
  bool turning = false;

  /// Tracked, with a pose that the images of this frame gave: neither repeated, nor interpolated, nor extrapolated.
  bool is_measured() const { return state == TrackingState::kTracked && world_from_camera.has_value(); }
};

/// Between the positions of the camera in two frames that have poses.
inline double DistanceBetween(const FrameResult& a, const FrameResult& b) {
  return (a.world_from_camera->translation - b.world_from_camera->translation).norm();
}

/// The rear axle of the car, in the frame and the unit of the poses.
struct AxlePose {
  Eigen::Vector3d position;
  Eigen::Vector3d forward;  ///< direction of the car's axis, of length 1
};

/// The rear axle at a frame that has a pose. `lever_arm`: in the unit of the poses.
AxlePose RearAxle(const FrameResult& frame, double lever_arm);

/// One turn and its single-turn scale. Scales are in metres per unit of the map, 0 where there is none; standard
/// deviations are in the same unit.
struct TurnResult {
  int first_frame = 0;
  int last_frame = 0;
  int first_keyframe = 0;
  int last_keyframe = 0;
  double angle = 0;  ///< whole turn, rad, positive to the right
  double speed = 0;  ///< root mean square, m/s; 0 while the scale is unknown
  double own = 0;    ///< single-turn scale with the car's constants as refined from the drive
  double own_sigma = 0;
  /// The same with the car's constants as given: the constraint of `--method turns`.
  double as_given = 0;
  bool used_singly = false;  ///< TurnEstimate::used_singly
  double smoothed = 0;       ///< smoothed scale there
  double smoothed_sigma = 0;
  /// Effective lever arm of the turn less the one that the smoothed scale lets expect, in standard deviations. It has
  /// the sign of ln(smoothed / own).
  double deviation = 0;
  /// Effective lever arm of the turn at the smoothed scale, metres.
  double effective_lever_arm = 0;
  bool used = false;
  std::string reason;  ///< why the turn was not used; empty if it was
  /// Why the recovery (`--method turns`, `paper`) scaled the map around this used turn, but did not adjust it
  /// (RangeRecovery::reason); empty where it did, and with other methods.
  std::string unadjusted;
};

/// Points of a map for a picture, in metres or the map's unit.
struct MapPoints {
  std::vector<Eigen::Vector3f> landmarks;  ///< single precision: there may be millions
  std::vector<Eigen::Vector3d> cameras;
};

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/pooled_line.h"
#include "turnscale/scale/path_segment.h"

namespace turnscale {

/// Prior knowledge of the car and its camera.
struct CarPrior {
  double lever_arm = 0;  ///< L: from the rear axle forward to the camera, metres
  /// Standard deviation of L, metres: a tape held from the camera to above the centre of the rear wheel.
  double lever_arm_sigma = kTapeSigma;
  double side_slip = kUsualSideSlip;             ///< c, s^2/m
  double side_slip_sigma = kUsualSideSlipSigma;  ///< 0 where c is known exactly
  /// Of the yaw error of Q, rad (0.3 deg: at which the calibration from the camera's motion is first used).
  double yaw_sigma = 0.3 / 57.295779513082320877;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Indices of the unknowns of a drive. Only the log-scale changes along the drive.
enum DriveUnknown {
  kLogScale,     ///< ln(lambda), metres per odometry unit
  kDirection,    ///< direction of travel on straights according to Q, rad, positive to the right: minus Q's yaw error
  kSlip,         ///< c, s^2/m
  kLogLeverArm,  ///< ln(L), L in metres
};
using DriveState = Eigen::Vector4d;

/// Standard deviations of a segment's deviation from the model of the drive. All its steps share this deviation, so it
/// does not average out within the segment.
struct EvidenceOptions {
  PooledLineOptions line;
  /// Effective lever arm of a turn, relative: effects not modelled (road bank, roll of the body, drift of the
  /// odometry within the turn). ORB-SLAM's stereo trajectories of KITTI scatter by this much about one car.
  double turn_sigma = 0.015;
  /// Side slip of a turn, relative: grip and load differ from turn to turn.
  double slip_sigma = 0.2;
  /// Direction of travel in a turn, rad (0.05 deg): road bank.
  double turn_direction_sigma = 0.05 / 57.295779513082320877;
  /// Direction of travel on a straight segment, rad (0.1 deg): crown of the road, side wind, lane changes.
  double straight_direction_sigma = 0.1 / 57.295779513082320877;
  /// Least ratio of effective to measured lever arm in a turn. In faster turns the scale depends on the slip rather
  /// than on the measured lever arm.
  double min_lever_arm_ratio = 0.25;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The measurement of one segment, a scalar: the effective lever arm of a turn in odometry units, or the direction of
/// travel of a straight.
struct SegmentEvidence {
  bool turning = false;
  std::optional<PooledLine> turn;  ///< empty if a turn gives none, or is too fast
  std::string reason;              ///< why; one line
  /// Straights: direction of travel, rad, and its standard deviation, infinite where the straight gives none.
  double direction = 0;
  double direction_sigma = 0;
  double weight = 1;  ///< robust (Huber), set by the estimator: below 1 where the segment disagrees with the drive
};

/// Evidence of each segment, in order. Bends of straights are compensated with the median lever arm of the turns
/// (odometry units).
std::vector<SegmentEvidence> GatherEvidence(const std::vector<VehicleStep>& steps,
                                            const std::vector<PathSegment>& segments, const EvidenceOptions& options);

/// Evidence of a single straight, its bends compensated with a lever arm in odometry units.
SegmentEvidence EvidenceOfStraight(const std::vector<VehicleStep>& steps, double lever_arm,
                                   const EvidenceOptions& options);

/// Evidence of a single turn.
SegmentEvidence EvidenceOfTurn(const std::vector<VehicleStep>& steps, const EvidenceOptions& options);

/// A scalar measurement, linearised at a state: innovation = measured - expected, by_state = d expected / d state.
struct Measurement {
  double innovation = 0;
  double variance = 0;  ///< including the segment's deviation from the model; without its robust weight
  Eigen::RowVector4d by_state = Eigen::RowVector4d::Zero();
};

/// The segment's measurement at a state; empty if it has none.
///   turn:      lever_arm = L/lambda - c lambda u^2 + direction * by_direction,  u^2 mean square speed in units/s
///   straight:  direction
std::optional<Measurement> Linearize(const SegmentEvidence& evidence, const DriveState& state,
                                     const EvidenceOptions& options);

/// Why a turn is not usable at `state` (too fast, no outward motion): one line; empty if it is.
std::string WhyUnusable(const PooledLine& turn, const DriveState& state, const EvidenceOptions& options);

/// The single-turn scale (metres per unit), the other unknowns as in `state`.
double OwnScale(const SegmentEvidence& evidence, const DriveState& state);

}  // namespace turnscale

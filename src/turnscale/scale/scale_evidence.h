// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "turnscale/kinematics/pooled_line.h"
#include "turnscale/scale/car_prior.h"
#include "turnscale/scale/path_segment.h"

namespace turnscale {

/// The unknowns of a drive, as places in a vector. Only the log-scale changes along the drive.
enum DriveUnknown {
  kLogScale,     ///< ln(lambda), metres per odometry unit
  kDirection,    ///< direction of travel on straights as Q has it, rad, positive to the right: minus the yaw error of Q
  kSlip,         ///< c, s^2/m
  kLogLeverArm,  ///< ln(L), L in metres
};
using DriveState = Eigen::Vector4d;

/// What a segment may differ by from the model of the drive as a whole. Its steps share these errors, so they do not
/// average out within it.
struct EvidenceOptions {
  PooledLineOptions line;
  /// Effective lever arm of a turn, relative: what the vehicle model leaves (road bank, roll of the body, drift of the
  /// odometry within the turn). ORB-SLAM's stereo trajectories of KITTI scatter by this much about one car.
  double turn_sigma = 0.015;
  /// Side slip of a turn, relative: grip and load differ from turn to turn.
  double slip_sigma = 0.2;
  /// Direction of travel in a turn, rad (0.05 deg): road bank.
  double turn_direction_sigma = 0.05 / 57.295779513082320877;
  /// Direction of travel on a straight segment, rad (0.1 deg): crown of the road, side wind, lane changes.
  double straight_direction_sigma = 0.1 / 57.295779513082320877;
  /// Part of the lever arm that side slip has to leave in a turn. In faster turns the scale depends on the slip rather
  /// than on the measured lever arm.
  double min_lever_arm_ratio = 0.25;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// What one segment says: one number. A turn gives its effective lever arm in odometry units, a straight its direction
/// of travel.
struct SegmentEvidence {
  bool turning = false;
  std::optional<PooledLine> turn;  ///< empty where a turn gives none, or is too fast
  std::string reason;              ///< why; one line
  /// Straights: direction of travel, rad, and its standard deviation, infinite where the straight gives none.
  double direction = 0;
  double direction_sigma = 0;
  double weight = 1;  ///< robust (Huber), set by the estimator: below 1 where the segment disagrees with the drive
};

/// Evidence of each segment, in their order. A straight's bends are taken out with the lever arm (odometry units) that
/// the turns show in the median.
std::vector<SegmentEvidence> GatherEvidence(const std::vector<VehicleStep>& steps,
                                            const std::vector<PathSegment>& segments, const EvidenceOptions& options);

/// Evidence of a single straight, its bends taken out with a lever arm in odometry units.
SegmentEvidence EvidenceOfStraight(const std::vector<VehicleStep>& steps, double lever_arm,
                                   const EvidenceOptions& options);

/// Evidence of a single turn.
SegmentEvidence EvidenceOfTurn(const std::vector<VehicleStep>& steps, const EvidenceOptions& options);

/// A scalar measurement, linearised at a state: innovation = measured - expected, by_state = d expected / d state.
struct Measurement {
  double innovation = 0;
  double variance = 0;  ///< with the segment's own differences from the model; without its robust weight
  Eigen::RowVector4d by_state = Eigen::RowVector4d::Zero();
};

/// The segment's measurement at a state; empty where it has none.
///   turn:      lever_arm = L/lambda - c lambda u^2 + direction * by_direction,  u^2 mean square speed in units/s
///   straight:  direction
std::optional<Measurement> Linearize(const SegmentEvidence& evidence, const DriveState& state,
                                     const EvidenceOptions& options);

/// Why the measured lever arm cannot be seen in a turn, all else being as in `state`: one line; empty where it can.
std::string WhyUnusable(const PooledLine& turn, const DriveState& state, const EvidenceOptions& options);

/// The scale (metres per unit) that a turn shows by itself, all else being as in `state`.
double OwnScale(const SegmentEvidence& evidence, const DriveState& state);

}  // namespace turnscale

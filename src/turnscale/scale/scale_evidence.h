// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "turnscale/geometry/angle.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/pooled_line.h"
#include "turnscale/kinematics/turn_errors.h"
#include "turnscale/scale/path_segment.h"

namespace turnscale {

/// Relative standard deviation of a given camera height: measured with a tape; load and tyre pressure change.
constexpr double kGivenHeightSigma = 0.01;

/// Standard deviation of the yaw of a camera that was mounted by eye, rad (3 deg).
constexpr double kYawSigmaByEye = 3.0 / kDegreesPerRadian;

/// Least standard deviation of a yaw that is estimated from the camera's motion over some turns, rad (0.3 deg).
constexpr double kEstimatedYawSigma = 0.3 / kDegreesPerRadian;

/// Standard deviation of the yaw as a prior of the scale, rad, if the yaw was estimated from the same drive with the
/// standard deviation `estimated`, and known before with `known`. A rough estimate adds nothing, as the scale is
/// estimated from the same straights and turns: kYawSigmaByEye.
inline double PriorYawSigma(double estimated, double known) {
  if (estimated <= known) return known;
  return std::max(known, estimated <= kEstimatedYawSigma ? kEstimatedYawSigma : kYawSigmaByEye);
}

/// Standard deviation of a lever arm measured with a tape, metres: kTapeSigma, but at most half of the lever arm.
inline double TapeSigma(double lever_arm) { return std::min(kTapeSigma, 0.5 * lever_arm); }

/// Whether three errors can have these correlations, a with b, a with c and b with c, and neither be the same one.
inline bool CanCorrelate(double ab, double ac, double bc) {
  return std::abs(bc) < 1 && ab * ab + ac * ac + bc * bc < 1 + 2 * ab * ac * bc;
}

/// Prior knowledge of the car and its camera.
struct CarPrior {
  /// L: from the rear axle forward to the camera, metres. 0: not known; turns then show no scale.
  double lever_arm = 0;
  /// Standard deviation of L, metres, below L: a tape held from the camera to above the centre of the rear wheel
  /// (TapeSigma).
  double lever_arm_sigma = kTapeSigma;
  double side_slip = kUsualSideSlip;                 ///< c, s^2/m
  double side_slip_sigma = kUsualSideSlipSigma;      ///< 0 where c is known exactly
  double yaw_sigma = kEstimatedYawSigma;             ///< of the yaw error of Q, rad
  double image_lag = 0;                              ///< of the orientation of stabilised images (ImageLag), s
  double image_lag_sigma = 0;                        ///< s; 0: there is no lag
  double roll_height = kUsualRollHeight;             ///< h: above the axis about which the body rolls, metres
  double roll_height_sigma = kUsualRollHeightSigma;  ///< metres
  /// H: height of the camera above the road, metres. 0: not known; estimated in turns.
  double camera_height = 0;
  double camera_height_sigma = 0;  ///< metres
  /// Of the errors of L and H: a height that turns have shown is as wrong as the lever arm they were read with.
  double height_correlation = 0;
  /// Of the errors of c and H: in the turns that have shown the height, more slip is less height.
  double height_slip_correlation = 0;
  /// Of the errors of L and c: turns at one speed have shown L - c v^2 only.
  double lever_arm_slip_correlation = 0;

  bool knows_lever_arm() const { return lever_arm > 0; }
  bool knows_height() const { return camera_height > 0; }
  /// No slip: the paper's car.
  bool is_rigid() const { return side_slip == 0 && side_slip_sigma == 0; }

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Indices of the unknowns of a drive. Only the log-scale and the road's error change along the drive.
enum DriveUnknown {
  kLogScale,   ///< ln(lambda), metres per odometry unit
  kDirection,  ///< direction of travel on straights according to Q, rad, positive to the right: minus Q's yaw error
  kSlip,       ///< c, s^2/m
  /// Time by which the orientation of stabilised images lags behind the car's, s; negative if it is ahead.
  kLag,
  kLogLeverArm,  ///< ln(L), L in metres
  kRollHeight,   ///< h, metres
  kLogHeight,    ///< ln(H), H in metres
  /// Deviation of the height above the road from H, in its standard deviations: load, slope, crown of the road.
  /// Exponentially correlated along the drive.
  kRoadError,
  kDriveUnknowns
};
using DriveState = Eigen::Matrix<double, kDriveUnknowns, 1>;
using DriveRow = Eigen::Matrix<double, 1, kDriveUnknowns>;
using DriveCovariance = Eigen::Matrix<double, kDriveUnknowns, kDriveUnknowns>;

/// Model of the height above the road.
struct RoadEvidenceOptions {
  /// Standard deviation of the deviation from H, relative: slope and crown of the road, errors of the images. On
  /// recorded drives, means over 40 m scatter by 0.2 to 0.5 %, over 160 m by 0.2 to 0.3 %.
  double sigma = 0.0075;
  /// Distance over which this deviation is correlated (1/e), metres.
  double correlation_length = 60;
  /// Standard deviation of a step's height, relative, that is independent of the next step's.
  double step_sigma = 0.015;
  /// A segment with fewer steps that show the road has no height.
  int min_steps = 2;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Standard deviations of a segment's deviation from the model of the drive. All its steps share this deviation, so it
/// does not average out within the segment.
struct EvidenceOptions {
  PooledLineOptions line;
  double turn_sigma = kTurnSigma;                     ///< effective lever arm of a turn, relative
  double slip_sigma = kTurnSlipSigma;                 ///< side slip of a turn, relative
  double turn_direction_sigma = kTurnDirectionSigma;  ///< direction of travel in a turn, rad
  /// Direction of travel as a turn shows it by itself, rad (0.25 deg): transients of the tyres and of the body. On
  /// recorded and rendered drives, turns scatter by 0.15 deg about that of the drive.
  double direction_in_turn_sigma = 0.25 / kDegreesPerRadian;
  double straight_direction_sigma = kStraightDirectionSigma;  ///< direction of travel on a straight segment, rad
  /// What lever arm and slip change in the direction of travel in the bends of a straight, relative: roads are banked,
  /// and before the scale is known, so is the lever arm in units.
  double bend_sigma = 0.4;
  /// Least ratio of effective to measured lever arm in a turn. In faster turns the scale depends on the slip rather
  /// than on the measured lever arm.
  double min_lever_arm_ratio = 0.25;
  RoadEvidenceOptions road;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The height of the camera above the road, as the steps of a segment show it.
struct RoadEvidence {
  double log_height = 0;  ///< of the height in odometry units
  double sigma = 0;       ///< relative, without the road's correlated error
  double length = 0;      ///< of the steps that show it, odometry units
};

/// The direction of travel on a straight, its bends taken out with a lever arm that is about right.
struct StraightDirection {
  double angle = 0;              ///< rad, positive to the right
  double sigma = 0;              ///< standard deviation of `angle`, rad
  double bend = 0;               ///< of the straight's bends: d angle / d lever arm, rad per odometry unit
  double bend_square_speed = 0;  ///< `bend` times the square of the speed there, rad units/s^2
  double bend_speed = 0;         ///< `bend` times the speed there, rad/s
  double bend_lever_arm = 0;     ///< with which the bends have been taken out, odometry units
};

/// What one segment measures: the effective lever arm of a turn and the direction of travel that it shows by itself, or
/// the direction of travel of a straight; and the height above the road. Each is empty where the steps do not show it.
struct SegmentEvidence {
  std::optional<PooledLine> turn;                    ///< also empty where the turn is left out (SelectTurns)
  std::string why_no_turn;                           ///< of a turn whose `turn` is empty; one line
  std::optional<DirectionInTurn> direction_in_turn;  ///< also of a turn that is too fast
  std::optional<StraightDirection> straight;
  std::optional<RoadEvidence> road;
};

/// What a segment may measure, in the order in which the filters take it.
enum MeasurementKind { kRoadHeight, kDirectionInTurn, kLeverArmOfTurn, kDirectionOfStraight, kMeasurementKinds };

/// Evidence of each segment, in order. Bends of straights are compensated with the median lever arm of the turns
/// (odometry units).
std::vector<SegmentEvidence> GatherEvidence(std::span<const VehicleStep> steps,
                                            const std::vector<PathSegment>& segments, const EvidenceOptions& options);

/// Evidence of a single turn, without the road.
SegmentEvidence EvidenceOfTurn(std::span<const VehicleStep> steps, const EvidenceOptions& options);

/// The direction of travel on a single straight, its bends compensated with a lever arm in odometry units. Empty where
/// the straight does not show it.
std::optional<StraightDirection> DirectionOnStraight(std::span<const VehicleStep> steps, double lever_arm,
                                                     const EvidenceOptions& options);

/// The height above the road as these steps show it: the robust mean of their log-heights. Empty where too few do.
std::optional<RoadEvidence> EvidenceOfRoad(std::span<const VehicleStep> steps, const RoadEvidenceOptions& options);

/// A scalar measurement, linearised at a state: innovation = measured - expected, by_state = d expected / d state.
struct Measurement {
  double innovation = 0;
  double variance = 0;  ///< including the segment's deviation from the model; without its robust weight
  DriveRow by_state = DriveRow::Zero();
};

/// The effective lever arm of a turn at a state:
///   (L + h by_roll_height) / lambda - c lambda mean_square_speed + lag mean_speed + direction by_direction.
Measurement LinearizeTurn(const PooledLine& turn, const DriveState& state, const EvidenceOptions& options);

/// The direction of travel that a turn shows by itself, direction - c lambda by_slip + lag by_lag, at a state.
Measurement LinearizeDirectionInTurn(const DirectionInTurn& turn, const DriveState& state,
                                     const EvidenceOptions& options);

/// The direction of travel on a straight at a state:
///   direction + bend (L / lambda - bend_lever_arm) - c lambda bend_square_speed + lag bend_speed,
/// of which by_state has the derivative by the direction only: bank and crown change the slip in bends, from which a
/// straight shall not refine c or lambda.
Measurement LinearizeStraight(const StraightDirection& straight, const DriveState& state,
                              const EvidenceOptions& options);

/// The height above the road, ln(H) - ln(lambda) + error, at a state. The error's standard deviation is that of its
/// mean over the way that shows the road.
Measurement LinearizeRoad(const RoadEvidence& road, const DriveState& state, const RoadEvidenceOptions& options);

/// One measurement of a segment.
struct SegmentMeasurement {
  MeasurementKind kind = kRoadHeight;
  Measurement linearized;
};

/// All measurements of a segment at a state, in the order of MeasurementKind.
std::vector<SegmentMeasurement> MeasurementsOf(const SegmentEvidence& evidence, const DriveState& state,
                                               const EvidenceOptions& options);

/// Whether the camera swings to the inside of the turn, where a lever arm swings it to the outside: slip outweighs the
/// lever arm, or the camera is behind the rear axle, or looks backward.
bool SwingsInward(const PooledLine& turn, const DriveState& state);

/// Why a turn is not usable at `state` (too fast, no outward motion): one line; empty if it is.
std::string WhyUnusable(const PooledLine& turn, const DriveState& state, const EvidenceOptions& options);

/// The single-turn scale (metres per unit), the other unknowns as in `state`.
double OwnScale(const PooledLine& turn, const DriveState& state);

}  // namespace turnscale

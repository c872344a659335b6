// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/geometry/angle.h"
#include "turnscale/scale/car_conflicts.h"
#include "turnscale/scale/image_stabilisation.h"
#include "turnscale/scale/scale_evidence.h"
#include "turnscale/scale/scale_filter.h"
#include "turnscale/scale/turn_estimate.h"
#include "turnscale/scale/turn_test.h"

namespace turnscale {

struct ScaleEstimatorOptions {
  PathSegmentOptions segments;
  EvidenceOptions evidence;
  DriftOptions drift;
  TurnTestOptions test;
  StabilisationOptions stabilisation;
  /// A measurement with a residual of more than this many sigmas is down-weighted (Huber).
  double huber = 1.5;
  /// There is no estimate if the smallest relative sigma of the scale exceeds this. Nor does a height with a larger one
  /// count as known.
  double max_sigma = 0.15;
  /// Height and lever arm are in conflict if they differ by more than this many standard deviations.
  double max_height_deviation = 3;
  /// The prior of the yaw is in conflict with the drive if they differ by more than this many standard deviations.
  double max_yaw_deviation = 4;
  /// Also if the mean direction of travel that the turns show by themselves differs from that of all other measurements
  /// and the prior by more than this many.
  double max_turn_yaw_deviation = 3;
  /// Standard deviation of the yaw error of Q, rad, that then takes the place of the prior's.
  double contradicted_yaw_sigma = kYawSigmaByEye;
  /// Single-turn scales are taken with the drive's yaw where that of the prior is wider than this, rad (0.5 deg).
  double max_given_yaw_sigma = 0.5 / kDegreesPerRadian;
  /// With single-turn scales, turns whose sigma exceeds the smallest one's by this factor are not used.
  double max_sigma_ratio = 3;
  /// Single-turn scales are used, as if the turns were inconsistent: for steps with known errors beyond their noise, as
  /// from a calibration that is inconsistent with the images.
  bool uses_single_turns = false;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// The car's constants as refined from the drive, with standard deviations.
struct CarRefinement {
  double yaw_error = 0;  ///< to be added to the yaw of Q, rad: positive if the camera looks further right
  double yaw_error_sigma = 0;
  double side_slip = 0;             ///< c in L_eff = L - c v^2, s^2/m
  double side_slip_sigma = 0;       ///< 0 where c was given as known exactly
  bool side_slip_at_bound = false;  ///< the estimate would be negative: c is fixed at 0
  double lever_arm = 0;             ///< metres; 0 if it is not known
  double lever_arm_sigma = 0;
  double lever_arm_slip_correlation = 0;  ///< of the errors of lever arm and c; 0 where one is not known or exact
  double roll_height = 0;                 ///< h: of the camera above the axis about which the body rolls, metres
  double roll_height_sigma = 0;
  double camera_height = 0;  ///< metres; 0 if neither given nor estimated
  double camera_height_sigma = 0;
  double height_correlation = 0;       ///< of the errors of camera height and lever arm
  double height_slip_correlation = 0;  ///< of the errors of camera height and c; 0 where c was given as known exactly
};

/// Mean and covariance of the car's constants: yaw error of Q (rad), c (s^2/m), ln(L), ln(H).
struct CarBelief {
  Eigen::Vector4d mean = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
};

/// What the drive tells of the car is the posterior's information less the prior's. For that, c may be negative in the
/// posterior, and its covariance leaves out `inflation`.
struct CarEvidence {
  CarBelief prior;
  CarBelief posterior;
  double inflation = 1;  ///< of the standard deviations, by the test of the turns
};

/// The scale of a drive, segment by segment.
struct ScaleEstimate {
  std::vector<PathSegment> segments;
  std::vector<ScaleBelief> smoothed;  ///< one per segment, from the whole drive; sigma includes what the test adds
  double length_sigma = 0;            ///< relative standard deviation of the path length in metres
  CarRefinement car;
  CarEvidence car_evidence;
  std::optional<HeightConflict> height_conflict;
  /// The estimate is made without the prior of the yaw, which contradicts the drive.
  std::optional<YawConflict> yaw_conflict;
  std::optional<SlipConflict> slip_conflict;
  /// Of images that are stabilised, by the turns or as known beforehand: the estimate is made with the lag; smoothing
  /// enlarges sigma.
  std::optional<ImageLag> image_lag;
  std::optional<ImageSmoothing> image_smoothing;
  std::vector<char> from_road;  ///< one per segment: no turn that is used, and the road shows its scale
  std::vector<TurnEstimate> turns;
  TurnTest test;  ///< do the turns agree with the estimate? `worst_turn` is a place in `turns`
  /// Single-turn scales are used: the test failed, the estimate did not converge, or the options ask for them; and a
  /// turn has one.
  bool uses_single_turns = false;
  double single_turn_spread = 0;  ///< where they are: by which they differ, relative; sigma includes it
  double single_turn_offset = 0;  ///< their median less the joint estimate, of ln(metres per unit)
  bool is_doubtful = false;       ///< by what the estimator does not see, such as a converted video; its caller sets it
  bool converged = false;

  bool is_stabilised() const { return image_lag || image_smoothing; }

  /// The joint estimate is used, and nothing contradicts it.
  bool agrees() const { return converged && !uses_single_turns && !height_conflict && !slip_conflict && !is_doubtful; }

  /// Whether the trajectory uses the refined constants of the car, and nothing contradicts them: another drive may.
  bool has_reliable_car() const { return agrees() && !is_stabilised(); }
};

/// The estimate, or in one line why there is none.
struct ScaleEstimateResult {
  std::optional<ScaleEstimate> estimate;
  std::string reason;
  /// Without what the estimate says of them: ScaleEstimate::turns has that.
  std::vector<TurnEstimate> detected_turns;
};

/// Maximum a posteriori scale of a drive from its steps. Each turn is one measurement: its effective
/// lever arm in units. Where the steps show the height above the road, each segment has another one. Unknowns are the
/// log-scale, a random walk, six constants with physical priors (the yaw error of Q, the side slip c, the lag of the
/// images, the lever arm, the heights of the camera above the roll axis and above the road), and the correlated error
/// of the road. Time is linear in the number of steps. In order:
///   evidence   what each segment of the drive measures (EvidenceOfDrive)
///   priors     the usable turns, a first value of the scale from them or from a given height, and the estimate with
///              robust weights (SmoothDrive). Where the drive contradicts the prior of the yaw, or the turns show that
///              the images are stabilised with a lag, again with a wider prior (FitPriors)
///   certainty  no estimate where even the smallest sigma exceeds max_sigma
///   test       the single-turn scales jointly against the estimate (TurnTest); sigma covers their scatter
///   smoothing  where turns begin before the car turns, sigma covers what this does to the scale (FindImageSmoothing)
///   height     a given height that is in conflict with the turns widens sigma, or is left out if the turns contradict
///              each other with it only
///   fallback   single-turn scales where the test has failed (UseSingleTurns); sigma covers their spread
ScaleEstimateResult EstimateScale(const std::vector<VehicleStep>& steps, const CarPrior& car,
                                  const ScaleEstimatorOptions& options);

}  // namespace turnscale

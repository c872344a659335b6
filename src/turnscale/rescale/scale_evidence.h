// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include <Eigen/Core>

#include "turnscale/rescale/pooled_sway.h"

namespace turnscale {

/// The unknowns of a drive, as places in a vector.
enum DriveUnknown {
  kLogScale,  ///< ln(lambda), metres per odometry unit; the only one that changes along the drive
  kTravel,    ///< direction of travel on straights as Q has it, rad, positive to the right: minus the yaw error of Q
  kSlip,      ///< c, s^2/m
  kHeight,    ///< of the camera above the axis the body rolls about, metres
};
using DriveState = Eigen::Vector4d;

/// Mean and covariance of the unknowns.
struct Belief {
  DriveState mean = DriveState::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
};

/// Standard deviations of a stretch's random effects: by how much it may differ from the model as a whole. Its steps
/// share them, so they do not average out.
struct StretchNoise {
  double lever = 0;      ///< of the effective lever arm, relative
  double direction = 0;  ///< of the direction of travel, rad
};

/// What one stretch says.
struct StretchObservation {
  PooledSway pooled;
  bool turning = false;  ///< only turns are asked for the scale: a road's bends hang together with its crown
  double distance = 0;   ///< from the middle of the stretch before, odometry units
  double angle = 0;      ///< turned since then, rad, >= 0
  double gap_sigma = 0;  ///< by which the log-scale may have jumped since then
  /// Weights of the random effects against StretchNoise, about 1; a bad turn has less (Student's t).
  double lever_weight = 1;
  double direction_weight = 1;
};

/// Coefficients of the sway at a state, for the tape's lever arm (metres).
Eigen::Vector4d SwayCoefficients(const DriveState& state, double lever_arm);
/// Their derivatives by the state.
Eigen::Matrix4d SwayCoefficientsJacobian(const DriveState& state, double lever_arm);

/// A stretch's cost, minus twice its log-likelihood, near a state, its two random effects eliminated:
/// cost(state + d) = cost - 2 gradient . d + d . information d.
struct ScaleEvidence {
  Eigen::Matrix4d information;
  Eigen::Vector4d gradient;
  double cost = 0;
  // What gives the random effects (lever, direction) back once the state is known.
  Eigen::Matrix2d effects_covariance;
  Eigen::Vector2d effects_gradient;
  Eigen::Matrix<double, 2, 4> effects_by_state;
};
ScaleEvidence EvidenceAt(const StretchObservation& observation, const DriveState& state, double lever_arm,
                         const StretchNoise& noise);

/// A stretch's random effects (relative lever arm, direction in rad), given where the evidence was taken and the belief
/// in the state.
struct RandomEffects {
  Eigen::Vector2d mean;
  Eigen::Vector2d variance;
};
RandomEffects RandomEffectsOf(const ScaleEvidence& evidence, const DriveState& taken_at, const Belief& belief);

/// Mean square of the speed in a turn, weighted as its steps are, in odometry units; 0 where times are unknown.
double MeanSquareSpeed(const PooledSway& pooled);

/// Effective lever arm over the tape's in a turn, at the scale of `state`: (L - c v^2) / L.
double LeverArmRatio(const PooledSway& pooled, const DriveState& state, double lever_arm);

/// The scale (metres per unit) that one stretch shows by itself, the other unknowns being those of `state`. Nothing
/// where the camera does not swing outwards.
std::optional<double> ScaleOfStretch(const PooledSway& pooled, const DriveState& state, double lever_arm);

}  // namespace turnscale

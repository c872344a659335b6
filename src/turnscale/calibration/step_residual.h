// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace turnscale {

/// A step as the refinement sees it: how the camera turned, and which way it went.
struct StepMeasurement {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< previous_from_current
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();          ///< unit vector in the previous camera frame
  double length = 0;                                             ///< camera's travel, in the odometry's unit
  int frames = 1;                                                ///< of which this is the mean
};

/// theta, where the camera goes in A (23), from the turning angle and the lever arm in units of the camera's travel:
/// theta = psi/2 + asin(2 lever_ratio sin(psi/2)). The same as (23), with the camera's travel s for the rear axle's:
/// rho^2 = s^2 - 4 L^2 sin^2(psi/2).
double TravelDirection(double psi, double lever_ratio);

/// Residuals of a step in vehicle axes, and their derivatives.
struct StepResidual {
  using Vector = Eigen::Matrix<double, 6, 1>;
  /// First three: sqrt(8) times the vector part of the quaternion of Q R^ Q^T R(psi)^T, whose square is the Frobenius
  /// norm of (15). Last three: Q u^ - t/|t|, which has the minimiser of (15)'s second part but not its flat bottom.
  Vector value;
  Eigen::Matrix<double, 6, 3> by_rotation;  ///< by a small rotation vector d in vehicle axes: Q becomes exp(d) Q
  Vector by_psi;
  Vector by_ratio;
};

/// Throws nothing; |2 lever_ratio sin(psi/2)| above 0.95 is taken as that, with derivative 0.
StepResidual EvaluateStep(const StepMeasurement& step, const Eigen::Quaterniond& vehicle_from_camera, double psi,
                          double lever_ratio);

/// One over the standard deviation of each residual.
using StepWeights = StepResidual::Vector;

/// What belongs to one step alone, and what it leaves over.
struct StepState {
  double psi = 0;          ///< rad
  double lever_ratio = 0;  ///< lever arm over the camera's travel
  bool ratio_free = true;  ///< kFree: not held at its bound
  StepResidual residual;   ///< weighted
  double huber = 1;        ///< (16)
};

/// Normal equations in (rotation, lever arm) with the rest of a step gone; they add up.
struct EliminatedStep {
  Eigen::Matrix4d hessian = Eigen::Matrix4d::Zero();
  Eigen::Vector4d gradient = Eigen::Vector4d::Zero();

  EliminatedStep& operator+=(const EliminatedStep& other) {
    hessian += other.hessian;
    gradient += other.gradient;
    return *this;
  }
};

/// How a step lies beside the model when psi is read from its rotation, rad.
struct ModelResidual {
  double pitch = 0;       ///< rotation about vehicle x
  double roll = 0;        ///< rotation about vehicle z
  double vertical = 0;    ///< direction of travel, positive upwards
  double horizontal = 0;  ///< direction of travel, positive to the right
  double by_psi = 0;      ///< how much of an error of psi goes into `horizontal`
};

ModelResidual ResidualOfModel(const StepMeasurement& step, const Eigen::Quaterniond& vehicle_from_camera,
                              double lever_ratio);

void Whiten(const StepWeights& weights, StepResidual& residual);

/// The psi of the least weighted residual at the state's lever ratio.
void FitTurningAngle(const StepMeasurement& step, const Eigen::Quaterniond& vehicle_from_camera,
                     const StepWeights& weights, StepState& state);

/// The psi and lever ratio (0...20: the car moves forward, and not less than a twentieth of L) of the least weighted
/// residual.
void FitFreeStep(const StepMeasurement& step, const Eigen::Quaterniond& vehicle_from_camera, const StepWeights& weights,
                 StepState& state);

/// Eliminates psi; the lever ratio is `per_lever_arm` times the lever arm. With `curvature`, the hessian is the one of
/// Huber's norm, which does not bend along its straight part; without, that of the reweighted squares.
EliminatedStep EliminateTurningAngle(const StepState& state, double per_lever_arm, bool curvature);

/// Eliminates psi and lever ratio.
EliminatedStep EliminateFreeStep(const StepState& state, bool curvature);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "turnscale/calibration/step_residual.h"

namespace turnscale {

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

// SPDX-License-Identifier: MIT
#include "turnscale/calibration/calibration.h"

#include <cmath>

#include "turnscale/base/error.h"
#include "turnscale/calibration/camera_axes.h"
#include "turnscale/calibration/linear_calibration.h"
#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/turn_detector.h"

namespace turnscale {
namespace {

int CountTurns(const std::vector<double>& psi, double least) {
  TurnDetectorOptions options;
  options.min_steps = 1;
  options.min_region_angle = least;
  TurnDetector detector(options);
  int turns = 0;
  for (const double angle : psi) turns += detector.Add(angle).has_value() ? 1 : 0;
  return turns + (detector.Finish().has_value() ? 1 : 0);
}

// In the camera's frame, a car goes one way; what only shakes or turns goes every way.
void CheckThatItDrives(const std::vector<CameraStep>& steps) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double length = 0;
  for (const CameraStep& step : steps) {
    sum += step.previous_from_current.translation;
    length += step.previous_from_current.translation.norm();
  }
  constexpr double kLeastShare = 0.5;
  if (sum.norm() >= kLeastShare * length) return;
  throw InputError("no direction of travel: the camera stands still, turns on the spot, or is not fixed to a car");
}

std::string WhatIsMissing(const Calibration& calibration, const CalibrationOptions& options) {
  if (calibration.turning < options.min_turn || calibration.turns == 0) {
    return "no turn yet: roll and yaw offset not observable";
  }
  if (calibration.linear.confidence < options.min_confidence) {
    return "the turns are not significant against the noise: roll and yaw offset not observable";
  }
  return "";
}

std::vector<StepMeasurement> Measurements(const std::vector<CameraStep>& steps) {
  std::vector<StepMeasurement> measurements;
  for (const CameraStep& step : steps) measurements.push_back(MeasurementOf(step));
  return measurements;
}

// Without a turn there is no axis that the rotation could contradict.
Refinement RefineFrom(const Eigen::Quaterniond& start, const Eigen::Vector3d& turning_axis,
                      const std::vector<CameraStep>& steps, const CalibrationOptions& options) {
  const std::vector<StepMeasurement> measurements = Measurements(steps);
  if (auto refinement = RefineRotationAbout(turning_axis, measurements, start, options.refinement)) return *refinement;
  return RefineRotation(measurements, start, options.refinement);
}

void Refine(const std::vector<CameraStep>& steps, const Eigen::Vector3d& turning_axis,
            const CalibrationOptions& options, Calibration& calibration) {
  calibration.refinement = RefineFrom(calibration.linear.vehicle_from_camera, turning_axis, steps, options);
  if (options.body_lean) {
    const Eigen::Quaterniond leaning = calibration.refinement.vehicle_from_camera;
    calibration.lean = FitBodyLean(steps, leaning);
    calibration.refinement = RefineFrom(leaning, turning_axis, Levelled(steps, leaning, calibration.lean), options);
  }
  calibration.vehicle_from_camera = calibration.refinement.vehicle_from_camera;
  const double of_lean = calibration.lean.sigma * calibration.lean.mean_acceleration;
  const Eigen::Vector3d more(options.motion_bias, options.motion_bias, of_lean);
  calibration.covariance = calibration.refinement.covariance;
  calibration.covariance.diagonal() += more.cwiseAbs2();
}

}  // namespace

void CalibrationOptions::Check() const {
  refinement.Check();
  if (!(min_turn >= 0)) throw InputError("min_turn: must not be negative");
  if (!(min_confidence >= 1)) throw InputError("min_confidence: must be at least 1");
  if (!(motion_bias >= 0)) throw InputError("motion_bias: must not be negative");
  if (!(counted_turn > 0)) throw InputError("counted_turn: must be above 0 rad");
}

std::vector<CameraStep> DrivenForward(std::vector<CameraStep> steps, int& reversed) {
  Eigen::Vector3d way = Eigen::Vector3d::Zero();
  for (const CameraStep& step : steps) way += step.previous_from_current.translation;
  reversed = 0;
  for (CameraStep& step : steps) {
    if (step.previous_from_current.translation.dot(way) >= 0) continue;
    step = Reversed(step);
    ++reversed;
  }
  return steps;
}

Calibration Calibrate(const std::vector<CameraStep>& given, const CalibrationOptions& options) {
  options.Check();
  Calibration calibration;
  const std::vector<CameraStep> steps = DrivenForward(given, calibration.reversed);
  calibration.steps = static_cast<int>(steps.size());
  constexpr int kLeastSteps = 3;
  if (calibration.steps < kLeastSteps) {
    throw InputError("too little motion: " + std::to_string(calibration.steps) +
                     " usable steps, at least 3 are needed");
  }
  CheckThatItDrives(steps);
  TurningAxis axis;
  for (const CameraStep& step : steps) axis.Add(step.previous_from_current.rotation);
  LinearCalibration linear;
  for (const CameraStep& step : steps) {
    const RigidTransform motion = WholeMotion(step);
    linear.Add(motion, TurningAngle(motion.rotation, axis.direction()));
  }
  calibration.linear = linear.Solve();
  Refine(steps, axis.direction(), options, calibration);
  calibration.angles = YawPitchRollFromRotation(calibration.vehicle_from_camera);
  calibration.sigma = SigmaOfAngles(calibration.vehicle_from_camera, calibration.covariance);
  std::vector<double> psi;
  for (const CameraStep& step : steps) {
    psi.push_back(step.frames * TurningMotionOf(step.previous_from_current, calibration.vehicle_from_camera).psi);
    calibration.turning += std::abs(psi.back());
  }
  calibration.turns = CountTurns(psi, options.counted_turn);
  calibration.problem = WhatIsMissing(calibration, options);
  calibration.observable = calibration.problem.empty();
  return calibration;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/laboratory/calibration_trials.h"

#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "turnscale/base/error.h"
#include "turnscale/calibration/camera_axes.h"
#include "turnscale/calibration/step_residual.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

double Wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

YawPitchRoll Difference(const Eigen::Quaterniond& found, const Eigen::Quaterniond& truth) {
  const YawPitchRoll a = YawPitchRollFromRotation(found);
  const YawPitchRoll b = YawPitchRollFromRotation(truth);
  return {Wrapped(a.yaw - b.yaw), Wrapped(a.pitch - b.pitch), Wrapped(a.roll - b.roll)};
}

}  // namespace

CalibrationOptions PaperCalibrationOptions() {
  CalibrationOptions options;
  options.refinement.road_bank = 0;
  options.refinement.grade_change = 0;
  options.body_lean = false;
  options.motion_bias = 0;
  return options;
}

Eigen::Quaterniond RotationFromPaperAngles(double z_deg, double y_deg, double x_deg) {
  const auto about = [](double degrees, const Eigen::Vector3d& axis) {
    return RotationFromVector(degrees / kDegreesPerRadian * axis);
  };
  return about(z_deg, Eigen::Vector3d::UnitZ()) * about(y_deg, Eigen::Vector3d::UnitY()) *
         about(x_deg, Eigen::Vector3d::UnitX());
}

PaperDriveOptions PaperCalibrationDrive() {
  PaperDriveOptions drive;
  drive.lever_arm = 1;
  drive.vehicle_from_camera = RotationFromPaperAngles(5, 15, -10);
  return drive;
}

std::vector<CalibrationTrial> RunCalibrationTrials(const CalibrationTrials& trials) {
  const std::vector<AckermannStep> steps = PaperDriveSteps(trials.drive);
  const Eigen::Quaterniond& truth = trials.drive.vehicle_from_camera;
  std::vector<CalibrationTrial> results(trials.runs);
  const auto run = [&](int i) {
    const OdometryNoise noise{trials.rotation_noise, trials.direction_share * trials.rotation_noise,
                              SeedOfRun(trials.seed, i)};
    const Trajectory path = NoisyCameraPath(steps, trials.drive, noise);
    const Calibration found = Calibrate(StepsAlong(path, trials.steps), trials.calibration);
    results[i] = {Difference(found.linear.vehicle_from_camera, truth), Difference(found.vehicle_from_camera, truth),
                  found.sigma};
  };
  const bool finished = ParallelRuns(trials.runs, trials.jobs, run, trials.progress);
  return finished ? results : std::vector<CalibrationTrial>();
}

YawPitchRoll CramerRaoBound(const CalibrationTrials& trials) {
  if (!(trials.rotation_noise > 0)) throw InputError("rotation_noise: must be above 0 rad for there to be a bound");
  if (!(trials.direction_share > 0)) throw InputError("direction_share: must be above 0 for there to be a bound");
  const Eigen::Quaterniond& truth = trials.drive.vehicle_from_camera;
  StepWeights weights;
  // The rotation's residual is sqrt(2) times the angle.
  weights.head<3>().setConstant(1 / (std::sqrt(2.0) * trials.rotation_noise));
  weights.tail<3>().setConstant(1 / (trials.direction_share * trials.rotation_noise));
  EliminatedStep sum;
  for (const AckermannStep& step : PaperDriveSteps(trials.drive)) {
    const RigidTransform motion = ConstrainedCameraMotion(step, trials.drive.lever_arm, truth);
    const double length = motion.translation.norm();
    StepState state;
    state.residual = EvaluateStep({motion.rotation, motion.translation / length, length}, truth, step.psi,
                                  trials.drive.lever_arm / length);
    Whiten(weights, state.residual);
    sum += EliminateTurningAngle(state, 1 / length, false);
  }
  const Eigen::Matrix4d covariance = sum.hessian.inverse();
  return SigmaOfAngles(truth, covariance.topLeftCorner<3, 3>());
}

}  // namespace turnscale

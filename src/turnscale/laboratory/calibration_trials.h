// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "turnscale/calibration/calibration.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/laboratory/paper_drive.h"
#include "turnscale/laboratory/parallel_runs.h"

namespace turnscale {

/// For the paper's car, whose body is rigid, on a flat world, with an odometry that errs from frame to frame only.
CalibrationOptions PaperCalibrationOptions();

/// The paper's Monte-Carlo evaluation of the calibration (V-B 1, Fig. 9).
struct CalibrationTrials {
  PaperDriveOptions drive;
  /// Of each frame's rotation, rad about each axis.
  double rotation_noise = 0;
  /// Of each frame's direction of travel over that of its rotation. The paper leaves it open; 1 gives both the same.
  double direction_share = 1;
  int runs = 100;
  int jobs = 1;
  std::uint64_t seed = 1;
  RunProgress progress;
  StepOptions steps;
  CalibrationOptions calibration = PaperCalibrationOptions();
};

/// What one run gives, rad.
struct CalibrationTrial {
  YawPitchRoll linear;   ///< error of the linear solution
  YawPitchRoll refined;  ///< error of the refinement
  YawPitchRoll sigma;    ///< as the refinement states it
};

/// Q from the z-y-x Euler angles that the paper gives it, degrees: R_z(z) R_y(y) R_x(x) about the axes of {A}, x right,
/// y down, z forward. The paper calls the middle one pitch, and "the rotation around the y-axis of {A}" (V-B 1): the
/// car turns about that axis, and it is nearly the yaw of YawPitchRoll. Likewise z is nearly the roll, and x the pitch.
Eigen::Quaterniond RotationFromPaperAngles(double z_deg, double y_deg, double x_deg);

/// The paper's camera: L = 1 m, Q = {5, 15, -10} deg.
PaperDriveOptions PaperCalibrationDrive();

/// One entry per run; every run has noise of its own. Same options, same bits for any number of jobs. Empty where
/// `progress` stopped it. Throws as PaperDriveSteps and Calibrate do.
std::vector<CalibrationTrial> RunCalibrationTrials(const CalibrationTrials& trials);

/// The least standard deviations (rad) that any unbiased estimator can have on the drive: Cramer and Rao's bound for
/// Q, one lever arm, and a turning angle for each frame, with the noise of the trials. Throws InputError where there is
/// none.
YawPitchRoll CramerRaoBound(const CalibrationTrials& trials);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "turnscale/calibration/calibration.h"
#include "turnscale/calibration/camera_step.h"
#include "turnscale/calibration/lever_arm_fit.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {

/// Input and result of a calibration.
struct CalibrationReport {
  std::string input;
  int frames = 0;  ///< poses
  Calibration calibration;
  std::optional<LeverArmFit> lever_arm;  ///< measured, or given: then without sigma
};

/// `calibration.yaml`, fit for `run --camera-rotation`.
std::string CalibrationYaml(const CalibrationReport& report);

/// The same for people, a line a thing.
std::string CalibrationText(const CalibrationReport& report);

/// The online estimate after a step.
struct CalibrationMoment {
  double time = 0;                                            ///< seconds; the step's end
  int frames = 0;                                             ///< taken in up to here
  double psi = 0;                                             ///< turning angle of a frame, rad
  Eigen::Vector4d singular_values = Eigen::Vector4d::Zero();  ///< of (14), smallest first
  YawPitchRoll angles;                                        ///< rad
  YawPitchRoll sigma;                                         ///< rad; infinite before the first turn
  bool moved = false;
};

/// The online calibration of a drive, step by step.
std::vector<CalibrationMoment> CalibrationHistory(const std::vector<CameraStep>& steps);

/// One line per step, with a heading.
std::string HistoryCsv(const std::vector<CalibrationMoment>& history);

/// Fig. 3 as SVG over time: turning angle, two smallest singular values, angles with their one-sigma bands. `truth`,
/// where known, is dashed. A long history is thinned to what a page shows.
std::string HistorySvg(const std::vector<CalibrationMoment>& history, const std::string& title,
                       const std::optional<YawPitchRoll>& truth = std::nullopt);

}  // namespace turnscale

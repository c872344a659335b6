// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/calibration/calibration.h"
#include "turnscale/calibration/lever_arm_fit.h"

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

}  // namespace turnscale

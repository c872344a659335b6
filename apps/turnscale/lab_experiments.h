// SPDX-License-Identifier: MIT
#pragma once

#include "lab_output.h"

namespace turnscale {

/// Figures 4 (b), 6 and 7 of the paper, from closed form.
LabResult LabFigure4();
LabResult LabFigure6();
LabResult LabFigure7();

/// The rest draws random numbers; the result is empty where the progress asked to stop (Figure 8 is one run, and asks
/// when that is done).
LabResult LabFigure8(const LabSettings& settings);    ///< the synthetic drive
LabResult LabFigure9(const LabSettings& settings);    ///< calibration
LabResult LabFigure10(const LabSettings& settings);   ///< one recovery a noise level
LabResult LabTable1(const LabSettings& settings);     ///< the recovery's errors over many runs
LabResult LabAblations(const LabSettings& settings);  ///< the recovery with one thing changed at a time
LabResult LabCoverage(const LabSettings& settings);   ///< how often the truth is within the stated sigmas

}  // namespace turnscale

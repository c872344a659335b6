// SPDX-License-Identifier: MIT
#pragma once

#include "lab_output.h"

namespace turnscale {

/// Figures 4 (b), 6 and 7 of the paper, from closed form.
LabResult LabFigure4();
LabResult LabFigure6();
LabResult LabFigure7();

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/geometry/angle.h"

namespace turnscale {

// Standard deviations of what the kinematics of LeverArm leave out in a turn or a straight. All its steps share them.

/// Effective lever arm of a turn, relative: effects not modelled (road bank, transients of the tyres, drift of the
/// odometry within the turn). Turns of simulated cars with sprung bodies scatter by 0.3 to 0.8 %.
constexpr double kTurnSigma = 0.0075;
/// Side slip of a turn, relative: grip and load differ from turn to turn.
constexpr double kTurnSlipSigma = 0.2;
/// Direction of travel in a turn, rad (0.05 deg): road bank. Gravity loads the tyres by it, so a bank of 1.1 deg
/// changes the slip angle by this much.
constexpr double kTurnDirectionSigma = 0.05 / kDegreesPerRadian;
/// Direction of travel on a straight, rad (0.1 deg): crown of the road, side wind, lane changes.
constexpr double kStraightDirectionSigma = 0.1 / kDegreesPerRadian;

}  // namespace turnscale

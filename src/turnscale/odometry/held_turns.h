// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/mapping/map_scaling.h"
#include "turnscale/odometry/drive_scale.h"

namespace turnscale {

/// Turns to be held by the absolute scale recovery (24)-(30), as `--method turns` and `--method paper` do: those that
/// the estimate follows (TurnEstimate::followed). The result of another says why it is left out.
std::vector<TurnScale> TurnsToHold(const Map& map, const MountCalibration& mount, const OdometryOptions& options,
                                   std::vector<TurnResult>& turns);

/// Brings the finished map to metres by its turns, each held at its own scale (`turns`, and where the smoothed estimate
/// fell back to them), or each of its steps at what its own angles say (`paper`). `refined` has the turns and sigmas of
/// the drive, and gets the path of the recovered map. Returns the factors by which lengths at each keyframe have grown;
/// empty where no turn gives the scale.
std::vector<double> HoldTurns(const OdometryOptions& options, const MountCalibration& mount, Map& map,
                              RefinedScale& refined);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/mapping/map_scaling.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// Turns to be constrained by the absolute scale recovery (24)-(30), for `--method turns` and `--method paper`: those
/// with TurnEstimate::used_singly. The others get the reason why they are left out.
std::vector<TurnScale> TurnsToConstrain(const Map& map, const MountCalibration& mount, const OdometryOptions& options,
                                        std::vector<TurnResult>& turns);

/// Scales the finished map to metres, with the length of each turn constrained to its single-turn scale (`turns`, and
/// the fallback of `smoothed`), or of each of its steps to the length from its own angles (`paper`). `refined` has the
/// turns and sigmas of the drive, and gets the trajectory of the recovered map. Returns the factors by which lengths at
/// each keyframe have changed; empty, with `refined.constrained` false and its path as it was, if no turn gives the
/// scale, or a pose of the map is not finite.
std::vector<double> ConstrainTurns(const OdometryOptions& options, const MountCalibration& mount, Map& map,
                                   RefinedScale& refined);

/// By how much the adjusted path differs from the interpolated one: the sum of the differences in length of short
/// sections, relative to the length of the path, or 0 where that is within two standard deviations of the path length.
/// Bridged steps do not count. Both paths take the scale of the same turns, but only the interpolated one follows the
/// estimated drift between them.
double DifferenceFromInterpolated(const Map& map, const RefinedScale& adjusted, const RefinedScale& interpolated);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/kinematics/lever_arm.h"
#include "turnscale/kinematics/pooled_scale.h"
#include "turnscale/kinematics/turn_detector.h"
#include "turnscale/kinematics/turning_motion.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/rescale/pose_scale.h"
#include "turnscale/scale/map_scaling.h"

namespace turnscale {

/// What the camera did on the step from keyframe `step` to the next.
TurningMotion StepMotion(const Map& map, int step, const MountCalibration& mount);

/// The steps of a turn, for the scale observer.
std::vector<TurningStep> StepsOfTurn(const Map& map, const TurningRegion& region, const MountCalibration& mount);

/// A turn to be held at `factor` metres per unit of the map, its shape as it is.
TurnScale HeldTurn(const TurningRegion& region, double factor);

/// Holds every step at what its own angles say (22), as the paper does; steps that say nothing are not held.
void HoldEachStep(const std::vector<TurningStep>& steps, const LeverArm& lever_arm, TurnScale& turn);

/// Puts what all turns of the drive say of this one (DriveScaleOf) in the place of what it says itself, to be weighed
/// by its variance. Where they say nothing the turn stays as it is, and false comes back. Lengths of the map
/// at keyframe k are `unit_at_keyframe[k]` times those in the unit of the scales.
bool WeighSmoothed(const std::vector<PoseScale>& scales, const Map& map, const std::vector<double>& unit_at_keyframe,
                   TurnScale& turn);

}  // namespace turnscale

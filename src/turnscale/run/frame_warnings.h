// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/mount_jump.h"
#include "turnscale/run/drive_facts.h"

namespace turnscale {

/// Warning that a frame is skipped, and why.
std::string SkippedWarning(int frame, const std::string& problem);

/// When and how the camera was moved on the car; the time counts from `first_time`, seconds.
std::string CameraMoveText(const MountMove& move, double first_time);

/// Warning where the odometry finds such a move, at this frame.
std::string CameraMovedWarning(int frame, const MountMove& move, double first_time);

/// When and how the camera has jumped on the car; the time of the jump counts from `first_time`, seconds.
std::string CameraJumpText(const MountJump& jump, double first_time);

/// Warning of `run` that the camera has jumped.
std::string CameraJumpWarning(const MountJump& jump, double first_time);

/// One line that names the first of them; there has to be one.
std::string UnreadableText(const std::vector<UnreadableFrame>& frames);

}  // namespace turnscale

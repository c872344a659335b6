// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "turnscale/kinematics/ackermann.h"
#include "turnscale/kinematics/vehicle_step.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/mount_calibration.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/road_heights.h"
#include "turnscale/scale/scale_filter.h"

namespace turnscale {

/// Whether a length in metres is given, from which the scale may come.
bool HasMetres(const VehicleOptions& vehicle);

/// Standard deviation of the yaw of the camera-to-vehicle rotation, rad, as given or found.
double YawSigma(const VehicleOptions& vehicle, const Mount& mount);

/// The car's constants before the drive. Without a length in metres the lever arm is 1: turns are found with any. The
/// height is the one that the images show: of one that was measured, they may be off by `aspect_sigma` (CameraModel).
CarPrior PriorOf(const VehicleOptions& vehicle, const Mount& mount, double aspect_sigma);

/// Centre of a keyframe's camera, or of that of the last one before it that is finite.
Eigen::Vector3d KnownCentre(const Map& map, int keyframe);

/// Position of the camera in the vehicle's axes, which may change on the way where the camera was moved.
StampedPose VehiclePose(const Map& map, const MountCalibration& mount, int keyframe);

/// The loss of tracking before a keyframe, if there is one.
std::optional<PathGap> GapBefore(const Map& map, int keyframe);

/// Sets what the map says of a step beside its motion: its height above the road, and how well the landmarks determine
/// the unit of length along it.
void CompleteStep(const Map& map, const std::vector<MeasuredHeight>& heights, const DriftOptions& drift,
                  VehicleStep& step);

/// The steps along all keyframes of a map.
std::vector<VehicleStep> StepsAlong(const Map& map, const MountCalibration& mount,
                                    const std::vector<MeasuredHeight>& heights, const OdometryOptions& options);

/// Camera motion from keyframe `keyframe` to the next, without that of the camera on the car.
TurningMotion StepMotion(const Map& map, int keyframe, const MountCalibration& mount);

}  // namespace turnscale

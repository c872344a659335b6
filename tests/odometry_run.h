// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "street_drive.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rigid_transform.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/mount_jump.h"
#include "turnscale/odometry/options.h"
#include "turnscale/odometry/refined_scale.h"
#include "turnscale/odometry/results.h"

namespace turnscale {

/// All that a drive through the odometry gave.
struct OdometryRun {
  std::vector<FrameResult> live;  ///< what each call returned
  std::vector<FrameResult> refined;
  RefinedScale scale;             ///< what the whole drive says of it
  std::vector<TurnResult> turns;  ///< of `scale`
  double lens_correction = 0;
  Map map;
  cv::Mat mask;  ///< of pixels left out at the end; empty if none are
  bool upside_down = false;
  std::vector<MountJump> mount_jumps;
};

/// An empty image stands for one that could not be read.
OdometryRun RunOdometry(const OdometryOptions& options, const CameraModel& camera, const std::vector<cv::Mat>& images,
                        const std::vector<double>& times);
OdometryRun RunOdometry(const OdometryOptions& options, const StreetDrive& drive);

/// The defaults, and the rendered car: its lever arm, no side slip.
OdometryOptions StreetOptions();

bool AllPosed(const std::vector<FrameResult>& frames);
int Count(const std::vector<FrameResult>& frames, TrackingState state);

/// Errors of refined frames, all of them posed.
struct RunErrors {
  double path_length = 0;  ///< (estimated - true) / true
  double psi_rms_deg = 0;  ///< turning angle between keyframes, on turning keyframes
  double position = 0;     ///< largest after the rigid alignment, metres
  double shape = 0;        ///< largest after the similarity alignment, metres
};

RunErrors MeasureRun(const std::vector<FrameResult>& refined, const std::vector<RigidTransform>& truth);

/// That all frames are posed, with errors as small as they are on streets that the default settings fit.
void ExpectMetres(const OdometryRun& run, const StreetDrive& drive);

}  // namespace turnscale

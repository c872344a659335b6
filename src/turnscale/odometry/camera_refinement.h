// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/calibration_check.h"
#include "turnscale/mapping/lens_refinement.h"
#include "turnscale/mapping/map.h"
#include "turnscale/odometry/background.h"
#include "turnscale/odometry/options.h"

namespace turnscale {

/// Refines the radial correction and tests the given intrinsics during the drive, on windows of keyframes in which the
/// camera turns. Windows are read in the background; what they show is taken some keyframes later.
class CameraRefinement {
 public:
  CameraRefinement(const OdometryOptions& options, const CameraModel& camera);

  /// Starts to read copies of the windows that are due at the latest keyframe, if there are any. Does nothing while the
  /// findings of earlier ones have not been taken.
  void StartIfDue(const Map& map);

  /// Findings that are pending are due now.
  void Hurry() { pending_.Hurry(); }

  /// Takes the findings that are due at the latest keyframe; waits for them. Returns the radial correction that the map
  /// should have instead of its own; empty if it stays.
  std::optional<double> TakeIfDue(const Map& map);

  /// Relative standard deviation of the scale for a calibration that is uncertain, or inconsistent with the windows
  /// whose findings were taken.
  double scale_sigma() const { return taken_.scale_sigma; }

  /// With all windows so far: waits for those that are being read. Without those whose reading failed, which TakeIfDue
  /// says.
  LensRefinement lens() const { return Latest().lens; }
  CalibrationCheck calibration_check() const { return Latest().check; }

 private:
  /// What the windows that were read show.
  struct Findings {
    LensRefinement lens;
    bool lens_changed = false;  ///< by the latest window
    CalibrationCheck check;
    double scale_sigma = 0;
  };
  const Findings& Latest() const;

  Findings taken_;
  DueResult<Findings> pending_;
};

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/parameter_estimate.h"
#include "turnscale/mapping/shutter_readout.h"
#include "turnscale/odometry/metric_path.h"
#include "turnscale/odometry/results.h"
#include "turnscale/scale/camera_height.h"
#include "turnscale/scale/scale_estimator.h"

namespace turnscale {

/// The scale at a keyframe.
struct KeyframeScale {
  double sigma = std::numeric_limits<double>::infinity();  ///< relative; infinite while the scale is pending
  ScaleState state = ScaleState::kPending;                 ///< of it and of the frames that follow
  bool turning = false;                                    ///< the step that leads to the keyframe belongs to a turn

  bool operator==(const KeyframeScale&) const = default;
};

/// The scale estimated from the whole drive.
struct RefinedScale {
  MetricPath path;
  std::vector<KeyframeScale> keyframes;
  std::vector<TurnResult> turns;
  std::optional<ScaleEstimate> estimate;  ///< empty while the scale is pending
  std::string reason;                     ///< why it is empty
  /// The map was adjusted with the lengths of turns constrained (ConstrainTurns): `path` is that of the adjusted map.
  bool constrained = false;
  std::optional<UnusualHeight> unusual_height;  ///< WidenForHeight's; sigmas of the scale include its error
  double gap_sigma = 0;  ///< standard deviation of the path's length due to parts that are not measured, metres
  /// Intrinsics that are inconsistent with the images of turns; sigmas include their effect on the scale.
  std::vector<ParameterEstimate> contradicted_calibration;
  /// The camera file's readout of a rolling shutter, where the turns contradict it and nothing else; theirs is used.
  std::optional<ParameterEstimate> contradicted_readout;
  /// Those that may be, where none is; likewise (DoubtsAmong).
  std::vector<ParameterEstimate> doubtful_calibration;
  double doubt_sigma = 0;             ///< their part of `calibration_sigma`
  bool calibration_in_doubt = false;  ///< for that reason, or as the turns do not determine the focal length
  double calibration_sigma = 0;  ///< CalibrationSigma and what WidenScale has added; the sigmas of the scale include it
  double aspect_sigma = 0;       ///< of the pixels, relative (CameraModel): of heights above the road alone
  int calibration_windows = 0;   ///< parts of turns in which the intrinsics were tested
  std::optional<ShutterReadout> readout;  ///< of a rolling shutter, if the images of turns show one
};

/// State of the scale at the last keyframe; pending without one.
ScaleState StateAtEnd(const RefinedScale& refined);

/// Relative standard deviation of the scale due to the estimated errors of the calibration: the error of the direction
/// of travel over the lever arm's contribution to it. A coarse bound (benchmarks/variants): the scale from such a
/// calibration is not reliable. Without contradictions only the standard deviation of the focal length of `camera`
/// counts, with which the map is made.
double CalibrationSigma(const std::vector<ParameterEstimate>& contradictions, const CameraModel& camera);
/// Of the contradictions, or else of the doubts.
double CalibrationSigma(const std::vector<ParameterEstimate>& contradictions,
                        const std::vector<ParameterEstimate>& doubts, const CameraModel& camera);

/// Adds a relative standard deviation to all sigmas of the scale, in quadrature.
void WidenScale(double sigma, RefinedScale& refined);

/// The same with CalibrationSigma of the contradictions, or else of the doubts.
void WidenForCalibration(const std::vector<ParameterEstimate>& contradictions,
                         const std::vector<ParameterEstimate>& doubts, const CameraModel& camera,
                         RefinedScale& refined);

/// Finds an unusual height of the camera, and adds the error that the scale then has; the estimate is doubtful. For a
/// height that was not given. Call it after all that widens sigma otherwise.
void WidenForHeight(RefinedScale& refined);

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turnscale/frames/blended_frames.h"
#include "turnscale/mapping/parameter_estimate.h"
#include "turnscale/odometry/refined_scale.h"

namespace turnscale {

/// What a drive shows to be wrong with its images or their calibration.
struct ImageFindings {
  bool is_upside_down = false;
  int rotated = 0;  ///< degrees clockwise, by `--rotate`
  std::optional<FrameBlending> blending;
  std::vector<ParameterEstimate> contradicted_calibration;  ///< by the images of turns
  std::vector<ParameterEstimate> doubtful_calibration;      ///< likewise, less clearly; where none is contradicted
  bool is_calibration_refined = false;                      ///< it was estimated from the drive
  bool has_distortion = true;                               ///< it has the distortion of a lens
  /// What else is wrong with the drive, and may follow from a contradicted calibration: parts of a sentence.
  std::vector<std::string> consequences;
};

/// One line for each finding, one for all that contradicts the calibration; that is left out where images that are
/// upside down explain it. Times count from `first_time`, seconds. `blending_error`, `calibration_error`: what follows
/// for the results, such as "the scale may be wrong". The line of the calibration has the latter, which may be empty,
/// and says that blending may be the cause.
std::vector<std::string> ImageWarnings(const ImageFindings& findings, double first_time,
                                       const std::string& blending_error, const std::string& calibration_error);

/// That the images of turns contradict the readout time of the camera file, and what is used; empty where they do not.
std::string ContradictedReadoutText(const RefinedScale& scale);

/// What to do about images that have been rotated by `rotated` degrees, and have to be by `more` degrees more.
std::string RotationAdvice(int rotated, int more);

}  // namespace turnscale

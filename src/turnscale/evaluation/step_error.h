// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "turnscale/evaluation/association.h"
#include "turnscale/evaluation/keyframe_table.h"
#include "turnscale/evaluation/statistics.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {

/// A stretch of the drive between two pairs, given by their places.
struct Step {
  int first = 0;
  int last = 0;
  bool turning = false;
};

struct StepErrorOptions {
  /// Without keyframes a step ends where the truth has travelled this far, metres: long against the centimetres by
  /// which a ground truth jumps, short against a turn.
  double length = 1.0;
  /// Without keyframes a step turns when the true turning angle exceeds this, radians.
  double turning_angle = 2.0 / kDegreesPerRadian;
  /// Steps over which the truth travels less are left out of the scale errors, metres: (33) divides by it, and at
  /// standstill it is noise.
  double shortest_length = 0.2;
  /// The paper's Q: turning angles are those of the vehicle.
  Eigen::Quaterniond vehicle_from_camera = Eigen::Quaterniond::Identity();
};

/// Steps of `options.length` along the true path.
std::vector<Step> StepsAlongPath(const PosePairs& pairs, const StepErrorOptions& options = {});

/// How the rows of a keyframe table and the pairs find each other.
enum class KeyframeKey {
  kTime,   ///< same time within a millisecond
  kFrame,  ///< the row's frame is the pair's time, for estimates whose times are frame numbers
};

/// Steps from keyframe to keyframe; a step turns when the keyframe at its end is marked so. Keyframes without a pair
/// are passed over, so there may be no step at all.
std::vector<Step> StepsBetweenKeyframes(const PosePairs& pairs, const std::vector<KeyframeRow>& keyframes,
                                        KeyframeKey key);

/// Errors over a set of steps.
struct StepErrors {
  ErrorStatistics scale;  ///< the scale error ratio (33), |s - s_true| / s_true; times 100 is the paper's per cent
  ErrorStatistics psi;    ///< turning angle, radians
};

/// Errors of all steps, or of the turning ones only. Every estimated translation is multiplied by `scale` first.
StepErrors MeasureSteps(const PosePairs& pairs, const std::vector<Step>& steps, bool turning_only, double scale = 1,
                        const StepErrorOptions& options = {});

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "turnscale/evaluation/association.h"
#include "turnscale/evaluation/keyframe_table.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/geometry/similarity.h"

namespace turnscale {

/// Statistics of a set of errors, in the errors' unit; NaN if there are none.
struct ErrorStatistics {
  int count = 0;
  double rms = std::numeric_limits<double>::quiet_NaN();
  double median = std::numeric_limits<double>::quiet_NaN();  ///< of the magnitudes
  double max = std::numeric_limits<double>::quiet_NaN();     ///< of the magnitudes
};

ErrorStatistics Summarize(std::vector<double> errors);

/// Distances between the true positions and the estimated ones after an alignment (absolute trajectory error, ATE).
struct PositionErrors {
  Similarity truth_from_estimate;  ///< the alignment
  ErrorStatistics distance;        ///< metres; rms is what is called the ATE
};

/// Without alignment: only the first poses are laid on each other, so that the two files may start from different
/// world frames. Nothing changes for files that both start at identity.
PositionErrors MeasurePositionsFromFirstPose(const PosePairs& pairs);

/// After the alignment of all positions in the sense of least squares.
/// Throws InputError when the positions do not determine it (see AlignPoints).
PositionErrors MeasureAlignedPositions(const PosePairs& pairs, AlignmentModel model);

struct SegmentOptions {
  /// Segment lengths along the true path, metres. Empty: the KITTI devkit's 100, 200 .. 800 m, or a tenth of them (and
  /// a tenth again) on a drive of which the shortest is longer than the whole. Those which fit are used.
  std::vector<double> lengths;
  /// A segment starts at every so many poses; the devkit's 10.
  int start_every = 10;
};

/// Errors of all segments of one length.
struct SegmentLengthError {
  double length = 0;  ///< metres
  int segments = 0;
  double translation = 0;  ///< mean error of the segment's end, share of the length
  double rotation = 0;     ///< mean, rad/m
};

/// The KITTI odometry benchmark's errors (Geiger et al., CVPR 2012; devkit, evaluate_odometry.cpp): the mean over all
/// segments of all lengths.
struct SegmentErrors {
  int segments = 0;
  double translation = 0;                     ///< share of the length; times 100 is the devkit's per cent
  double rotation = 0;                        ///< rad/m
  std::vector<SegmentLengthError> by_length;  ///< the lengths that fit, shortest first
};

/// Every estimated translation is multiplied by `scale` first.
/// Throws InputError when no segment fits: the ground truth travels less than a metre or less than the least length
/// asked for.
SegmentErrors MeasureSegments(const PosePairs& pairs, double scale = 1, const SegmentOptions& options = {});

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

struct EvaluationOptions {
  SegmentOptions segments;
  StepErrorOptions steps;
};

/// The errors that depend on the scale, at one scale of the estimate.
struct ScaledErrors {
  double scale = 1;              ///< by which the estimate's translations were multiplied
  double path_length_error = 0;  ///< (estimated - true) / true
  SegmentErrors segments;
  StepErrors all_steps;
  StepErrors turning_steps;
};

/// Errors of an estimated trajectory against ground truth.
struct Evaluation {
  int poses = 0;                     ///< paired
  double true_path_length = 0;       ///< of all pairs, metres
  double estimated_path_length = 0;  ///< likewise, in the unit of the estimate
  ScaledErrors as_given;
  PositionErrors from_first_pose;
  /// The rest is empty where the positions determine no alignment; `alignment_problem` then says why.
  std::optional<PositionErrors> rigid;
  std::optional<PositionErrors> similarity;
  std::optional<ScaledErrors> rescaled;  ///< at the scale of the similarity
  std::string alignment_problem;
};

/// Computes all errors. Throws InputError when the path length of the ground truth is too short.
Evaluation Evaluate(const PosePairs& pairs, const std::vector<Step>& steps, const EvaluationOptions& options = {});

}  // namespace turnscale

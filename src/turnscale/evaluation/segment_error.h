// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "turnscale/evaluation/association.h"

namespace turnscale {

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

}  // namespace turnscale

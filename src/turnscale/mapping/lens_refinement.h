// SPDX-License-Identifier: MIT
#pragma once

#include <optional>

#include "turnscale/mapping/intrinsics_evidence.h"
#include "turnscale/mapping/map.h"

namespace turnscale {

struct LensRefinementOptions {
  /// Estimate the residual radial distortion of the calibration. A few thousandths of it (half a pixel each
  /// at the left and right edge of KITTI's images) bias the scale of monocular odometry by per cents in a turn, and
  /// KITTI's own calibration is off by 15 of them.
  bool enabled = true;
  /// Keyframes per window.
  int window = 12;
  /// Least angle by which the camera turns within a window, degrees. On a straight the noise of the points' depths
  /// looks like distortion.
  double min_turn_deg = 8.0;
  /// Prior standard deviation of the correction where the calibration is off (KITTI's: 0.016).
  double prior_sigma = 0.02;
  /// Prior probability that the calibration is accurate instead: most lenses need no correction, and the noise of a
  /// single turn should not make one. It is 0 for intrinsics with a standard deviation: these were estimated from a
  /// drive.
  double accurate_share = 0.5;
  /// Prior standard deviation of the correction of an accurate calibration: half a pixel at the edge of an image that
  /// is 1200 pixels and 80 degrees wide.
  double accurate_sigma = 0.001;
  /// Largest change of the correction between two linearisations of a window.
  double step = 0.01;
  /// Landmarks of a window that take part (IntrinsicsWindow); its time is linear in it.
  int max_landmarks = 300;
  /// Standard deviation of a tracked pixel, pixels.
  double pixel_sigma = kTrackedPixelSigma;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Estimates the radial correction (CorrectRadially) from the drive itself, window by window.
///
/// Each window of keyframes in which the camera turns gives a parabola of the cost in the correction, poses and points
/// marginalised out (IntrinsicsProblem), measured near its minimum. The parabolas add up to a Gaussian likelihood. The
/// estimate is the posterior mean, with a mixture of two Gaussians as the prior: the calibration is accurate, or off.
/// What the windows cannot tell from noise hardly changes the calibration; a significant correction is taken as it is.
/// Windows of noisy images scatter more than their parabolas say: their scatter widens sigma, so that less of them
/// counts as significant.
class LensRefinement {
 public:
  explicit LensRefinement(const LensRefinementOptions& options);

  /// A copy of the window that ends at the latest keyframe; nothing if none is due, or the camera turns too little in
  /// it. The next one is due some keyframes later. Call it when a keyframe has come.
  std::optional<IntrinsicsProblem> TakeWindow(const Map& map);
  /// Adds the window's parabola. False, and nothing changed, where it has none.
  bool Read(IntrinsicsProblem& window);

  double correction() const { return correction_; }
  double sigma() const { return sigma_; }  ///< standard deviation of the correction

 private:
  /// Correction and sigma from the sums.
  void Update();
  /// Mean square of the windows' deviations from their mean, in sigmas of each, from 1 to 4.
  double Scatter() const;

  LensRefinementOptions options_;
  double correction_ = 0;
  double sigma_ = 0;
  /// Curvature of the sum of all parabolas, each times the share of a window that counts; sums of their minima and of
  /// the squares of these, weighted likewise.
  double information_ = 0;
  double weighted_estimate_ = 0;
  double weighted_square_ = 0;
  int windows_ = 0;
  int next_keyframe_;  ///< the window ends there
};

}  // namespace turnscale

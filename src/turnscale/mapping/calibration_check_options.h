// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/mapping/map.h"

namespace turnscale {

/// Of the test of a calibration against the images of turns (CalibrationCheck).
struct CalibrationCheckOptions {
  /// Test the given intrinsics against the images of turns. A focal length that is 15 % off biases the scale
  /// by tens of per cent, and no other test detects it.
  bool enabled = true;
  /// Keyframes that each look takes in.
  int window = 20;
  /// Least angle between two of a window's keyframes, degrees. Without turning, a longer focal length is the same as a
  /// deeper scene.
  double min_turn_deg = 25.0;
  /// Landmarks that take part (IntrinsicsWindow); the time of a look is linear in it.
  int max_landmarks = 300;
  /// Times that poses, points and intrinsics are brought to agree in a window; with a right calibration one is enough.
  int max_rounds = 15;
  /// Windows after which no more are read: what is left of the errors then is what all windows have in common.
  int max_windows = 60;
  /// Errors of a track's pixels go together, so that each counts as if it were so many times its sigma.
  double pixel_sigma_inflation = 3.0;
  /// Where bundle adjustment starts to weigh residuals linearly, in sigmas.
  double huber_threshold = 2.0;
  /// Standard deviation of a tracked pixel until estimated from residuals, pixels.
  double pixel_sigma = kTrackedPixelSigma;

  // Priors, standard deviations.
  double focal_prior_sigma = 0.1;       ///< relative
  double centre_prior_sigma_deg = 2.0;  ///< principal point, as an angle at the camera, degrees
  double correction_prior_sigma = 0.3;  ///< radial correction: the whole distortion may be missing
  /// Its terms in r^4 and r^6; 0: not estimated. If they are not, their errors are mistaken for a focal
  /// length.
  double higher_prior_sigma = 0.1;
  /// Width of a pixel over its height, relative: anamorphic video without its tag. Counts as expected unless it is off
  /// by more than `min_aspect_error` and `significance`, as level turns do not determine it. 0: not estimated.
  double aspect_prior_sigma = 0.3;
  /// Seconds in which a rolling shutter reads the image. In turns it shears the image, which looks like another
  /// principal point. Counts as 0 unless it exceeds `min_readout` and `significance`.
  double readout_prior_sigma = 0.02;

  // What the images of one window get wrong beyond their noise (moving things, what the lens has besides a radial
  // distortion), standard deviations. Windows of KITTI scatter by as much.
  double focal_window_sigma = 0.01;       ///< relative
  double centre_window_sigma_deg = 0.25;  ///< degrees
  double correction_window_sigma = 0.004;

  // The same of what all windows of a drive get wrong alike.
  double focal_model_sigma = 0.007;     ///< relative
  double centre_model_sigma_deg = 0.2;  ///< degrees
  double correction_model_sigma = 0.003;
  double aspect_model_sigma = 0.02;   ///< relative; as recorded drives show that were squeezed
  double readout_model_sigma = 0.07;  ///< relative; as rendered drives show

  // A contradiction is reported from these errors on, when it also exceeds `significance` standard deviations.
  double min_focal_error = 0.03;      ///< relative
  double min_centre_error_deg = 0.8;  ///< degrees
  double min_correction_error = 0.01;
  double min_aspect_error = 0.05;  ///< relative
  double min_readout = 0.004;      ///< seconds
  double significance = 3.0;
  /// Least deviation that leaves the calibration in doubt, standard deviations: too little for a report, but what a
  /// wrong calibration may look like is not taken for something else.
  double doubt = 2.0;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

}  // namespace turnscale

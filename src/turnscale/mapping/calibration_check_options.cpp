// SPDX-License-Identifier: MIT
#include "turnscale/mapping/calibration_check_options.h"

#include "turnscale/base/check_part.h"

namespace turnscale {

void CalibrationCheckOptions::Check() const {
  Require(window >= 3, "window: has to be at least 3 keyframes");
  Require(min_turn_deg > 0, "min_turn_deg: has to be positive");
  Require(max_landmarks >= 20, "max_landmarks: has to be at least 20");
  Require(max_rounds >= 1, "max_rounds: has to be at least 1");
  Require(max_windows >= 1, "max_windows: has to be at least 1");
  Require(pixel_sigma_inflation >= 1, "pixel_sigma_inflation: has to be at least 1");
  Require(huber_threshold >= 0, "huber_threshold: must not be negative");
  Require(pixel_sigma > 0, "pixel_sigma: has to be positive");
  Require(focal_prior_sigma > 0, "focal_prior_sigma: has to be positive");
  Require(centre_prior_sigma_deg > 0, "centre_prior_sigma_deg: has to be positive");
  Require(correction_prior_sigma > 0, "correction_prior_sigma: has to be positive");
  Require(higher_prior_sigma >= 0, "higher_prior_sigma: must not be negative");
  Require(aspect_prior_sigma >= 0, "aspect_prior_sigma: must not be negative");
  Require(readout_prior_sigma > 0, "readout_prior_sigma: has to be positive");
  Require(focal_window_sigma >= 0, "focal_window_sigma: must not be negative");
  Require(centre_window_sigma_deg >= 0, "centre_window_sigma_deg: must not be negative");
  Require(correction_window_sigma >= 0, "correction_window_sigma: must not be negative");
  Require(focal_model_sigma >= 0, "focal_model_sigma: must not be negative");
  Require(centre_model_sigma_deg >= 0, "centre_model_sigma_deg: must not be negative");
  Require(correction_model_sigma >= 0, "correction_model_sigma: must not be negative");
  Require(aspect_model_sigma >= 0, "aspect_model_sigma: must not be negative");
  Require(readout_model_sigma >= 0, "readout_model_sigma: must not be negative");
  Require(min_focal_error >= 0, "min_focal_error: must not be negative");
  Require(min_centre_error_deg >= 0, "min_centre_error_deg: must not be negative");
  Require(min_correction_error >= 0, "min_correction_error: must not be negative");
  Require(min_aspect_error >= 0, "min_aspect_error: must not be negative");
  Require(min_readout >= 0, "min_readout: must not be negative");
  Require(significance > 0, "significance: has to be positive");
  Require(doubt > 0, "doubt: has to be positive");
}

}  // namespace turnscale

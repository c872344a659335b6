// SPDX-License-Identifier: MIT
#include "turnscale/odometry/options.h"

#include <cmath>
#include <string>

#include "turnscale/base/check_part.h"
#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"

namespace turnscale {

void VehicleOptions::Check() const {
  if (lever_arm && !(*lever_arm > 0 && *lever_arm <= kLongestLeverArm))
    throw InputError(
        "lever_arm: has to be the distance from the rear axle forward to the camera in metres, above 0 and up to " +
        NumberText(kLongestLeverArm));
  if (lever_arm_sigma && !(*lever_arm_sigma >= 0 && std::isfinite(*lever_arm_sigma)))
    throw InputError("lever_arm_sigma: has to be a number of metres, 0 or more");
  if (lever_arm && lever_arm_sigma && !(*lever_arm_sigma < *lever_arm))
    throw InputError("lever_arm_sigma: " + NumberText(*lever_arm_sigma) + " has to be below the lever arm, " +
                     NumberText(*lever_arm) + " m");
  if (camera_height && !(*camera_height > 0 && *camera_height <= kHighestCamera))
    throw InputError("camera_height: has to be the height of the camera above the road in metres, above 0 and up to " +
                     NumberText(kHighestCamera));
  if (camera_height_sigma && !(*camera_height_sigma >= 0 && *camera_height_sigma < camera_height.value_or(HUGE_VAL)))
    throw InputError("camera_height_sigma: has to be from 0 to below the height, metres");
  if (!(std::abs(height_correlation) < 1)) throw InputError("height_correlation: has to be between -1 and 1");
  if (lever_arm_slip_correlation == 0 && !(std::hypot(height_correlation, height_slip_correlation) < 1))
    throw InputError("height_slip_correlation: the sum of its square and that of height_correlation has to be below 1");
  if (!(std::abs(lever_arm_slip_correlation) < 1))
    throw InputError("lever_arm_slip_correlation: has to be between -1 and 1");
  if (!CanCorrelate(height_correlation, height_slip_correlation, lever_arm_slip_correlation))
    throw InputError(
        "lever_arm_slip_correlation: is not possible together with height_correlation and height_slip_correlation");
  if (!(side_slip >= 0 && side_slip < 1)) throw InputError("side_slip: has to be in 0...1 s^2/m");
  if (!(side_slip_sigma >= 0 && side_slip_sigma < 1)) throw InputError("side_slip_sigma: has to be in 0...1 s^2/m");
  if (!(yaw_sigma > 0 && yaw_sigma < 1)) throw InputError("yaw_sigma_deg: has to be above 0 and below 57.3");
  if (!(known_pitch_sigma > 0)) throw InputError("known_pitch_sigma_deg: has to be above 0");
  if (!(known_roll_sigma > 0)) throw InputError("known_roll_sigma_deg: has to be above 0");
  if (!(roll_height >= 0 && roll_height < 10)) throw InputError("roll_height: has to be from 0 to below 10 m");
  if (!(roll_height_sigma >= 0 && roll_height_sigma < 10))
    throw InputError("roll_height_sigma: has to be from 0 to below 10 m");
  if (!(std::abs(image_lag) < 10 && (image_lag == 0 || image_lag_sigma > 0)))
    throw InputError("image_lag: has to be below 10 s, and needs image_lag_sigma above 0");
  if (!(image_lag_sigma >= 0 && image_lag_sigma < 10))
    throw InputError("image_lag_sigma: has to be from 0 to below 10 s");
  if (!(std::abs(vehicle_from_camera.norm() - 1) < 1e-6)) throw InputError("vehicle_from_camera: has to be a rotation");
}

void KeyframeOptions::Check() const {
  if (!(min_rotation_deg > 0)) throw InputError("min_rotation_deg: has to be positive");
  if (!(min_parallax_deg > 0)) throw InputError("min_parallax_deg: has to be positive");
  if (!(min_tracked_share >= 0 && min_tracked_share <= 1)) throw InputError("min_tracked_share: has to be in 0...1");
  if (!(min_followed_share >= 0 && min_followed_share <= 1)) throw InputError("min_followed_share: has to be in 0...1");
  if (!(min_motion >= 0)) throw InputError("min_motion: must not be negative");
  if (!(max_growth > 1)) throw InputError("max_growth: has to be above 1");
  if (max_reference_age < 1) throw InputError("max_reference_age: has to be at least 1 keyframe");
}

void TrackingOptions::Check() const {
  if (min_inliers < 6) throw InputError("min_inliers: has to be at least 6");
  if (!(min_inlier_share >= 0 && min_inlier_share <= 1)) throw InputError("min_inlier_share: has to be in 0...1");
  if (memory_keyframes < 1) throw InputError("memory_keyframes: has to be at least 1");
  if (!(sampled_interval >= 0)) throw InputError("sampled_interval: must not be negative");
  if (!(max_lost_seconds >= 0)) throw InputError("max_lost_seconds: must not be negative");
  if (!(max_hidden_seconds >= 0)) throw InputError("max_hidden_seconds: must not be negative");
  if (!(depth_sigma > 0 && depth_sigma < 1)) throw InputError("depth_sigma: has to be between 0 and 1");
  if (min_lost_frames < 1) throw InputError("min_lost_frames: has to be at least 1");
}

void ScaleOptions::Check() const {
  CheckPart("scale.", estimator);
  CheckPart("scale.recovery.", recovery);
}

void OdometryOptions::Check() const {
  CheckPart("vehicle.", vehicle);
  CheckPart("corners.", corners);
  CheckPart("flow.", flow);
  CheckPart("alignment.", alignment);
  CheckPart("initialization.", initialization);
  CheckPart("pose.", pose);
  CheckPart("keyframes.", keyframes);
  CheckPart("landmarks.", landmarks);
  CheckPart("local_bundle.", local_bundle);
  CheckPart("turn_bundle.", turn_bundle);
  CheckPart("final_bundle.", final_bundle);
  CheckPart("lens.", lens);
  CheckPart("calibration_check.", calibration_check);
  CheckPart("tracking.", tracking);
  CheckPart("motion.", motion);
  CheckPart("repeats.", repeats);
  CheckPart("gap_rotation.", gap_rotation);
  CheckPart("static_regions.", static_regions);
  CheckPart("road.", road);
  CheckPart("steps.", steps);
  scale.Check();
}

OdometryOptions WithoutMetres(OdometryOptions options) {
  options.vehicle.lever_arm.reset();
  options.vehicle.camera_height.reset();
  return options;
}

}  // namespace turnscale

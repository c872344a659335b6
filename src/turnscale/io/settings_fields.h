// SPDX-License-Identifier: MIT
#pragma once

#include "turnscale/odometry/options.h"

namespace turnscale {

/// Shows a visitor every setting once, under the name it has in settings files; reading and writing both follow this
/// list, so neither can forget a field. The visitor offers Group(name, fields), Field(name, value) for numbers, whole
/// numbers, switches and optional numbers, Degrees(name_deg, radians), Choice(name, value, {{name, value}...}) and
/// Rotation(prefix, quaternion), which stands as <prefix>_yaw_deg, _pitch_deg and _roll_deg.
template <class Visitor>
void VisitSettings(Visitor& visitor, OdometryOptions& options) {
  visitor.Field("threads", options.threads);
  visitor.Group("vehicle", [&] {
    auto& o = options.vehicle;
    visitor.Field("lever_arm", o.lever_arm);
    visitor.Field("side_slip", o.side_slip);
    visitor.Field("side_slip_sigma", o.side_slip_sigma);
    visitor.Rotation("camera", o.vehicle_from_camera);
    visitor.Field("calibrate_camera", o.calibrate_camera);
  });
  visitor.Group("corners", [&] {
    auto& o = options.corners;
    visitor.Field("target", o.target);
    visitor.Field("fast_threshold", o.fast_threshold);
    visitor.Field("min_distance", o.min_distance);
    visitor.Field("border", o.border);
  });
  visitor.Group("flow", [&] {
    auto& o = options.flow;
    visitor.Field("window", o.window);
    visitor.Field("levels", o.levels);
    visitor.Field("max_return_error", o.max_return_error);
  });
  visitor.Group("alignment", [&] {
    auto& o = options.alignment;
    visitor.Field("half_size", o.half_size);
    visitor.Field("max_iterations", o.max_iterations);
    visitor.Field("tolerance", o.tolerance);
    visitor.Field("max_distance", o.max_distance);
    visitor.Field("min_correlation", o.min_correlation);
  });
  visitor.Group("initialization", [&] {
    auto& o = options.initialization;
    visitor.Field("min_motion", o.min_motion);
    visitor.Field("min_parallax", o.min_parallax);
    visitor.Field("max_epipolar_error", o.max_epipolar_error);
    visitor.Field("min_landmarks", o.min_landmarks);
    visitor.Field("min_inlier_share", o.min_inlier_share);
    visitor.Field("min_landmark_parallax_deg", o.min_landmark_parallax_deg);
    visitor.Field("initial_baseline", o.initial_baseline);
  });
  visitor.Group("pose", [&] {
    auto& o = options.pose;
    visitor.Field("inlier_threshold", o.inlier_threshold);
    visitor.Field("huber_threshold", o.huber_threshold);
    visitor.Field("max_iterations", o.max_iterations);
  });
  visitor.Group("keyframes", [&] {
    auto& o = options.keyframes;
    visitor.Field("min_rotation_deg", o.min_rotation_deg);
    visitor.Field("min_parallax_deg", o.min_parallax_deg);
    visitor.Field("min_tracked_share", o.min_tracked_share);
    visitor.Field("max_growth", o.max_growth);
  });
  visitor.Group("landmarks", [&] {
    auto& o = options.landmarks;
    visitor.Field("min_parallax_deg", o.min_parallax_deg);
    visitor.Field("max_reprojection_error", o.max_reprojection_error);
  });
  visitor.Group("local_bundle", [&] {
    auto& o = options.local_bundle;
    visitor.Field("window", o.window);
    visitor.Field("anchors", o.anchors);
    visitor.Field("pixel_sigma", o.pixel_sigma);
    visitor.Field("max_iterations", o.max_iterations);
  });
  visitor.Group("lens", [&] {
    auto& o = options.lens;
    visitor.Field("enabled", o.enabled);
    visitor.Field("window", o.window);
    visitor.Field("min_turn_deg", o.min_turn_deg);
    visitor.Field("prior_sigma", o.prior_sigma);
    visitor.Field("step", o.step);
    visitor.Field("pixel_sigma", o.pixel_sigma);
  });
  visitor.Group("tracking", [&] {
    auto& o = options.tracking;
    visitor.Field("min_inliers", o.min_inliers);
    visitor.Field("min_inlier_share", o.min_inlier_share);
    visitor.Field("max_lost_frames", o.max_lost_frames);
    visitor.Field("memory_keyframes", o.memory_keyframes);
  });
  visitor.Group("turns", [&] {
    auto& o = options.turns;
    visitor.Degrees("min_step_angle_deg", o.min_step_angle);
    visitor.Field("min_steps", o.min_steps);
    visitor.Degrees("min_region_angle_deg", o.min_region_angle);
    visitor.Field("max_weak_steps", o.max_weak_steps);
  });
  visitor.Group("pooled_scale", [&] {
    auto& o = options.pooled_scale;
    visitor.Choice("method", o.method,
                   {{"pooled_line", ScaleMethod::kPooledLine}, {"per_frame", ScaleMethod::kPerFrame}});
    visitor.Degrees("sigma_theta_deg", o.sigma_theta);
    visitor.Field("robust_threshold", o.robust_threshold);
    visitor.Field("min_inliers", o.min_inliers);
    visitor.Degrees("min_angle_deg", o.min_angle);
    visitor.Field("min_lever_share", o.min_lever_share);
    visitor.Field("max_relative_sigma", o.max_relative_sigma);
  });
  visitor.Group("scale", [&] {
    visitor.Field("smooth", options.scale.smooth);
    visitor.Field("drift_per_root_metre", options.scale.drift_per_root_metre);
    visitor.Field("gap_sigma", options.scale.gap_sigma);
    visitor.Field("max_sigma_ratio", options.scale.max_sigma_ratio);
    visitor.Group("recovery", [&] {
      auto& o = options.scale.recovery;
      visitor.Field("pixel_sigma", o.pixel_sigma);
      visitor.Field("pixel_sigma_inflation", o.pixel_sigma_inflation);
      visitor.Field("max_iterations", o.max_iterations);
      visitor.Field("huber_threshold", o.huber_threshold);
      visitor.Field("max_stretch", o.max_stretch);
    });
  });
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/run/settings.h"

#include <cmath>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "turnscale/base/check_part.h"
#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/config/yaml_map.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/yaml_fields.h"
#include "turnscale/run/vehicle_file.h"

namespace turnscale {
namespace {

template <class Visitor>
void VisitScaleSettings(Visitor& visitor, ScaleOptions& options) {
  visitor.Choice("method", options.method, kScaleMethods);
  visitor.Field("huber", options.estimator.huber);
  visitor.Field("max_sigma", options.estimator.max_sigma);
  visitor.Field("max_straight_steps", options.estimator.segments.max_straight_steps);
  visitor.Field("max_sigma_ratio", options.estimator.max_sigma_ratio);
  visitor.Field("max_height_deviation", options.estimator.max_height_deviation);
  visitor.Field("max_yaw_deviation", options.estimator.max_yaw_deviation);
  visitor.Field("max_turn_yaw_deviation", options.estimator.max_turn_yaw_deviation);
  visitor.Degrees("contradicted_yaw_sigma_deg", options.estimator.contradicted_yaw_sigma);
  visitor.Degrees("max_given_yaw_sigma_deg", options.estimator.max_given_yaw_sigma);
  visitor.Group("turns", [&] {
    auto& o = options.estimator.segments.turns;
    visitor.Degrees("min_step_angle_deg", o.min_step_angle);
    visitor.Field("min_steps", o.min_steps);
    visitor.Degrees("min_region_angle_deg", o.min_region_angle);
    visitor.Field("max_weak_steps", o.max_weak_steps);
  });
  visitor.Group("line", [&] {
    auto& o = options.estimator.evidence.line;
    visitor.Degrees("sigma_theta_deg", o.sigma_theta);
    visitor.Field("robust_threshold", o.robust_threshold);
    visitor.Field("min_inliers", o.min_inliers);
    visitor.Degrees("min_angle_deg", o.min_angle);
    visitor.Degrees("sigma_psi_deg", o.sigma_psi);
    visitor.Field("min_forward_share", o.min_forward_share);
  });
  visitor.Group("evidence", [&] {
    auto& o = options.estimator.evidence;
    visitor.Field("turn_sigma", o.turn_sigma);
    visitor.Field("slip_sigma", o.slip_sigma);
    visitor.Degrees("turn_direction_sigma_deg", o.turn_direction_sigma);
    visitor.Degrees("direction_in_turn_sigma_deg", o.direction_in_turn_sigma);
    visitor.Degrees("straight_direction_sigma_deg", o.straight_direction_sigma);
    visitor.Field("bend_sigma", o.bend_sigma);
    visitor.Field("min_lever_arm_ratio", o.min_lever_arm_ratio);
    visitor.Field("road_sigma", o.road.sigma);
    visitor.Field("road_correlation_length", o.road.correlation_length);
    visitor.Field("road_step_sigma", o.road.step_sigma);
    visitor.Field("road_min_steps", o.road.min_steps);
  });
  visitor.Group("drift", [&] {
    visitor.Field("per_100m", options.estimator.drift.per_100m);
    visitor.Field("per_90deg", options.estimator.drift.per_90deg);
    visitor.Field("unit_inflation", options.estimator.drift.unit_inflation);
  });
  visitor.Group("test", [&] {
    auto& o = options.estimator.test;
    visitor.Field("min_probability", o.min_probability);
    visitor.Field("max_prior_deviation", o.max_prior_deviation);
    visitor.Field("max_turn_deviation", o.max_turn_deviation);
    visitor.Field("min_disagreement", o.min_disagreement);
  });
  visitor.Group("stabilisation", [&] {
    auto& o = options.estimator.stabilisation;
    visitor.Field("enabled", o.enabled);
    visitor.Field("min_lag_deviation", o.min_lag_deviation);
    visitor.Field("min_lag_deviation_with_less_scatter", o.min_lag_deviation_with_less_scatter);
    visitor.Field("min_reduction_significance", o.min_reduction_significance);
    visitor.Field("min_scale_change", o.min_scale_change);
    visitor.Field("lag_sigma", o.lag_sigma);
    visitor.Field("adopts_lag", o.adopts_lag);
    visitor.Field("min_lag_turns", o.min_lag_turns);
    visitor.Field("max_lag_sigma", o.max_lag_sigma);
    visitor.Field("min_smoothing", o.min_smoothing);
    visitor.Field("min_smoothing_deviation", o.min_smoothing_deviation);
  });
  visitor.Group("recovery", [&] {
    auto& o = options.recovery;
    visitor.Field("pixel_sigma", o.pixel_sigma);
    visitor.Field("max_iterations", o.max_iterations);
    visitor.Field("huber_threshold", o.huber_threshold);
    visitor.Field("max_stretch", o.max_stretch);
  });
}

/// Shows a visitor every setting once, under the name it has in settings files; reading, writing and hints for unknown
/// names all follow this list, so none can forget a field. The visitor offers Group(name, fields), Field(name, value)
/// for numbers, whole numbers, switches and optional numbers, Degrees(name_deg, radians), Choice(name, value, {{name,
/// value}...}) and Rotation(prefix, quaternion), which stands as <prefix>_yaw_deg, _pitch_deg and _roll_deg.
template <class Visitor>
void VisitSettings(Visitor& visitor, Settings& settings) {
  OdometryOptions& options = settings.odometry;
  visitor.Group("vehicle", [&] {
    auto& o = options.vehicle;
    visitor.Field("lever_arm", o.lever_arm);
    visitor.Field("lever_arm_sigma", o.lever_arm_sigma);
    visitor.Field("side_slip", o.side_slip);
    visitor.Field("side_slip_sigma", o.side_slip_sigma);
    visitor.Rotation("camera", o.vehicle_from_camera);
    visitor.Field("camera_known", o.camera_known);
    visitor.Field("calibrate_camera", o.calibrate_camera);
    visitor.Degrees("yaw_sigma_deg", o.yaw_sigma);
    visitor.Degrees("known_pitch_sigma_deg", o.known_pitch_sigma);
    visitor.Degrees("known_roll_sigma_deg", o.known_roll_sigma);
    visitor.Field("camera_height", o.camera_height);
    visitor.Field("camera_height_sigma", o.camera_height_sigma);
    visitor.Field("height_from_images", o.height_from_images);
    visitor.Field("height_correlation", o.height_correlation);
    visitor.Field("height_slip_correlation", o.height_slip_correlation);
    visitor.Field("lever_arm_slip_correlation", o.lever_arm_slip_correlation);
    visitor.Field("roll_height", o.roll_height);
    visitor.Field("roll_height_sigma", o.roll_height_sigma);
    visitor.Field("image_lag", o.image_lag);
    visitor.Field("image_lag_sigma", o.image_lag_sigma);
  });
  visitor.Group("images", [&] {
    visitor.Field("max_width", settings.images.max_width);
    visitor.Field("min_width", settings.images.min_width);
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
    visitor.Field("dark_window", o.dark_window);
    visitor.Field("levels", o.levels);
    visitor.Field("max_return_error", o.max_return_error);
    visitor.Field("min_brightness", o.min_brightness);
    visitor.Field("max_brightness_change", o.max_brightness_change);
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
    visitor.Field("min_parallax_deg", o.min_parallax_deg);
    visitor.Field("max_epipolar_error", o.max_epipolar_error);
    visitor.Field("min_landmarks", o.min_landmarks);
    visitor.Field("min_landmark_share", o.min_landmark_share);
    visitor.Field("fewest_landmarks", o.fewest_landmarks);
    visitor.Field("min_inlier_share", o.min_inlier_share);
    visitor.Field("min_cell_share", o.min_cell_share);
    visitor.Field("min_landmark_parallax_deg", o.min_landmark_parallax_deg);
    visitor.Field("initial_baseline", o.initial_baseline);
  });
  visitor.Group("pose", [&] {
    auto& o = options.pose;
    visitor.Field("inlier_threshold", o.inlier_threshold);
    visitor.Field("min_agreeing_share", o.min_agreeing_share);
    visitor.Field("max_cell_weight", o.max_cell_weight);
    visitor.Field("huber_threshold", o.huber_threshold);
    visitor.Field("max_iterations", o.max_iterations);
  });
  visitor.Group("keyframes", [&] {
    auto& o = options.keyframes;
    visitor.Field("min_rotation_deg", o.min_rotation_deg);
    visitor.Field("min_parallax_deg", o.min_parallax_deg);
    visitor.Field("min_tracked_share", o.min_tracked_share);
    visitor.Field("min_followed_share", o.min_followed_share);
    visitor.Field("min_motion", o.min_motion);
    visitor.Field("max_growth", o.max_growth);
    visitor.Field("max_reference_age", o.max_reference_age);
  });
  visitor.Group("landmarks", [&] {
    auto& o = options.landmarks;
    visitor.Field("min_parallax_deg", o.min_parallax_deg);
    visitor.Field("min_parallax", o.min_parallax);
    visitor.Field("max_reprojection_error", o.max_reprojection_error);
    visitor.Field("min_distance_share", o.min_distance_share);
  });
  for (const auto& [name, bundle] :
       {std::pair{"local_bundle", &options.local_bundle}, std::pair{"turn_bundle", &options.turn_bundle},
        std::pair{"final_bundle", &options.final_bundle}}) {
    visitor.Group(name, [&o = *bundle, &visitor] {
      visitor.Field("window", o.window);
      visitor.Field("anchors", o.anchors);
      visitor.Field("pixel_sigma", o.pixel_sigma);
      visitor.Field("max_iterations", o.max_iterations);
      visitor.Field("relative_cost_tolerance", o.relative_cost_tolerance);
      visitor.Field("initial_damping", o.initial_damping);
      visitor.Field("use_exact_hessian", o.use_exact_hessian);
    });
  }
  visitor.Group("lens", [&] {
    auto& o = options.lens;
    visitor.Field("enabled", o.enabled);
    visitor.Field("window", o.window);
    visitor.Field("min_turn_deg", o.min_turn_deg);
    visitor.Field("prior_sigma", o.prior_sigma);
    visitor.Field("accurate_share", o.accurate_share);
    visitor.Field("accurate_sigma", o.accurate_sigma);
    visitor.Field("step", o.step);
    visitor.Field("max_landmarks", o.max_landmarks);
    visitor.Field("pixel_sigma", o.pixel_sigma);
  });
  visitor.Group("calibration_check", [&] {
    auto& o = options.calibration_check;
    visitor.Field("enabled", o.enabled);
    visitor.Field("window", o.window);
    visitor.Field("min_turn_deg", o.min_turn_deg);
    visitor.Field("max_landmarks", o.max_landmarks);
    visitor.Field("max_rounds", o.max_rounds);
    visitor.Field("max_windows", o.max_windows);
    visitor.Field("pixel_sigma_inflation", o.pixel_sigma_inflation);
    visitor.Field("huber_threshold", o.huber_threshold);
    visitor.Field("pixel_sigma", o.pixel_sigma);
    visitor.Field("focal_prior_sigma", o.focal_prior_sigma);
    visitor.Field("centre_prior_sigma_deg", o.centre_prior_sigma_deg);
    visitor.Field("correction_prior_sigma", o.correction_prior_sigma);
    visitor.Field("higher_prior_sigma", o.higher_prior_sigma);
    visitor.Field("aspect_prior_sigma", o.aspect_prior_sigma);
    visitor.Field("readout_prior_sigma", o.readout_prior_sigma);
    visitor.Field("focal_window_sigma", o.focal_window_sigma);
    visitor.Field("centre_window_sigma_deg", o.centre_window_sigma_deg);
    visitor.Field("correction_window_sigma", o.correction_window_sigma);
    visitor.Field("focal_model_sigma", o.focal_model_sigma);
    visitor.Field("centre_model_sigma_deg", o.centre_model_sigma_deg);
    visitor.Field("correction_model_sigma", o.correction_model_sigma);
    visitor.Field("aspect_model_sigma", o.aspect_model_sigma);
    visitor.Field("readout_model_sigma", o.readout_model_sigma);
    visitor.Field("min_focal_error", o.min_focal_error);
    visitor.Field("min_centre_error_deg", o.min_centre_error_deg);
    visitor.Field("min_correction_error", o.min_correction_error);
    visitor.Field("min_aspect_error", o.min_aspect_error);
    visitor.Field("min_readout", o.min_readout);
    visitor.Field("significance", o.significance);
    visitor.Field("doubt", o.doubt);
  });
  visitor.Group("self_calibration", [&] {
    auto& o = settings.self_calibration;
    visitor.Field("windows", o.windows);
    visitor.Field("first_windows", o.first_windows);
    visitor.Field("first_min_turn_deg", o.first_min_turn_deg);
    visitor.Field("max_passes", o.max_passes);
    visitor.Field("min_interval", o.min_interval);
    visitor.Field("converged", o.converged);
    visitor.Field("converged_sigmas", o.converged_sigmas);
    visitor.Field("focal_prior_sigma", o.focal_prior_sigma);
    visitor.Field("correction_prior_sigma", o.correction_prior_sigma);
    visitor.Field("higher_prior_sigma", o.higher_prior_sigma);
  });
  visitor.Group("tracking", [&] {
    auto& o = options.tracking;
    visitor.Field("min_inliers", o.min_inliers);
    visitor.Field("min_inlier_share", o.min_inlier_share);
    visitor.Field("max_lost_seconds", o.max_lost_seconds);
    visitor.Field("max_hidden_seconds", o.max_hidden_seconds);
    visitor.Field("min_lost_frames", o.min_lost_frames);
    visitor.Field("depth_sigma", o.depth_sigma);
    visitor.Field("memory_keyframes", o.memory_keyframes);
    visitor.Field("sampled_interval", o.sampled_interval);
  });
  visitor.Group("steps", [&] {
    auto& o = options.steps;
    visitor.Degrees("angle_deg", o.angle);
    visitor.Field("max_duration", o.max_duration);
    visitor.Field("max_poses", o.max_poses);
    visitor.Field("max_pose_interval", o.max_pose_interval);
    visitor.Degrees("max_pose_turn_deg", o.max_pose_turn);
    visitor.Degrees("max_isolated_turn_deg", o.max_isolated_turn);
    visitor.Field("max_speed_ratio", o.max_speed_ratio);
    visitor.Degrees("max_direction_deg", o.max_direction);
  });
  visitor.Group("motion", [&] {
    auto& o = options.motion;
    visitor.Field("steady_seconds", o.steady_seconds);
    visitor.Field("turn_seconds", o.turn_seconds);
    visitor.Field("swing_seconds", o.swing_seconds);
    visitor.Field("travel_seconds", o.travel_seconds);
    visitor.Field("turn_acceleration", o.turn_acceleration);
    visitor.Field("speed_sigma", o.speed_sigma);
    visitor.Field("speed_sigma_per_second", o.speed_sigma_per_second);
    visitor.Field("acceleration_in_depths", o.acceleration_in_depths);
    visitor.Field("gap_turn_on_straights", o.gap_turn_on_straights);
    visitor.Field("gap_turn_in_turns", o.gap_turn_in_turns);
    visitor.Field("gap_corner", o.gap_corner);
    visitor.Field("gap_corner_speed", o.gap_corner_speed);
    visitor.Field("max_gap_turn", o.max_gap_turn);
    visitor.Field("max_gap_corner", o.max_gap_corner);
  });
  visitor.Group("gap_rotation", [&] {
    auto& o = options.gap_rotation;
    visitor.Field("max_keypoints", o.keypoints.max_keypoints);
    visitor.Field("min_contrast", o.keypoints.min_contrast);
    visitor.Field("max_width", o.keypoints.max_width);
    visitor.Field("max_distance_ratio", o.keypoints.max_distance_ratio);
    visitor.Field("max_epipolar_error", o.max_epipolar_error);
    visitor.Field("max_still_motion", o.max_still_motion);
    visitor.Field("min_matches", o.min_matches);
    visitor.Field("min_match_share", o.min_match_share);
    visitor.Field("min_still_share", o.min_still_share);
    visitor.Field("max_plane_share", o.max_plane_share);
    visitor.Field("max_tilt_deg", o.max_tilt_deg);
    visitor.Field("max_direction_error_deg", o.max_direction_error_deg);
  });
  visitor.Group("repeats", [&] {
    auto& o = options.repeats;
    visitor.Field("min_expected_motion", o.min_expected_motion);
    visitor.Field("max_motion_share", o.max_motion_share);
    visitor.Field("max_motion", o.max_motion);
    visitor.Field("max_interval", o.max_interval);
    visitor.Field("max_seconds", o.max_seconds);
  });
  visitor.Group("static_regions", [&] {
    auto& o = options.static_regions;
    visitor.Field("columns", o.columns);
    visitor.Field("max_motion", o.max_motion);
    visitor.Field("min_expected_motion", o.min_expected_motion);
    visitor.Field("min_evidence", o.min_evidence);
  });
  visitor.Group("road", [&] {
    auto& o = options.road;
    visitor.Field("enabled", o.enabled);
    visitor.Field("baseline", o.baseline);
    visitor.Field("min_baseline", o.min_baseline);
    visitor.Degrees("max_turn_deg", o.max_turn);
    visitor.Degrees("pitch_sigma_deg", o.plane.pitch_sigma);
    visitor.Degrees("roll_sigma_deg", o.plane.roll_sigma);
    visitor.Field("max_deviation", o.plane.max_deviation);
    visitor.Field("vertical_curvature_sigma", o.plane.vertical_curvature_sigma);
    visitor.Field("unevenness", o.plane.unevenness);
    visitor.Field("min_correlation", o.plane.min_correlation);
    visitor.Field("min_patches", o.plane.min_patches);
    visitor.Field("min_share", o.plane.min_share);
    visitor.Field("max_sigma", o.plane.max_sigma);
    visitor.Field("half_width", o.plane.patches.half_width);
    visitor.Field("nearest", o.plane.patches.nearest);
    visitor.Field("farthest", o.plane.patches.farthest);
    visitor.Field("rows", o.plane.patches.rows);
    visitor.Field("columns", o.plane.patches.columns);
    visitor.Field("half_size", o.plane.patches.half_size);
    visitor.Field("least_contrast", o.plane.patches.least_contrast);
    visitor.Field("image_noise", o.plane.patches.image_noise);
    visitor.Field("least_pixel_sigma", o.plane.patches.least_pixel_sigma);
  });
  visitor.Group("scale", [&] { VisitScaleSettings(visitor, options.scale); });
}

// The three angles of "yaw,pitch,roll"; nothing where the text is no such list.
std::optional<YawPitchRoll> ParseAngles(const std::string& text) {
  const std::optional<std::vector<double>> degrees = ParseNumbers(text);
  if (!degrees || degrees->size() != 3) return std::nullopt;
  const auto radians = [&](size_t i) { return (*degrees)[i] / kDegreesPerRadian; };
  return YawPitchRoll{radians(0), radians(1), radians(2)};
}

}  // namespace

std::vector<std::string> ScaleMethodNames() {
  std::vector<std::string> names;
  for (const auto& [name, method] : kScaleMethods) names.emplace_back(name);
  return names;
}

std::string ScaleMethodName(ScaleMethod method) {
  for (const auto& [name, other] : kScaleMethods)
    if (other == method) return name;
  return "";
}

std::optional<ScaleMethod> FindScaleMethod(std::string_view name) {
  for (const auto& [known, method] : kScaleMethods)
    if (name == known) return method;
  return std::nullopt;
}

void Settings::Check() const {
  odometry.Check();
  CheckPart("images.", images);
  CheckPart("self_calibration.", self_calibration);
}

std::string SettingsText(const Settings& settings) {
  FieldWriter writer;
  Settings shown = settings;
  VisitSettings(writer, shown);
  return writer.text;
}

Settings ReadSettings(const std::filesystem::path& path) {
  const YamlMap file(path);
  RefuseCameraFile(file, "a file of settings here, such as settings.yaml");
  // A car.yaml without a rotation has these two.
  if (file.Has("yaw_deg") || (file.Has("side_slip") && file.Has("side_slip_sigma")))
    throw InputError(path.string() +
                     ": is the file of a car, which --vehicle takes; give --settings a file of settings, such as "
                     "settings.yaml");
  Settings settings;
  FieldNames known;
  VisitSettings(known, settings);
  // Runs of earlier versions wrote it, and never used it.
  const std::vector<std::string> old = {"scale.recovery.pixel_sigma_inflation"};
  file.AllowOnlyNested(known.names, old);
  FieldReader reader(file);
  VisitSettings(reader, settings);
  file.CheckRead(settings);
  return settings;
}

Eigen::Quaterniond ReadCameraRotation(const std::string& angles_or_file) {
  std::optional<YawPitchRoll> angles = ParseAngles(angles_or_file);
  if (!angles) {
    std::error_code none;
    if (std::filesystem::status(angles_or_file, none).type() == std::filesystem::file_type::not_found) {
      throw InputError(
          fmt::format("--camera-rotation '{}': is not a file; give yaw,pitch,roll in degrees, or a YAML file with "
                      "yaw_deg, pitch_deg, roll_deg",
                      angles_or_file));
    }
    const YamlMap map{std::filesystem::path(angles_or_file)};
    RefuseCameraFile(map);
    RefuseSettingsFile(map);
    // Such files say more of the car than its rotation.
    map.AllowOnly(VehicleFileKeys());
    angles = YawPitchRoll{map.Angle("yaw_deg") / kDegreesPerRadian, map.Angle("pitch_deg") / kDegreesPerRadian,
                          map.Angle("roll_deg") / kDegreesPerRadian};
  }
  for (const double angle : {angles->yaw, angles->pitch, angles->roll}) {
    if (!(std::abs(angle) * kDegreesPerRadian <= 180)) {
      throw InputError(
          fmt::format("--camera-rotation '{}': angles must be between -180 and 180 degrees", angles_or_file));
    }
  }
  return RotationFromYawPitchRoll(*angles);
}

}  // namespace turnscale

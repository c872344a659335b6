// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "turnscale/camera/camera_model.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/calibration_check.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {

/// A drive without a turn.
inline const std::vector<DriveSegment> kStreet = {{60, 0.8, 0}};

/// Looks down on the road: about a vertical axis in the image, a scene of another height turns alike.
inline const Eigen::Quaterniond kPitched = RotationFromYawPitchRoll({0, -0.2, 0.05});

/// A drive read with a calibration that is off by `error`: to be right, the pinhole has to change by minus that, and
/// pixels want error[kCorrection] as correction.
inline Map WrongMap(const std::vector<DriveSegment>& segments, const IntrinsicsChange::Vector& error, double noise,
                    unsigned seed, const Eigen::Quaterniond& vehicle_from_camera = Eigen::Quaterniond::Identity(),
                    bool reads_columns = false) {
  const CarDrive drive = MakeCarDrive(segments, 0.1, {1.2, 0}, vehicle_from_camera);
  Map map = MakeMap(drive, {.points_per_step = 25,
                            .pixel_noise = noise,
                            .seed = seed,
                            .readout = -error[IntrinsicsChange::kReadout],
                            .reads_columns = reads_columns});
  const Pinhole truth = map.camera.pinhole;
  map.camera.pinhole = ChangedPinhole(truth, error);
  const auto seen_through_lens = [&](const Eigen::Vector2d& pixel) {
    return UndoRadialCorrection(truth, error[IntrinsicsChange::kCorrection], pixel);
  };
  for (Keyframe& keyframe : map.keyframes)
    for (KeyframeObservation& seen : keyframe.observations) seen.pixel = seen_through_lens(seen.pixel);
  for (Landmark& landmark : map.landmarks)
    for (LandmarkObservation& seen : landmark.observations) seen.pixel = seen_through_lens(seen.pixel);
  return map;
}

/// Pixels of a calibration that takes them for square.
inline Map SqueezedMap(double aspect, unsigned seed, const Eigen::Quaterniond& vehicle_from_camera = kPitched) {
  IntrinsicsChange::Vector error = IntrinsicsChange::Vector::Zero();
  error[IntrinsicsChange::kLogAspect] = -std::log(aspect);
  return WrongMap(kRightAndLeft, error, 0.3, seed, vehicle_from_camera);
}

/// The camera of these maps with the correction that is applied.
inline CameraModel WithCorrection(double correction = 0) {
  CameraModel camera;
  camera.pinhole = kTestPinhole;
  camera.radial_correction = correction;
  return camera;
}

/// The estimate of one parameter; of sigma 0 where there is none.
inline ParameterEstimate Of(IntrinsicsParameter parameter, const std::vector<ParameterEstimate>& estimates) {
  const auto found = std::ranges::find(estimates, parameter, &ParameterEstimate::parameter);
  return found == estimates.end() ? ParameterEstimate() : *found;
}
inline ParameterEstimate Of(IntrinsicsParameter parameter, const CalibrationCheck& check) {
  return Of(parameter, check.Parameters(WithCorrection()));
}

/// A window of keyframes from `first` on.
inline IntrinsicsProblem WindowFrom(int first, const Map& map, const CalibrationCheckOptions& options = {}) {
  IntrinsicsWindow window;
  window.first = first;
  window.last = first + options.window - 1;
  window.max_landmarks = options.max_landmarks;
  window.huber_threshold = options.huber_threshold;
  return {map, map.camera, window, options.pixel_sigma};
}

/// What a test shows that has seen the keyframes of a map one after another.
inline CalibrationCheck CheckAlong(const Map& whole, const CalibrationCheckOptions& options = {},
                                   const IntrinsicsChange::Vector& expected = IntrinsicsChange::Vector::Zero(),
                                   const std::optional<GivenReadout>& readout = std::nullopt) {
  CalibrationCheck check(options, whole.camera.pinhole, expected, readout);
  for (int keyframes = 1; keyframes <= CountKeyframes(whole); ++keyframes) check.Observe(MapUpTo(keyframes, whole));
  return check;
}

}  // namespace turnscale

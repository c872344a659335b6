// SPDX-License-Identifier: MIT
#include "turnscale/odometry/self_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "turnscale/base/check_part.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/mapping/calibration_check.h"
#include "turnscale/mapping/shutter_readout.h"
#include "turnscale/odometry/calibration_pass.h"
#include "turnscale/odometry/odometry.h"

namespace turnscale {
namespace {

// Where the first camera leads to no estimate: odometry fails where its focal length is too far off.
constexpr std::array<double, 2> kOtherViews = {100.0, 50.0};
// Share of the frames: failure has another cause.
constexpr double kTracksWell = 0.9;
// Before the first window, for a map to build up.
constexpr double kLeadSeconds = 3.0;
// After the last window: with another lens, windows begin at other keyframes.
constexpr double kTrailSeconds = 10.0;
// A focal length may have to change by a factor of two, in steps of a tenth.
constexpr int kMaxRounds = 15;
// Of a window: nearly all, so that it does not matter much which ones they are.
constexpr int kMaxLandmarks = 600;

// Result of one pass over the images.
struct Reading {
  PassFindings findings;
  double begin = 0;          ///< time of the first image, seconds
  double first_time = 0;     ///< of the first window, seconds
  double last_time = 0;      ///< end of the last window, seconds
  bool is_complete = false;  ///< it has as many windows as are read at most, and ended with the last one
  int frames = 0;
  int tracked = 0;
};

OdometryOptions OptionsForReading(const OdometryOptions& given, int pass) {
  OdometryOptions options = WithoutMetres(given);
  options.road.enabled = false;
  options.calibration_check.enabled = false;
  // The camera is not known yet.
  options.lens.accurate_share = 0;
  options.pose.inlier_threshold *= LooseBy(pass);
  options.pose.huber_threshold *= LooseBy(pass);
  options.landmarks.max_reprojection_error *= LooseBy(pass);
  return options;
}

CalibrationCheckOptions CheckForReading(const SelfCalibrationOptions& options, CalibrationCheckOptions check,
                                        int pass) {
  check.enabled = true;
  check.focal_prior_sigma = options.focal_prior_sigma;
  check.correction_prior_sigma = options.correction_prior_sigma;
  check.higher_prior_sigma = options.higher_prior_sigma;
  check.max_rounds = kMaxRounds;
  check.max_landmarks = kMaxLandmarks;
  check.max_windows = pass == 0 ? options.first_windows : options.windows;
  if (pass > 0) return check;
  check.min_turn_deg = options.first_min_turn_deg;
  // It would stand for what else is wrong.
  check.aspect_prior_sigma = 0;
  return check;
}

// Runs the odometry with `camera` until `check` has read its windows, or up to the time `end` of an image. Images that
// come sooner than `min_interval` after the one before are skipped. Both in seconds.
Reading ReadTurns(const OdometryOptions& options, const CameraModel& camera, CalibrationCheck check,
                  const ImageStream& next, double min_interval, double end, const cv::Mat& mask) {
  Odometry odometry(options, camera);
  if (!mask.empty()) odometry.SetMask(mask);
  Reading reading;
  size_t keyframes = 0;
  double latest = -HUGE_VAL;
  while (const std::optional<TimedImage> image = next()) {
    if (image->time > end) break;
    if (image->gray.empty() || image->time - latest < min_interval) continue;
    latest = image->time;
    const FrameResult result = odometry.Process(image->gray, image->time);
    if (reading.frames++ == 0) reading.begin = image->time;
    reading.tracked += result.state == TrackingState::kTracked ? 1 : 0;
    const Map& map = odometry.map();
    if (std::exchange(keyframes, map.keyframes.size()) == map.keyframes.size()) continue;
    if (!check.Observe(map)) continue;
    if (check.windows() == 1)
      reading.first_time = map.keyframes[std::max<size_t>(keyframes, options.calibration_check.window) -
                                         options.calibration_check.window]
                               .time;
    reading.last_time = map.keyframes.back().time;
    reading.is_complete = check.IsComplete();
    if (reading.is_complete) break;
  }
  reading.findings = {check.Estimate(), check.observed_radius(), check.windows(), check.LatestReadout()};
  return reading;
}

// The passes over a drive. Each estimates a change of the previous pass's camera, since the series is close to any lens
// only where the change is small. The prior of the pinhole stays at the start; that of the distortion is no change, and
// keeps what the windows do not determine.
class SelfCalibration {
 public:
  SelfCalibration(const SelfCalibrationOptions& options, const OdometryOptions& odometry, const OpenDrive& open,
                  const cv::Mat& mask)
      : options_(options), odometry_(odometry), open_(open), mask_(mask) {}

  std::optional<FoundCamera> Run(const StartCamera& start) {
    if (!ReadFirst(start)) return std::nullopt;
    std::optional<FoundCamera> found;
    for (int passes = 1;; ++passes) {
      const std::optional<CameraOfPasses> result = CameraFrom(options_, camera_, reading_.findings, passes);
      if (!result) return found;
      if (result->is_last) return result->found;
      camera_ = result->next;
      // With the better camera no part of the drive turns enough to rely on.
      if (!ReadAgain(passes)) return passes > 1 ? std::optional(result->found) : std::nullopt;
      found = result->found;
    }
  }

 private:
  // The first pass, with the camera to start with or, where odometry fails with an assumed one, another field of view.
  // False where no window turns enough.
  bool ReadFirst(const StartCamera& start) {
    StartWith(start.camera);
    for (const double view : kOtherViews) {
      if (reading_.findings.windows > 0 || !start.assumed || reading_.tracked > kTracksWell * reading_.frames) break;
      CameraModel other = CameraOfLongerView(view, start.camera.width, start.camera.height,
                                             start.camera.pinhole.fy / start.camera.pinhole.fx);
      other.read_direction = start.camera.read_direction;
      StartWith(other);
    }
    begin_ = reading_.begin;
    return reading_.findings.windows > 0;
  }

  void StartWith(const CameraModel& camera) {
    camera_ = camera;
    expected_ = camera.pinhole;
    reading_ = Read(0);
  }

  // Another pass after so many. False, and the reading stays, where it has no windows.
  bool ReadAgain(int passes) {
    // With the camera as assumed, an earlier turn may have gone unnoticed.
    const auto from =
        passes == 1 ? std::nullopt : std::optional(std::max(0.0, reading_.first_time - begin_ - kLeadSeconds));
    Reading again = Read(passes, from);
    if (again.findings.windows == 0) return false;
    // A pass that has read the drive to its end has found all windows.
    if (passes == 1 && !again.is_complete) end_ = again.last_time + kTrailSeconds;
    reading_ = again;
    return true;
  }

  Reading Read(int pass, std::optional<double> from = std::nullopt) const {
    const CalibrationCheck check(CheckForReading(options_, odometry_.calibration_check, pass), camera_.pinhole,
                                 ChangeBetween(camera_.pinhole, expected_), ReadoutOf(camera_));
    return ReadTurns(OptionsForReading(odometry_, pass), camera_, check, open_(from), options_.min_interval, end_,
                     mask_);
  }

  const SelfCalibrationOptions& options_;
  const OdometryOptions& odometry_;
  const OpenDrive& open_;
  const cv::Mat& mask_;
  CameraModel camera_;     // of the last pass, then of the next one
  Pinhole expected_;       // mean of the prior
  Reading reading_;        // of the last pass
  double begin_ = 0;       // of the drive, time of an image
  double end_ = HUGE_VAL;  // of what the passes read, time of an image
};

}  // namespace

void SelfCalibrationOptions::Check() const {
  Require(windows >= 1, "windows: has to be at least 1");
  Require(first_windows >= 1, "first_windows: has to be at least 1");
  Require(first_min_turn_deg > 0, "first_min_turn_deg: has to be positive");
  Require(max_passes >= 1, "max_passes: has to be at least 1");
  Require(min_interval >= 0, "min_interval: must not be negative");
  Require(converged > 0, "converged: has to be positive");
  Require(converged_sigmas >= 0, "converged_sigmas: must not be negative");
  Require(focal_prior_sigma > 0, "focal_prior_sigma: has to be positive");
  Require(correction_prior_sigma > 0, "correction_prior_sigma: has to be positive");
  Require(higher_prior_sigma >= 0, "higher_prior_sigma: must not be negative");
}

std::optional<FoundCamera> CalibrateFromDrive(const SelfCalibrationOptions& options, const OdometryOptions& odometry,
                                              const StartCamera& start, const OpenDrive& open, const cv::Mat& mask) {
  options.Check();
  odometry.Check();
  return SelfCalibration(options, odometry, open, mask).Run(start);
}

int MostPasses(const SelfCalibrationOptions& options, bool assumed) {
  return options.max_passes + (assumed ? static_cast<int>(kOtherViews.size()) : 0);
}

CameraModel CameraOfLongerView(double field_of_view_deg, int width, int height, double pixel_aspect) {
  // In widths of a pixel.
  const double upright = height / pixel_aspect;
  if (upright <= width) return CameraOfView(field_of_view_deg, width, height, pixel_aspect);
  const double tangent = std::tan(0.5 * field_of_view_deg / kDegreesPerRadian);
  return CameraOfView(2 * kDegreesPerRadian * std::atan(tangent * width / upright), width, height, pixel_aspect);
}

CameraModel CameraOfView(double field_of_view_deg, int width, int height, double pixel_aspect) {
  const double focal = 0.5 * width / std::tan(0.5 * field_of_view_deg / kDegreesPerRadian);
  return {{focal, pixel_aspect * focal, 0.5 * (width - 1), 0.5 * (height - 1)},
          LensModel::kPinhole,
          {0, 0, 0, 0, 0},
          width,
          height};
}

}  // namespace turnscale

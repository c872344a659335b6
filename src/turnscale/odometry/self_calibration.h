// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <optional>

#include <opencv2/core/mat.hpp>

#include "turnscale/camera/camera_model.h"
#include "turnscale/odometry/options.h"

namespace turnscale {

/// An image of a drive and when it was taken, seconds.
struct TimedImage {
  cv::Mat gray;  ///< 8 bit; empty where the image is unusable
  double time = 0;
};

/// Estimation of the intrinsics from the images of a drive.
struct SelfCalibrationOptions {
  /// Windows of keyframes in turns that decide (CalibrationCheckOptions); the first ones of the drive.
  int windows = 6;
  /// Windows of the first reading, which need not be accurate.
  int first_windows = 3;
  /// Least turn in a window of the first reading, degrees. Small: with a focal length that is much too long, rotations
  /// come out too small.
  double first_min_turn_deg = 10.0;
  /// Most times that the images are read. The first three have wider thresholds and are not the last, unless this is
  /// reached.
  int max_passes = 6;
  /// Images that come sooner after the one before, seconds, are skipped: they add little information on the camera.
  double min_interval = 0.045;
  /// The camera is found when a pass changes no ray, as far as the windows show the lens, by more than this (on the
  /// plane z = 1). Half of the last change is applied.
  double converged = 0.003;
  /// It is also found when a pass changes focal length and principal point by fewer standard deviations than this.
  double converged_sigmas = 0.5;

  // Priors, standard deviations.
  double focal_prior_sigma = 0.5;       ///< relative
  double correction_prior_sigma = 0.3;  ///< radial correction, r^2
  double higher_prior_sigma = 0.1;      ///< radial correction, r^4 and r^6

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Yields the images of a drive in order; nothing at the end.
using ImageStream = std::function<std::optional<TimedImage>()>;

/// Opens the drive at its first image, or at the first one from a time on, seconds after the first image. Its images
/// have the same times either way.
using OpenDrive = std::function<ImageStream(std::optional<double> from)>;

/// Where the search for the camera begins.
struct StartCamera {
  CameraModel camera;
  bool assumed = true;  ///< else the calibration of the camera, if perhaps a wrong one
};

/// A camera estimated from a drive.
struct FoundCamera {
  CameraModel camera;       ///< with the standard deviation of its focal length
  double centre_sigma = 0;  ///< standard deviation of the principal point, pixels
  int windows = 0;          ///< windows in turns that decided
  /// The last pass changed no ray by much, or focal length and principal point by less than two standard deviations.
  bool converged = false;
};

/// Estimates focal length, principal point and radial distortion from the first turns of a drive.
///
/// The odometry runs over the images with the camera as assumed; windows of keyframes in turns show how it differs
/// from the true one (CalibrationCheck); the images are read again with the new camera, at least four times, until it
/// changes little. The first two passes with a starting camera read the drive from its beginning, and where it has few
/// windows to its end; later ones only the part that has windows. Where the windows show nothing of the lens, towards
/// the corners, its model extrapolates (FitLens). `start` needs image size and focal length only: half or twice the
/// true one is near enough; where it is assumed rather than given, other fields of view are tried if the odometry fails
/// with it. Both focal lengths are changed by the same factor, unless the images contradict the pixels' aspect. Pixels
/// that are 0 in `mask` (8 bit, of the images' size) are left out, unless it is empty. Nothing where no window turns
/// enough: the focal length does not matter to the images of a straight.
std::optional<FoundCamera> CalibrateFromDrive(const SelfCalibrationOptions& options, const OdometryOptions& odometry,
                                              const StartCamera& start, const OpenDrive& open,
                                              const cv::Mat& mask = {});

/// How often CalibrateFromDrive opens the drive at most.
int MostPasses(const SelfCalibrationOptions& options, bool assumed);

/// A camera of this image size (pixels) and horizontal field of view (degrees), without distortion. `pixel_aspect`:
/// width of a pixel over its height.
CameraModel CameraOfView(double field_of_view_deg, int width, int height, double pixel_aspect = 1);

/// The same with the field of view along the longer side of the image, as of an upright video from a phone.
CameraModel CameraOfLongerView(double field_of_view_deg, int width, int height, double pixel_aspect = 1);

}  // namespace turnscale

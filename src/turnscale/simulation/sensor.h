// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

#include <opencv2/core.hpp>

#include "turnscale/camera/camera_model.h"

namespace turnscale {

/// Fills the values with independent normal numbers of mean 0 and standard deviation 1 (no larger than 4.33). They
/// depend on the key and their place alone.
void FillNormalNoise(std::uint64_t key, std::span<float> values);

/// An industrial camera's sensor, from the light on it to gray levels 0...255. Noise stands in the levels before the
/// response.
struct SensorOptions {
  double target_gray = 100;          ///< mean gray level that automatic exposure keeps
  double exposure_lag = 0.4;         ///< seconds in which it makes up for two thirds of a change of the light
  double min_gain = 0.25;            ///< full scale over the brightness of white in full light, at least
  double max_gain = 16;              ///< likewise at most
  double flicker = 0;                ///< share by which lamps wax and wane
  double flicker_hz = 1.7;           ///< as seen at the camera's rate, 1/s
  double exposure_step = 0;          ///< share by which the exposure jumps up or down
  double exposure_step_seconds = 2;  ///< between two jumps
  double vignetting = 0.4;           ///< 0 none, 1 the fourth power of the cosine of the angle to the axis
  double blur = 0;                   ///< defocus, standard deviation in pixels
  double shot_noise = 1.8;           ///< standard deviation at level 128, gray levels; grows with the root of the level
  double read_noise = 0.8;           ///< standard deviation everywhere, gray levels
  double response = 0.7;             ///< gray is the level to this power; 1 is linear, 0.45 what screens expect
  double exposure_ms = 0;            ///< each row gathers light for this long; 0 freezes the motion
  double readout_ms = 0;             ///< from the first row to the last one; 0 is a global shutter

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// A sensor at work. Noise depends on the seed, the frame's number and the pixel alone, the exposure on the frames
/// before.
class Sensor {
 public:
  Sensor(const SensorOptions& options, const CameraModel& camera, double rate_hz, std::uint64_t seed);

  /// The 8-bit gray image of the next frame. `brightness`: CV_32F of the camera's size, linear, 1 for white in full
  /// light.
  cv::Mat Expose(const cv::Mat& brightness);

  /// The next frame has this number, from 0, not less than those so far; the frames before it are lost behind the
  /// sensor: its clock goes on, its exposure stays.
  void SkipTo(int frame) { frame_ = static_cast<std::uint64_t>(frame); }

  /// Full scale over brightness that the next frame is taken with, flicker and jumps apart.
  double gain() const { return gain_; }

 private:
  double FrameGain() const;
  void AdaptGain(const cv::Mat& light, double share);
  double MeanGray(const cv::Mat& light) const;

  SensorOptions options_;
  double interval_;
  std::uint64_t seed_;
  cv::Mat vignette_;  // CV_32F factors; empty where there is none
  cv::Mat response_;  // gray of each level, in fine steps
  std::uint64_t frame_ = 0;
  double gain_ = 1;
};

}  // namespace turnscale

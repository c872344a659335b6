// SPDX-License-Identifier: MIT
#include "turnscale/simulation/sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "turnscale/base/random.h"
#include "turnscale/io/range_check.h"

namespace turnscale {
namespace {

constexpr int kQuantiles = 1 << 16;

// The quantile in the middle of each of 2^16 equally likely parts: a 16-bit number becomes a normal one by a look-up.
std::vector<float> MakeQuantiles() {
  std::vector<float> quantiles(kQuantiles);
  double x = 0;
  for (int i = kQuantiles / 2; i < kQuantiles; ++i) {
    const double tail = 1 - (i + 0.5) / kQuantiles;
    // Newton from the neighbour's quantile; the tail is convex there, so that it is approached from below.
    for (int step = 0; step < 6; ++step) {
      const double excess = 0.5 * std::erfc(x / std::numbers::sqrt2) - tail;
      x += excess * std::sqrt(2 * std::numbers::pi) * std::exp(0.5 * x * x);
    }
    quantiles[static_cast<size_t>(i)] = static_cast<float>(x);
    quantiles[static_cast<size_t>(kQuantiles - 1 - i)] = static_cast<float>(-x);
  }
  return quantiles;
}

constexpr float kFullScale = 255;
constexpr float kMidGray = 128;
// Levels are looked up in steps so fine that the steepest response loses nothing.
constexpr int kStepsPerLevel = 64;
// Metering looks at every fourth pixel of every fourth row.
constexpr int kMeteringStep = 4;
constexpr int kSettlingRounds = 60;

double CosineToAxis(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  const std::optional<Eigen::Vector2d> ideal = camera.Undistort(pixel);
  return ideal ? 1 / camera.pinhole.Ray(*ideal).norm() : 0.0;
}

cv::Mat MakeVignette(const CameraModel& camera, double strength) {
  if (strength == 0) return {};
  cv::Mat vignette(camera.height, camera.width, CV_32F);
  for (int y = 0; y < vignette.rows; ++y) {
    for (int x = 0; x < vignette.cols; ++x) {
      const double squared = std::pow(CosineToAxis(camera, {x, y}), 2);
      vignette.at<float>(y, x) = static_cast<float>(1 + strength * (squared * squared - 1));
    }
  }
  return vignette;
}

cv::Mat MakeResponse(double exponent) {
  cv::Mat response(1, 255 * kStepsPerLevel + 1, CV_8U);
  for (int i = 0; i < response.cols; ++i) {
    const double share = static_cast<double>(i) / (response.cols - 1);
    response.at<uchar>(i) = static_cast<uchar>(std::lround(255 * std::pow(share, exponent)));
  }
  return response;
}

int StepOf(float level) {
  return static_cast<int>(std::clamp(level, 0.0F, kFullScale) * static_cast<float>(kStepsPerLevel));
}

}  // namespace

void FillNormalNoise(std::uint64_t key, std::span<float> values) {
  static const std::vector<float> quantiles = MakeQuantiles();
  const std::uint64_t start = Hash(key);
  std::uint64_t bits = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    // Four numbers to a hash.
    bits = i % 4 == 0 ? Hash(start + i) : bits >> 16U;
    values[i] = quantiles[bits & 0xFFFFU];
  }
}

void SensorOptions::Check() const {
  CheckRange("sensor.target_gray", target_gray, 1, 254);
  CheckRange("sensor.exposure_lag", exposure_lag, 0, 100);
  CheckRange("sensor.min_gain", min_gain, 1e-4, 1e4);
  CheckRange("sensor.max_gain", max_gain, min_gain, 1e4);
  CheckRange("sensor.flicker", flicker, 0, 0.9);
  CheckRange("sensor.flicker_hz", flicker_hz, 0, 1000);
  CheckRange("sensor.exposure_step", exposure_step, 0, 0.9);
  CheckRange("sensor.exposure_step_seconds", exposure_step_seconds, 1e-3, 1e6);
  CheckRange("sensor.vignetting", vignetting, 0, 1);
  CheckRange("sensor.blur", blur, 0, 20);
  CheckRange("sensor.shot_noise", shot_noise, 0, 100);
  CheckRange("sensor.read_noise", read_noise, 0, 100);
  CheckRange("sensor.response", response, 0.2, 2);
  CheckRange("sensor.exposure_ms", exposure_ms, 0, 1000);
  CheckRange("sensor.readout_ms", readout_ms, 0, 1000);
}

Sensor::Sensor(const SensorOptions& options, const CameraModel& camera, double rate_hz, std::uint64_t seed)
    : options_(options),
      interval_(1 / rate_hz),
      seed_(seed),
      vignette_(MakeVignette(camera, options.vignetting)),
      response_(MakeResponse(options.response)) {
  options_.Check();
}

cv::Mat Sensor::Expose(const cv::Mat& brightness) {
  cv::Mat light = vignette_.empty() ? brightness : brightness.mul(vignette_);
  if (options_.blur > 0) {
    // Into an image of its own: without vignetting `light` is the caller's.
    cv::Mat blurred;
    cv::GaussianBlur(light, blurred, {}, options_.blur, 0, cv::BORDER_REPLICATE);
    light = blurred;
  }
  if (frame_ == 0) {
    for (int round = 0; round < kSettlingRounds; ++round) AdaptGain(light, 1);
  }
  const auto gain = static_cast<float>(kFullScale * FrameGain());
  const auto read_variance = static_cast<float>(options_.read_noise * options_.read_noise);
  const auto shot_variance = static_cast<float>(options_.shot_noise * options_.shot_noise) / kMidGray;
  const uchar* const response = response_.ptr<uchar>();
  cv::Mat image(light.size(), CV_8U);
  std::vector<float> noise(static_cast<size_t>(light.cols));
  for (int y = 0; y < light.rows; ++y) {
    FillNormalNoise(Hash(seed_ ^ Hash(frame_)) + static_cast<std::uint64_t>(y), noise);
    const float* const row = light.ptr<float>(y);
    uchar* const gray = image.ptr<uchar>(y);
    for (int x = 0; x < light.cols; ++x) {
      const float level = gain * row[x];
      const float sigma = std::sqrt(read_variance + shot_variance * std::min(level, kFullScale));
      gray[x] = response[StepOf(level + sigma * noise[static_cast<size_t>(x)])];
    }
  }
  AdaptGain(light, options_.exposure_lag > 0 ? 1 - std::exp(-interval_ / options_.exposure_lag) : 1);
  ++frame_;
  return image;
}

double Sensor::FrameGain() const {
  const double time = static_cast<double>(frame_) * interval_;
  const double flicker = 1 + options_.flicker * std::sin(2 * std::numbers::pi * options_.flicker_hz * time);
  const auto jump = static_cast<std::uint64_t>(time / options_.exposure_step_seconds);
  const bool brighter = (Hash(seed_ ^ Hash(~jump)) & 1U) != 0;
  return gain_ * flicker * (brighter ? 1 + options_.exposure_step : 1 - options_.exposure_step);
}

// In powers, as a camera does: an image twice too bright takes as long as one twice too dark.
void Sensor::AdaptGain(const cv::Mat& light, double share) {
  const double wanted = options_.target_gray / std::max(MeanGray(light), 1.0);
  gain_ = std::clamp(gain_ * std::pow(wanted, share / options_.response), options_.min_gain, options_.max_gain);
}

double Sensor::MeanGray(const cv::Mat& light) const {
  const auto gain = static_cast<float>(kFullScale * gain_);
  const uchar* const response = response_.ptr<uchar>();
  std::int64_t sum = 0;
  std::int64_t count = 0;
  for (int y = 0; y < light.rows; y += kMeteringStep) {
    const float* const row = light.ptr<float>(y);
    for (int x = 0; x < light.cols; x += kMeteringStep, ++count) sum += response[StepOf(gain * row[x])];
  }
  return static_cast<double>(sum) / static_cast<double>(count);
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include <opencv2/core.hpp>

namespace turnscale {

/// What a camera behind a windscreen shows of its own car. All of it is fixed in the image.
struct WindscreenOptions {
  double dashboard = 0;   ///< share of the image's height, from below, that the dashboard covers in the middle
  double reflection = 0;  ///< brightness of the dashboard's reflection in the windscreen over that of the dashboard
  /// Standard deviation in pixels, at infinity's focus. A lens of 3 mm focal length and 1.5 mm aperture blurs a
  /// dashboard at 0.5 m to a disc of 9 micrometres: three pixels in diameter, a standard deviation of a quarter of it.
  double defocus = 0.8;

  /// Throws InputError that names the field when a value makes no sense.
  void Check() const;
};

/// Puts a dashboard (with vents, a seam and a sheet of paper on it) before the scene, and its reflection over it.
/// Depends on the seed and the image alone.
class Windscreen {
 public:
  Windscreen(const WindscreenOptions& options, const cv::Size& size, std::uint64_t seed);

  /// The scene (CV_32F, linear) as seen from inside of the car. The brighter the scene, the more light the dashboard
  /// has. Unchanged without dashboard.
  cv::Mat Through(const cv::Mat& scene) const;

  /// CV_8U: 255 where nothing of the scene is visible; empty without dashboard.
  const cv::Mat& covered() const { return covered_; }

 private:
  cv::Mat transmitted_;  // CV_32F, factor on the scene; empty without dashboard
  cv::Mat added_;        // CV_32F, dashboard and reflection in full light
  cv::Mat covered_;
};

}  // namespace turnscale

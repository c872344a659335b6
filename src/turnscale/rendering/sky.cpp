// SPDX-License-Identifier: MIT
#include "turnscale/rendering/sky.h"

#include <algorithm>

#include "turnscale/rendering/pattern.h"

namespace turnscale {
namespace {

// The clouds are a plane one unit above the eye, and their pattern repeats after so many units.
constexpr double kCloudSize = 6;

cv::Mat Clouds() {
  PatternOptions options;
  options.side = 512;
  options.seed = 77;
  options.mean = 1;
  options.contrast = 0.12F;
  return CloudPattern(options, 1.4);
}

}  // namespace

Sky::Sky(float overhead)
    : overhead_(overhead), clouds_(overhead > 0 ? Clouds() : cv::Mat(1, 1, CV_32F, 1.0F), kCloudSize) {}

float Sky::At(const Eigen::Vector3f& direction, float width) const {
  if (overhead_ <= 0) return 0;
  const float up = std::max(0.0F, -direction.y());
  const float low = 1 - up;
  const float brightness = overhead_ * (1 + 0.6F * low * low * low);
  // The plane is bent down at the horizon, where clouds would otherwise become infinitely thin.
  const float height = up + 0.15F;
  const Eigen::Vector2f at(direction.x() / height, direction.z() / height);
  const float minor = 0.5F * width / height;
  const Eigen::Vector2f major = at.normalized() * (minor / height);
  const float haze = std::min(1.0F, up / 0.3F);
  return brightness * (1 + haze * (clouds_.Sample(at, major, minor) - 1));
}

}  // namespace turnscale

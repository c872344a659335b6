// SPDX-License-Identifier: MIT
#include "turnscale/simulation/windscreen.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "turnscale/io/range_check.h"
#include "turnscale/rendering/pattern.h"

namespace turnscale {
namespace {

// Reflectances: dark plastic with a grain, so that the reflection is no brighter than it is in cars, and paper.
constexpr float kPlastic = 0.1F;
constexpr float kGrain = 0.03F;
constexpr double kPaper = 0.7;
// A scene reflects half of the light that falls on it and on the dashboard.
constexpr double kLightOverScene = 2;
// The reflection reaches this far up from the dashboard's edge, in dashboard heights.
constexpr double kReflectionReach = 2.2;
// Where the blurred dashboard lets less than this through, nobody sees the scene.
constexpr float kOpaque = 0.002F;
// The light on the dashboard is that of every so many-th pixel.
constexpr int kMeteringStride = 8;

// Row of the dashboard's edge by column: it falls to both sides, and rises over the instruments before the driver.
double EdgeAt(double column, const cv::Size& size, double height) {
  const double across = 2 * column / size.width - 1;
  const double instruments = std::exp(-std::pow((across + 0.55) / 0.17, 4));
  return size.height - height * (1 - 0.35 * across * across + 0.2 * instruments);
}

cv::Mat Mask(const cv::Size& size, double height) {
  std::vector<cv::Point> outline;
  for (int column = 0; column < size.width; ++column)
    outline.emplace_back(column, static_cast<int>(std::lround(EdgeAt(column, size, height))));
  outline.emplace_back(size.width - 1, size.height - 1);
  outline.emplace_back(0, size.height - 1);
  cv::Mat mask(size, CV_32F, cv::Scalar(0));
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{outline}, cv::Scalar(1));
  return mask;
}

// Points of the dashboard: `across` from -1 to 1 over the image, `down` from its upper edge in the middle, in its
// heights.
cv::Point On(const cv::Size& size, double height, double across, double down) {
  return {static_cast<int>(std::lround(0.5 * (across + 1) * size.width)),
          static_cast<int>(std::lround(size.height - height * (1 - down)))};
}

void DrawVent(double across, double down, const cv::Size& size, double height, cv::Mat& reflectance) {
  constexpr int kSlats = 4;
  for (int slat = 0; slat < kSlats; ++slat) {
    const double top = down + 0.09 * slat;
    cv::rectangle(reflectance, On(size, height, across - 0.07, top), On(size, height, across + 0.07, top + 0.04),
                  cv::Scalar(0.02), cv::FILLED);
  }
}

// Reflectance of the dashboard, CV_32F over the whole image.
cv::Mat Dashboard(const cv::Size& size, double height, std::uint64_t seed) {
  const auto side = static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::max({size.width, size.height, 16}))));
  const PatternOptions grain = {side, seed, kPlastic, kGrain};
  cv::Mat reflectance = CloudPattern(grain, 0.8)(cv::Rect({}, size)).clone();
  for (const double across : {-0.12, 0.12, 0.8}) DrawVent(across, 0.45, size, height, reflectance);
  const int seam = std::max(1, static_cast<int>(0.02 * height));
  cv::line(reflectance, On(size, height, -1, 0.75), On(size, height, 0.4, 0.3), cv::Scalar(0.03), seam);
  cv::line(reflectance, On(size, height, 0.4, 0.3), On(size, height, 1, 0.55), cv::Scalar(0.03), seam);
  const std::vector<cv::Point> paper = {On(size, height, 0.32, 0.62), On(size, height, 0.47, 0.55),
                                        On(size, height, 0.52, 0.85), On(size, height, 0.36, 0.92)};
  cv::fillConvexPoly(reflectance, paper, cv::Scalar(kPaper));
  return reflectance;
}

// The dashboard upside down above its edge, ever fainter.
cv::Mat Reflection(const cv::Mat& dashboard, double height) {
  cv::Mat reflection(dashboard.size(), CV_32F, cv::Scalar(0));
  const int edge = static_cast<int>(dashboard.rows - height);
  const int top = std::max(0, static_cast<int>(edge - kReflectionReach * height));
  cv::Mat mirrored;
  cv::flip(dashboard.rowRange(edge, dashboard.rows), mirrored, 0);
  // Down to the lower end of the image: the edge is not at the same height everywhere.
  cv::resize(mirrored, mirrored, {dashboard.cols, dashboard.rows - top});
  mirrored.copyTo(reflection.rowRange(top, dashboard.rows));
  for (int row = top; row < edge; ++row)
    reflection.row(row) *= std::sqrt(static_cast<double>(row - top) / (edge - top));
  return reflection;
}

void Defocus(double sigma, cv::Mat& image) {
  if (sigma > 0) cv::GaussianBlur(image, image, {}, sigma, 0, cv::BORDER_REPLICATE);
}

}  // namespace

void WindscreenOptions::Check() const {
  CheckRange("windscreen.dashboard", dashboard, 0, 0.6);
  CheckRange("windscreen.reflection", reflection, 0, 1);
  CheckRange("windscreen.defocus", defocus, 0, 50);
}

Windscreen::Windscreen(const WindscreenOptions& options, const cv::Size& size, std::uint64_t seed) {
  options.Check();
  const double height = options.dashboard * size.height;
  if (height < 1) return;
  cv::Mat mask = Mask(size, height);
  const cv::Mat dashboard = Dashboard(size, height, seed);
  // Blurred with the edge, as what the edge lets through is.
  added_ = mask.mul(dashboard) + options.reflection * (1 - mask).mul(Reflection(dashboard, height));
  Defocus(options.defocus, added_);
  Defocus(options.defocus, mask);
  // What is left of a blur far from the edge would still cost rays.
  cv::threshold(1 - mask, transmitted_, kOpaque, 0, cv::THRESH_TOZERO);
  covered_ = transmitted_ == 0;
}

cv::Mat Windscreen::Through(const cv::Mat& scene) const {
  if (transmitted_.empty()) return scene;
  double sum = 0;
  double count = 0;
  for (int row = 0; row < scene.rows; row += kMeteringStride) {
    const auto* brightness = scene.ptr<float>(row);
    const auto* transmitted = transmitted_.ptr<float>(row);
    for (int column = 0; column < scene.cols; column += kMeteringStride) {
      sum += transmitted[column] * brightness[column];
      count += transmitted[column];
    }
  }
  const double light = kLightOverScene * sum / std::max(count, 1.0);
  cv::Mat image;
  cv::multiply(scene, transmitted_, image);
  cv::scaleAdd(added_, light, image, image);
  return image;
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "street_world.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

namespace turnscale {
namespace {

constexpr int kTextureSize = 1024;  // texels; the texture repeats
constexpr double kTexel = 0.02;     // metres
constexpr float kSky = 215;         // gray
constexpr double kMostTaps = 4;     // along a surface seen at a grazing angle
constexpr unsigned kTextureSeed = 7;

// Random blotches of the given size that join up at the texture's borders.
cv::Mat Octave(int blotch, std::mt19937& random) {
  constexpr int kBorder = 2;
  const int cells = kTextureSize / blotch;
  cv::Mat grid(cells, cells, CV_32F);
  for (float& value : cv::Mat_<float>(grid))
    value = static_cast<float>(random()) / static_cast<float>(std::mt19937::max()) - 0.5F;
  cv::Mat padded;
  cv::copyMakeBorder(grid, padded, kBorder, kBorder, kBorder, kBorder, cv::BORDER_WRAP);
  cv::resize(padded, padded, {}, blotch, blotch, cv::INTER_CUBIC);
  return padded(cv::Rect(kBorder * blotch, kBorder * blotch, kTextureSize, kTextureSize)).clone();
}

std::vector<cv::Mat> MakeTexture() {
  std::mt19937 random(kTextureSeed);
  cv::Mat sum(kTextureSize, kTextureSize, CV_32F, cv::Scalar(0));
  for (int blotch = 4; blotch <= 128; blotch *= 2) sum += Octave(blotch, random);
  // The bent scale of gray turns blotches into patches with edges and corners.
  for (float& value : cv::Mat_<float>(sum)) value = 120 + 85 * std::tanh(2.5F * value);
  std::vector<cv::Mat> levels = {sum};
  while (levels.back().cols > 4) {
    cv::Mat half;
    cv::resize(levels.back(), half, {}, 0.5, 0.5, cv::INTER_AREA);
    levels.push_back(half);
  }
  return levels;
}

float Bilinear(const cv::Mat& level, float u, float v) {
  const int mask = level.cols - 1;
  const float u0 = std::floor(u);
  const float v0 = std::floor(v);
  const int x0 = static_cast<int>(u0) & mask;
  const int x1 = (x0 + 1) & mask;
  const float* row0 = level.ptr<float>(static_cast<int>(v0) & mask);
  const float* row1 = level.ptr<float>((static_cast<int>(v0) + 1) & mask);
  const float a = u - u0;
  const float b = v - v0;
  return (1 - b) * ((1 - a) * row0[x0] + a * row0[x1]) + b * ((1 - a) * row1[x0] + a * row1[x1]);
}

}  // namespace

std::vector<Eigen::Vector3d> PixelRays(const CameraModel& camera) {
  std::vector<Eigen::Vector3d> rays;
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) rays.push_back(camera.pinhole.Ray(camera.Undistort({x, y}).value()));
  return rays;
}

StreetWorld::StreetWorld(std::vector<Block> blocks) : blocks_(std::move(blocks)), texture_(MakeTexture()) {}

StreetWorld::Hit StreetWorld::Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray) const {
  Hit hit{std::numeric_limits<double>::infinity(), 0, 1};
  if (ray.y() > 0) hit.distance = -origin.y() / ray.y();
  const Eigen::Array3d inverse = ray.array().inverse();
  for (size_t i = 0; i < blocks_.size(); ++i) {
    const Eigen::Array3d a = (blocks_[i].low - origin).array() * inverse;
    const Eigen::Array3d b = (blocks_[i].high - origin).array() * inverse;
    int axis = 0;
    const double enter = a.min(b).maxCoeff(&axis);
    if (enter <= 0 || enter >= hit.distance || enter >= a.max(b).minCoeff()) continue;
    hit = {enter, static_cast<int>(6 * i) + 2 * axis + (ray[axis] > 0 ? 1 : 2), axis};
  }
  return hit;
}

float StreetWorld::Texel(float u, float v, float footprint) const {
  const float depth = std::clamp(std::log2(std::max(footprint, 1.0F)), 0.0F, static_cast<float>(texture_.size()) - 2);
  const int level = static_cast<int>(depth);
  const float scale = std::ldexp(1.0F, -level);
  // Texel centres lie at half-integers of the level above.
  const float fine = Bilinear(texture_[level], u * scale - 0.5F, v * scale - 0.5F);
  const float coarse = Bilinear(texture_[level + 1], 0.5F * u * scale - 0.5F, 0.5F * v * scale - 0.5F);
  const float share = depth - static_cast<float>(level);
  return (1 - share) * fine + share * coarse;
}

float StreetWorld::Gray(const Eigen::Vector3d& origin, const Eigen::Vector3d& ray, double pixel_angle) const {
  const Hit hit = Cast(origin, ray);
  if (!std::isfinite(hit.distance)) return kSky;
  const Eigen::Vector3d point = origin + hit.distance * ray;
  // Of two walls that meet, each has its own piece of texture.
  const Eigen::Vector2d place = (hit.axis == 1 ? Eigen::Vector2d(point.x(), point.z())
                                               : Eigen::Vector2d(hit.axis == 0 ? point.z() : point.x(), point.y())) /
                                    kTexel +
                                Eigen::Vector2d(137.0 * hit.surface, 311.0 * hit.surface);
  Eigen::Vector2d along = hit.axis == 1   ? Eigen::Vector2d(ray.x(), ray.z())
                          : hit.axis == 0 ? Eigen::Vector2d(ray.z(), ray.y())
                                          : Eigen::Vector2d(ray.x(), ray.y());
  const double across = pixel_angle * hit.distance * ray.norm() / kTexel;
  const double stretch = ray.norm() / std::max(1e-6, std::abs(ray[hit.axis]));
  const double taps = std::clamp(std::ceil(stretch), 1.0, kMostTaps);
  along *= across * stretch / (taps * std::max(1e-9, along.norm()));
  const float footprint = static_cast<float>(across * std::max(1.0, stretch / taps));
  float sum = 0;
  for (double tap = 0.5 * (1 - taps); tap < 0.5 * taps; ++tap) {
    const Eigen::Vector2d at = place + tap * along;
    sum += Texel(static_cast<float>(at.x()), static_cast<float>(at.y()), footprint);
  }
  return sum / static_cast<float>(taps);
}

cv::Mat StreetWorld::Render(const CameraModel& camera, const std::vector<Eigen::Vector3d>& rays,
                            const RigidTransform& world_from_camera) const {
  return Render(camera, rays, std::vector(camera.height, world_from_camera));
}

cv::Mat StreetWorld::Render(const CameraModel& camera, const std::vector<Eigen::Vector3d>& rays,
                            const std::vector<RigidTransform>& world_from_camera) const {
  cv::Mat image(camera.height, camera.width, CV_8UC1);
  cv::parallel_for_({0, image.rows}, [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y) {
      const Eigen::Matrix3d rotation = world_from_camera[y].rotation.toRotationMatrix();
      for (int x = 0; x < image.cols; ++x) {
        const Eigen::Vector3d ray = rotation * rays[y * image.cols + x];
        image.at<uchar>(y, x) =
            cv::saturate_cast<uchar>(Gray(world_from_camera[y].translation, ray, 1.0 / camera.pinhole.fx));
      }
    }
  });
  return image;
}

}  // namespace turnscale

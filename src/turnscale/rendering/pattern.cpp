// SPDX-License-Identifier: MIT
#include "turnscale/rendering/pattern.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turnscale/base/random.h"
#include "turnscale/rendering/pattern_drawing.h"

namespace turnscale {
namespace {

// Seeds of the layers of one pattern.
std::uint64_t Layer(const PatternOptions& options, std::uint64_t layer) { return Hash(options.seed * 1000 + layer); }

Eigen::Vector2f AnyPlace(const cv::Mat& pattern, Random& random) {
  const auto side = static_cast<float>(pattern.rows);
  const float x = random.UniformFloat(0, side);
  return {x, random.UniformFloat(0, side)};
}

Eigen::Vector2f Direction(float angle) { return {std::cos(angle), std::sin(angle)}; }

// Pixels of a pattern of 1024 in one of this side.
float Scale(const cv::Mat& pattern) { return static_cast<float>(pattern.rows) / 1024; }

// Round spots with soft rims, bright and dark: pebbles, chewing gum, drops of oil.
void AddSpots(int count, float least, float most, float strength, Random& random, cv::Mat& pattern) {
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2f centre = AnyPlace(pattern, random);
    // Many small ones, few large ones.
    const float t = random.UniformFloat(0, 1);
    const float radius = least + (most - least) * t * t * t;
    const float value = strength * random.UniformFloat(-1, 1);
    const float stretch = random.UniformFloat(0.6F, 1);
    const Eigen::Vector2f axis = Direction(random.UniformFloat(0, std::numbers::pi_v<float>));
    const auto paint = [&](float& pixel, const Eigen::Vector2f& at) {
      const float along = at.dot(axis);
      const float across = (at.x() * axis.y() - at.y() * axis.x()) / stretch;
      const float distance = std::sqrt(along * along + across * across);
      pixel += value * (1 - Smooth(radius - 0.35F * radius - 0.5F, radius + 0.5F, distance));
    };
    PaintAround(centre, radius + 1.5F, paint, pattern);
  }
}

// A crack: a line that wanders, and now and then splits.
void AddCrack(Eigen::Vector2f at, float angle, int steps, float width, Random& random, cv::Mat& pattern) {
  const float main_angle = angle;
  for (int i = 0; i < steps; ++i) {
    // Wanders around one direction, so that it does not curl.
    angle += random.UniformFloat(-0.5F, 0.5F) + 0.06F * (main_angle - angle);
    at += Direction(angle);
    const float half = width * random.UniformFloat(0.6F, 1.1F);
    const auto paint = [&](float& pixel, const Eigen::Vector2f& from) {
      pixel = std::min(pixel, pixel + 0.9F * (Smooth(half * 0.5F, half + 0.7F, from.norm()) - 1));
    };
    PaintAround(at, half + 1, paint, pattern);
    if (width > 0.8F && random.Uniform() < 0.004F)
      AddCrack(at, angle + random.UniformFloat(-1.2F, 1.2F), steps / 3, width * 0.7F, random, pattern);
  }
}

// A rectangle that was opened and closed again: another shade, a seam of tar around it.
void AddPatch(Random& random, cv::Mat& pattern) {
  const float scale = Scale(pattern);
  const Eigen::Vector2f centre = AnyPlace(pattern, random);
  const Eigen::Vector2f half(scale * random.UniformFloat(40, 150), scale * random.UniformFloat(30, 110));
  const Eigen::Vector2f axis = Direction(random.UniformFloat(-0.1F, 0.1F) + (random.Uniform() < 0.5F ? 0 : 1.5708F));
  const float shade = random.UniformFloat(-0.9F, 0.9F);
  const auto paint = [&](float& pixel, const Eigen::Vector2f& at) {
    const float x = std::abs(at.dot(axis)) - half.x();
    const float y = std::abs(at.x() * axis.y() - at.y() * axis.x()) - half.y();
    const float outside = std::max(x, y);
    pixel += shade * (1 - Smooth(-0.5F, 0.5F, outside));
    pixel -= 1.1F * (1 - Smooth(0.5F, 2, std::abs(outside)));
  };
  PaintAround(centre, half.norm() + 3, paint, pattern);
}

// Blades and leaves, the later ones on top.
void AddLeaves(int count, float length, float depth, Random& random, cv::Mat& pattern) {
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2f centre = AnyPlace(pattern, random);
    const float half = length * random.UniformFloat(0.5F, 1.0F);
    const float width = half * random.UniformFloat(0.35F, 0.6F);
    const Eigen::Vector2f axis = Direction(random.UniformFloat(0, 2 * std::numbers::pi_v<float>));
    const float shade = depth + random.UniformFloat(-0.9F, 0.9F);
    const float tilt = random.UniformFloat(-0.6F, 0.6F);
    const auto paint = [&](float& pixel, const Eigen::Vector2f& at) {
      const float along = at.dot(axis) / half;
      const float across = (at.x() * axis.y() - at.y() * axis.x()) / width;
      const float outside = along * along + std::abs(across) - 1;
      if (outside > 0) return;
      // Halves to both sides of the rib catch the light differently.
      const float rib = across > 0 ? 0.25F : -0.25F;
      pixel = shade + tilt * along + rib - 0.7F * Smooth(-0.25F, 0, outside);
    };
    PaintAround(centre, half + 1, paint, pattern);
  }
}

}  // namespace

cv::Mat CloudPattern(const PatternOptions& options, double roughness) {
  CheckSide(options);
  cv::Mat pattern = Clouds(options.side, Layer(options, 1), roughness);
  Finish(options, pattern);
  return pattern;
}

cv::Mat PavementPattern(const PatternOptions& options) {
  CheckSide(options);
  cv::Mat pattern = 0.45 * Clouds(options.side, Layer(options, 1), 1.1);
  Random random(Layer(options, 2));
  const float scale = Scale(pattern);
  const int area = options.side * options.side;
  for (int i = 0; i < 7; ++i) AddPatch(random, pattern);
  AddSpots(60, 20 * scale, 70 * scale, 0.7F, random, pattern);
  AddSpots(500, 4 * scale, 18 * scale, 1.1F, random, pattern);
  AddSpots(area / 40, 0.6F, 3.5F, 0.9F, random, pattern);
  for (int i = 0; i < 7; ++i) {
    const Eigen::Vector2f start = AnyPlace(pattern, random);
    const float angle = random.UniformFloat(0, 2 * std::numbers::pi_v<float>);
    AddCrack(start, angle, static_cast<int>(scale * random.UniformFloat(150, 700)), random.UniformFloat(0.8F, 2.0F),
             random, pattern);
  }
  Finish(options, pattern);
  return pattern;
}

cv::Mat FoliagePattern(const PatternOptions& options) {
  CheckSide(options);
  cv::Mat pattern = 0.5 * Clouds(options.side, Layer(options, 1), 1.3) - 1.6;
  Random random(Layer(options, 2));
  const float scale = Scale(pattern);
  // Deep leaves in the shade first, then those in the light; clumps of leaves light and dark over all.
  AddLeaves(2600, 30 * scale, -0.9F, random, pattern);
  AddLeaves(3500, 26 * scale, -0.1F, random, pattern);
  AddLeaves(2600, 22 * scale, 0.6F, random, pattern);
  AddLeaves(1800, 14 * scale, 0.9F, random, pattern);
  pattern += 0.55 * Clouds(options.side, Layer(options, 3), 1.6);
  Finish(options, pattern);
  return pattern;
}

}  // namespace turnscale

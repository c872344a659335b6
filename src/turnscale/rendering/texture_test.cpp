// SPDX-License-Identifier: MIT
#include "turnscale/rendering/texture.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/random.h"
#include "turnscale/rendering/pattern.h"

namespace turnscale {
namespace {

constexpr double kSize = 3;

cv::Mat Noise(int side) {
  cv::Mat pattern(side, side, CV_32F);
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) pattern.at<float>(row, column) = HashUniform(5, row, column);
  return pattern;
}

Eigen::Vector2f AnyPlace(Random& random) {
  const float x = random.UniformFloat(-2 * kSize, 2 * kSize);
  return {x, random.UniformFloat(-2 * kSize, 2 * kSize)};
}

TEST(Texture, ShowsPixelsAtTheirCentresAndStraightLinesBetween) {
  const cv::Mat pattern = Noise(16);
  const Texture texture(pattern, kSize);
  const Eigen::Vector2f none = Eigen::Vector2f::Zero();
  const float pixel = kSize / 16;
  for (int row = 0; row < 15; ++row) {
    for (int column = 0; column < 15; ++column) {
      const Eigen::Vector2f at((static_cast<float>(column) + 0.5F) * pixel, (static_cast<float>(row) + 0.5F) * pixel);
      const float here = pattern.at<float>(row, column);
      EXPECT_NEAR(texture.Sample(at, none, 0), here, 1e-4);
      const float next = pattern.at<float>(row + 1, column + 1);
      const float right = pattern.at<float>(row, column + 1);
      const float below = pattern.at<float>(row + 1, column);
      const Eigen::Vector2f between = at + Eigen::Vector2f(0.25F, 0.5F) * pixel;
      EXPECT_NEAR(texture.Sample(between, none, 0), 0.375F * (here + below) + 0.125F * (next + right), 1e-4);
    }
  }
}

TEST(Texture, Repeats) {
  const Texture texture(Noise(32), kSize);
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2f at = AnyPlace(random);
    const float major_y = random.UniformFloat(0, 0.3F);
    const Eigen::Vector2f major(random.UniformFloat(0, 0.3F), major_y);
    const auto turns_y = static_cast<float>(random.Below(7) - 3);
    const Eigen::Vector2f turns(static_cast<float>(random.Below(7) - 3), turns_y);
    EXPECT_NEAR(texture.Sample(at, major, 0.02F), texture.Sample(at + kSize * turns, major, 0.02F), 1e-3);
  }
}

TEST(Texture, ContrastKeepsTheMean) {
  const Texture texture(Noise(32), kSize);
  const Texture faded = texture.WithContrast(0.25F);
  const Eigen::Vector2f none = Eigen::Vector2f::Zero();
  const float mean = texture.Sample(none, {kSize, 0}, kSize);
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2f at = AnyPlace(random);
    EXPECT_NEAR(faded.Sample(at, none, 0) - mean, 0.25F * (texture.Sample(at, none, 0) - mean), 1e-4);
  }
}

// Mean over one turn of the pattern is that of the pattern, whatever a sample covers.
TEST(Texture, KeepsTheMean) {
  const cv::Mat pattern = Noise(64);
  const Texture texture(pattern, kSize);
  for (const float minor : {0.001F, 0.03F, 0.1F, 0.4F, 3.0F}) {
    for (const float ratio : {1.0F, 2.6F, 7.0F, 20.0F}) {
      const Eigen::Vector2f major = minor * ratio * Eigen::Vector2f(0.6F, 0.8F);
      double sum = 0;
      constexpr int kSteps = 128;
      for (int row = 0; row < kSteps; ++row)
        for (int column = 0; column < kSteps; ++column)
          sum += texture.Sample(Eigen::Vector2f(column, row) * (kSize / kSteps), major, minor);
      EXPECT_NEAR(sum / kSteps / kSteps, cv::mean(pattern)[0], 1e-3) << minor << " " << ratio;
    }
  }
}

TEST(Texture, FarAwayShowsTheMean) {
  const cv::Mat pattern = Noise(64);
  const Texture texture(pattern, kSize);
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2f at = AnyPlace(random);
    EXPECT_NEAR(texture.Sample(at, {2 * kSize, 0}, 2 * kSize), cv::mean(pattern)[0], 1e-3);
  }
}

// Mean of the pattern over an ellipse, point by point.
double MeanOverEllipse(const cv::Mat& pattern, const Eigen::Vector2f& at, const Eigen::Vector2f& major, float minor) {
  const Eigen::Vector2f across = Eigen::Vector2f(-major.y(), major.x()).normalized() * minor;
  double sum = 0;
  int count = 0;
  for (int i = -40; i <= 40; ++i) {
    for (int j = -20; j <= 20; ++j) {
      const Eigen::Vector2f inside(static_cast<float>(i) / 40, static_cast<float>(j) / 20);
      if (inside.norm() > 1) continue;
      const Eigen::Vector2f place = (at + inside.x() * major + inside.y() * across) * (pattern.rows / kSize);
      sum += pattern.at<float>(static_cast<int>(std::floor(place.y())) & (pattern.rows - 1),
                               static_cast<int>(std::floor(place.x())) & (pattern.rows - 1));
      ++count;
    }
  }
  return sum / count;
}

TEST(Texture, AveragesOverTheEllipse) {
  PatternOptions options;
  options.side = 512;
  const cv::Mat pattern = CloudPattern(options);
  const Texture texture(pattern, kSize);
  Random random(3);
  double along_error = 0;
  double across_error = 0;
  constexpr int kPlaces = 400;
  for (int i = 0; i < kPlaces; ++i) {
    const Eigen::Vector2f at = AnyPlace(random);
    const float angle = random.UniformFloat(0, 3.14F);
    const Eigen::Vector2f major = 0.2F * Eigen::Vector2f(std::cos(angle), std::sin(angle));
    const Eigen::Vector2f turned(-major.y(), major.x());
    const double mean = MeanOverEllipse(pattern, at, major, 0.03F);
    along_error += std::pow(texture.Sample(at, major, 0.03F) - mean, 2);
    across_error += std::pow(texture.Sample(at, turned, 0.03F) - mean, 2);
  }
  EXPECT_LT(std::sqrt(along_error / kPlaces), 0.02);
  // An ellipse the wrong way round is much farther off.
  EXPECT_GT(std::sqrt(across_error / along_error), 2);
}

TEST(Texture, RefusesOtherShapes) {
  EXPECT_THROW(Texture(cv::Mat(16, 16, CV_8U, cv::Scalar(1)), 1), InternalError);
  EXPECT_THROW(Texture(cv::Mat(16, 8, CV_32F, cv::Scalar(1)), 1), InternalError);
  EXPECT_THROW(Texture(cv::Mat(12, 12, CV_32F, cv::Scalar(1)), 1), InternalError);
  EXPECT_THROW(Texture(cv::Mat(16, 16, CV_32F, cv::Scalar(-1)), 1), InternalError);
  EXPECT_THROW(Texture(cv::Mat(16, 16, CV_32F, cv::Scalar(1)), 0), InternalError);
}

}  // namespace
}  // namespace turnscale

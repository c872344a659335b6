// SPDX-License-Identifier: MIT
#include "turnscale/features/optical_flow.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/quantiles.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/features/synthetic_texture.h"

namespace turnscale {
namespace {

const cv::Size kFlowImageSize(400, 300);

FlowImage Shifted(const SyntheticTexture& texture, const Eigen::Vector2d& shift) {
  return BuildFlowImage(
      {}, MakeImage(kFlowImageSize, [&](const Eigen::Vector2d& pixel) { return texture.At(pixel - shift); }));
}

std::vector<cv::Point2f> Grid(int margin, int spacing) {
  std::vector<cv::Point2f> points;
  for (int y = margin; y <= kFlowImageSize.height - margin; y += spacing)
    for (int x = margin; x <= kFlowImageSize.width - margin; x += spacing)
      points.emplace_back(static_cast<float>(x) + 0.3F, static_cast<float>(y) - 0.2F);
  return points;
}

int Found(const FlowResult& flow) { return static_cast<int>(std::ranges::count(flow.found, 1)); }

TEST(OpticalFlow, HoldsOneCopyOfTheImage) {
  const cv::Mat gray = MakeImage(kFlowImageSize, [texture = SyntheticTexture(1, 8, 100)](const Eigen::Vector2d& pixel) {
    return texture.At(pixel);
  });
  const FlowImage image = BuildFlowImage({}, gray);
  EXPECT_NE(image.gray.data, gray.data);
  EXPECT_EQ(image.gray.data, image.pyramid[0].data);
  EXPECT_EQ(cv::norm(image.gray, gray, cv::NORM_INF), 0);

  // A part of an image is an image.
  const cv::Mat part = gray(cv::Rect(100, 80, 200, 150));
  cv::Mat of_part = BuildFlowImage({}, part).gray;
  cv::Mat of_copy = BuildFlowImage({}, part.clone()).gray;
  for (cv::Mat* whole : {&of_part, &of_copy}) whole->adjustROI(8, 8, 8, 8);
  EXPECT_EQ(of_part.size(), cv::Size(216, 166));
  EXPECT_EQ(cv::norm(of_part, of_copy, cv::NORM_INF), 0);
}

TEST(OpticalFlow, FindsASubPixelShift) {
  const SyntheticTexture texture(1, 8, 100);
  const FlowImage first = Shifted(texture, {0, 0});
  const std::vector<cv::Point2f> points = Grid(40, 20);
  for (const Eigen::Vector2d& shift : {Eigen::Vector2d(0.37, -0.21), Eigen::Vector2d(9.3, -6.6)}) {
    const FlowResult flow = TrackPoints({}, first, Shifted(texture, shift), points, points);
    EXPECT_GT(Found(flow), 0.97 * static_cast<double>(points.size()));
    for (size_t i = 0; i < points.size(); ++i) {
      if (flow.found[i] == 0) continue;
      EXPECT_NEAR(flow.points[i].x - points[i].x, shift.x(), 0.05) << points[i];
      EXPECT_NEAR(flow.points[i].y - points[i].y, shift.y(), 0.05) << points[i];
    }
  }
}

TEST(OpticalFlow, AWideImageIsFollowedAsFar) {
  // The same scene at twice the size moves by twice the pixels.
  std::vector<int> followed;
  for (const int zoom : {1, 2}) {
    const SyntheticTexture texture(1, 16.0 * zoom, 400.0 * zoom);
    const auto image = [&](double shift) {
      return BuildFlowImage({}, MakeImage({1280 * zoom, 240 * zoom}, [&](const Eigen::Vector2d& pixel) {
                              return texture.At(pixel - Eigen::Vector2d(shift, 0));
                            }));
    };
    std::vector<cv::Point2f> points;
    for (int x = 200; x <= 1080; x += 40)
      points.emplace_back(static_cast<float>(x * zoom), 120.0F * static_cast<float>(zoom));
    const FlowResult flow = TrackPoints({}, image(0), image(40.0 * zoom), points, points);
    int right = 0;
    for (size_t i = 0; i < points.size(); ++i)
      right +=
          flow.found[i] != 0 && std::abs(flow.points[i].x - points[i].x - 40.0F * static_cast<float>(zoom)) < 1 ? 1 : 0;
    followed.push_back(right);
  }
  EXPECT_GT(followed[0], 12) << "of 23";
  EXPECT_GE(followed[1], followed[0]);
}

TEST(OpticalFlow, AGuessReachesFartherThanThePyramid) {
  const SyntheticTexture texture(2, 8, 100);
  FlowOptions options;
  options.levels = 0;
  const auto image = [&](double shift) {
    return BuildFlowImage(options, MakeImage(kFlowImageSize, [&](const Eigen::Vector2d& p) {
                            return texture.At({p.x() - shift, p.y()});
                          }));
  };
  const std::vector<cv::Point2f> points = Grid(70, 20);
  std::vector<cv::Point2f> guesses = points;
  for (cv::Point2f& guess : guesses) guess.x += 49;
  const FlowResult guessed = TrackPoints(options, image(0), image(50), points, guesses);
  for (size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(guessed.found[i], 1);
    EXPECT_NEAR(guessed.points[i].x - points[i].x, 50, 0.004);
  }
}

TEST(OpticalFlow, LastDigitsOfTheGuessDoNotMatter) {
  const SyntheticTexture texture(3, 8, 100);
  const FlowImage first = Shifted(texture, {0, 0});
  const FlowImage second = Shifted(texture, {3.3, 1.7});
  const std::vector<cv::Point2f> points = Grid(40, 20);
  std::vector<cv::Point2f> guesses = points;
  for (cv::Point2f& guess : guesses) guess += cv::Point2f(2.2F, 1.4F);
  std::vector<cv::Point2f> others = guesses;
  for (cv::Point2f& other : others) {
    other.x = std::nextafter(static_cast<float>(other.x + 1e-9), 1e9F);
    other.y = std::nextafter(static_cast<float>(other.y - 1e-9), -1e9F);
  }
  ASSERT_NE(guesses, others);
  const FlowResult a = TrackPoints({}, first, second, points, guesses);
  const FlowResult b = TrackPoints({}, first, second, points, others);
  EXPECT_GT(Found(a), 0.97 * static_cast<double>(points.size()));
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.found, b.found);
}

TEST(OpticalFlow, PointsThatLeaveTheImageAreNotFound) {
  const SyntheticTexture texture(4, 8, 100);
  const FlowImage first = Shifted(texture, {0, 0});
  const FlowImage second = Shifted(texture, {-30, 0});
  const std::vector<cv::Point2f> points = Grid(10, 10);
  std::vector<cv::Point2f> guesses = points;
  for (cv::Point2f& guess : guesses) guess.x -= 30;
  const FlowResult flow = TrackPoints({}, first, second, points, guesses);
  int left_behind = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (points[i].x < 30) {
      EXPECT_EQ(flow.found[i], 0) << points[i];
    } else if (points[i].x > 60) {
      left_behind += flow.found[i] == 0 ? 1 : 0;
    }
  }
  EXPECT_LT(left_behind, 0.05 * static_cast<double>(points.size()));
}

TEST(OpticalFlow, WhatIsHiddenDoesNotFindItsWayBack) {
  const SyntheticTexture texture(5, 8, 100);
  const SyntheticTexture other(6, 8, 100);
  const cv::Rect2d hidden(120, 80, 160, 140);
  const FlowImage first = Shifted(texture, {0, 0});
  const FlowImage second =
      BuildFlowImage({}, MakeImage(kFlowImageSize, [&](const Eigen::Vector2d& pixel) {
                       return hidden.contains({pixel.x(), pixel.y()}) ? other.At(pixel) : texture.At(pixel);
                     }));
  std::vector<cv::Point2f> points;
  for (float y = 110; y < 190; y += 10)
    for (float x = 150; x < 250; x += 10) points.emplace_back(x, y);
  FlowResult flow = TrackPoints({}, first, second, points, points);
  EXPECT_GT(Found(flow), 0.5 * static_cast<double>(points.size())) << "it is the way back that tells";
  CheckReturn({}, first, second, points, flow);
  EXPECT_LT(Found(flow), 0.2 * static_cast<double>(points.size()))
      << "a smooth pattern agrees by chance here and there";
}

TEST(OpticalFlow, WhatIsSeenFindsItsWayBack) {
  const SyntheticTexture texture(7, 8, 100);
  const FlowImage first = Shifted(texture, {0, 0});
  const FlowImage second = Shifted(texture, {5.4, -3.3});
  std::vector<cv::Point2f> points = Grid(40, 20);
  FlowResult flow = TrackPoints({}, first, second, points, points);
  flow.found[3] = 0;
  const FlowResult before = flow;
  CheckReturn({}, first, second, points, flow);
  EXPECT_EQ(flow.found[3], 0) << "what was lost stays lost";
  EXPECT_EQ(flow.points, before.points);
  EXPECT_GE(Found(flow), Found(before) - 2);
  EXPECT_GT(Found(flow), 0.97 * static_cast<double>(points.size()));

  const cv::Point2f off(1.0F, 0.0F);
  for (cv::Point2f& point : points) point += off;
  const double found = Found(flow);
  std::vector<uchar> flags(points.size(), 0);
  flags[5] = 1;
  CheckReturn({}, first, second, points, flags, flow);
  EXPECT_EQ(Found(flow), found - 1) << "only those that are to be checked";
  EXPECT_EQ(flow.found[5], 0);
  CheckReturn({}, first, second, points, flow);
  EXPECT_EQ(Found(flow), 0) << "a pixel off is not where they came from";
}

TEST(OpticalFlow, WhatLooksDifferentIsNotTheSamePlace) {
  const FlowImage first = Shifted(SyntheticTexture(1, 4, 20), {0, 0});
  const FlowImage second = Shifted(SyntheticTexture(2, 4, 20), {0, 0});
  const std::vector<cv::Point2f> points = Grid(40, 10);
  // Each point as if it had been found where it was, so that the way back has nowhere better to go.
  FlowResult flow{points, std::vector<uchar>(points.size(), 1)};
  CheckReturn({.max_return_error = 1000}, first, second, points, flow);
  EXPECT_LT(Found(flow), 0.08 * static_cast<double>(points.size()));
}

TEST(OpticalFlow, NoPointsNoResult) {
  const FlowImage image = Shifted(SyntheticTexture(8), {0, 0});
  const FlowResult flow = TrackPoints({}, image, image, {}, {});
  EXPECT_TRUE(flow.points.empty());
  EXPECT_TRUE(flow.found.empty());
  FlowResult nothing;
  CheckReturn({}, image, image, {}, nothing);
  EXPECT_TRUE(nothing.found.empty());
}

TEST(OpticalFlow, AJumpOfTheBrightnessIsTakenOut) {
  const SyntheticTexture texture(1, 8, 100);
  const Eigen::Vector2d shift(2.3, -1.6);
  const FlowImage first = Shifted(texture, {0, 0});
  cv::Mat darker;
  Shifted(texture, shift).gray.convertTo(darker, CV_8U, 0.6);
  // A part that changes by itself: a lorry passes.
  darker(cv::Rect(0, 0, 150, 300)).setTo(230);
  const FlowImage second = BuildFlowImage({}, darker);
  const FlowImage matched = MatchBrightness({}, first, second);
  EXPECT_NEAR(cv::mean(matched.gray)[0] / cv::mean(first.gray)[0], 0.6, 0.03);
  std::vector<cv::Point2f> points = Grid(40, 20);
  std::erase_if(points, [](const cv::Point2f& point) { return point.x < 200; });
  const auto off = [&](const FlowImage& before) {
    const FlowResult flow = TrackPoints({}, before, second, points, points);
    std::vector<double> errors;
    for (size_t i = 0; i < points.size(); ++i)
      errors.push_back(
          std::hypot(flow.points[i].x - points[i].x - shift.x(), flow.points[i].y - points[i].y - shift.y()));
    return Median(std::move(errors));
  };
  EXPECT_LT(off(matched), 0.25);
  EXPECT_GT(off(first), 3 * off(matched));
}

TEST(OpticalFlow, ImagesOfAboutTheSameBrightnessStayAsTheyAre) {
  const SyntheticTexture texture(1, 8, 100);
  const FlowImage first = Shifted(texture, {0, 0});
  EXPECT_EQ(MatchBrightness({}, first, Shifted(texture, {3, 2})).gray.data, first.gray.data);
  const FlowImage black = BuildFlowImage({}, cv::Mat::zeros(kFlowImageSize, CV_8U));
  EXPECT_EQ(MatchBrightness({}, first, black).gray.data, first.gray.data) << "which shows something else";
  EXPECT_EQ(MatchBrightness({}, black, first).gray.data, black.gray.data);
}

TEST(OpticalFlow, ADarkImageIsBrightened) {
  const SyntheticTexture texture(1, 8, 100);
  const cv::Mat day = Shifted(texture, {0, 0}).gray;
  cv::Mat night;
  day.convertTo(night, CV_8U, 0.15);
  EXPECT_NEAR(cv::mean(BuildFlowImage({}, night).gray)[0], 4 * cv::mean(night)[0], 0.5);
  EXPECT_EQ(cv::norm(BuildFlowImage({.min_brightness = 0}, night).gray, night, cv::NORM_INF), 0);
}

TEST(OpticalFlow, LargerPatchesFollowADarkImage) {
  const SyntheticTexture texture(1, 8, 100);
  const Eigen::Vector2d shift(2.4, -1.7);
  const auto at_night = [&](const Eigen::Vector2d& moved, int seed) {
    cv::Mat night;
    Shifted(texture, moved).gray.convertTo(night, CV_32F, 0.15);
    cv::Mat noise(night.size(), CV_32F);
    cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0, 4);
    night += noise;
    night.convertTo(night, CV_8U);
    return BuildFlowImage({}, night);
  };
  const std::vector<cv::Point2f> points = Grid(40, 10);
  const auto followed = [&](const FlowOptions& options) {
    const FlowResult flow = TrackPoints(options, at_night({0, 0}, 1), at_night(shift, 2), points, points);
    int right = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const cv::Point2f off = flow.points[i] - points[i];
      right += flow.found[i] != 0 && (Eigen::Vector2d(off.x, off.y) - shift).norm() < 0.5 ? 1 : 0;
    }
    return static_cast<double>(right) / static_cast<double>(points.size());
  };
  const double with_large_patches = followed({});
  const double with_small_patches = followed({.dark_window = 15});
  EXPECT_GT(with_large_patches, 0.9);
  EXPECT_GT(with_large_patches, with_small_patches + 0.1);
}

TEST(OpticalFlow, OptionsNameTheFieldThatMakesNoSense) {
  EXPECT_EQ(RefusedField<FlowOptions>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<FlowOptions>([](auto& o) { o.window = 14; }), "window");
  EXPECT_EQ(RefusedField<FlowOptions>([](auto& o) { o.window = 3; }), "window");
  EXPECT_EQ(RefusedField<FlowOptions>([](auto& o) { o.dark_window = 24; }), "dark_window");
  EXPECT_EQ(RefusedField<FlowOptions>([](auto& o) { o.levels = -1; }), "levels");
  EXPECT_EQ(RefusedField<FlowOptions>([](auto& o) { o.levels = 9; }), "levels");
  EXPECT_EQ(RefusedField<FlowOptions>([](auto& o) { o.max_return_error = 0; }), "max_return_error");
  EXPECT_EQ(RefusedField<FlowOptions>([](auto& o) { o.min_brightness = -1; }), "min_brightness");
  EXPECT_EQ(RefusedField<FlowOptions>([](auto& o) { o.max_brightness_change = 0; }), "max_brightness_change");
}

}  // namespace
}  // namespace turnscale

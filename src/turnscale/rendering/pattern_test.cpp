// SPDX-License-Identifier: MIT
#include "turnscale/rendering/pattern.h"

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

struct NamedPattern {
  std::string name;
  std::function<cv::Mat(const PatternOptions&)> make;
};

std::vector<NamedPattern> Patterns() {
  return {{"clouds", [](const PatternOptions& options) { return CloudPattern(options); }},
          {"pavement", [](const PatternOptions& options) { return PavementPattern(options); }},
          {"bricks", [](const PatternOptions& options) { return BrickPattern(options, 13); }},
          {"foliage", [](const PatternOptions& options) { return FoliagePattern(options); }},
          {"facade", [](const PatternOptions& options) { return FacadePattern(options, 3, 4); }}};
}

PatternOptions Small() {
  PatternOptions options;
  options.side = 256;
  return options;
}

// Root mean square of the differences between a row (or column) and the next one around the pattern.
double StepAcross(const cv::Mat& pattern, int row) {
  const cv::Mat difference = pattern.row((row + 1) % pattern.rows) - pattern.row(row);
  return cv::norm(difference) / std::sqrt(pattern.cols);
}

TEST(Pattern, HasNoSeams) {
  for (const NamedPattern& pattern : Patterns()) {
    const cv::Mat upright = pattern.make(Small());
    for (const cv::Mat& turned : {upright, cv::Mat(upright.t())}) {
      double largest = 0;
      for (int row = 0; row + 1 < turned.rows; ++row) largest = std::max(largest, StepAcross(turned, row));
      EXPECT_LT(StepAcross(turned, turned.rows - 1), 1.1 * largest) << pattern.name;
    }
  }
  // Where no edges are meant, the seam is like any other place.
  for (const auto& make : {Patterns()[0].make, Patterns()[3].make}) {
    const cv::Mat pattern = make(Small());
    double sum = 0;
    for (int row = 0; row + 1 < pattern.rows; ++row) sum += StepAcross(pattern, row);
    EXPECT_LT(StepAcross(pattern, pattern.rows - 1), 1.3 * sum / (pattern.rows - 1));
  }
}

TEST(Pattern, SameSeedSamePattern) {
  for (const NamedPattern& pattern : Patterns()) {
    PatternOptions other = Small();
    other.seed = 2;
    const cv::Mat first = pattern.make(Small());
    EXPECT_EQ(cv::norm(first, pattern.make(Small()), cv::NORM_INF), 0) << pattern.name;
    EXPECT_GT(cv::norm(first, pattern.make(other), cv::NORM_L1) / 256 / 256, 0.02) << pattern.name;
  }
}

TEST(Pattern, HasTheMeanAndContrastAskedFor) {
  PatternOptions options = Small();
  options.mean = 0.4F;
  options.contrast = 0.1F;
  for (const NamedPattern& pattern : Patterns()) {
    const cv::Mat made = pattern.make(options);
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(made, mean, deviation);
    EXPECT_NEAR(mean[0], 0.4, 0.01) << pattern.name;
    EXPECT_NEAR(deviation[0], 0.1, 0.01) << pattern.name;
    double least = 0;
    double most = 0;
    cv::minMaxLoc(made, &least, &most);
    EXPECT_GE(least, 0) << pattern.name;
    EXPECT_LE(most, 1) << pattern.name;
  }
}

// Seen from farther and farther away, there is something to see.
TEST(Pattern, HasDetailOfEverySize) {
  PatternOptions options;
  for (const NamedPattern& pattern : Patterns()) {
    cv::Mat seen = pattern.make(options);
    for (int side = options.side; side >= 16; side /= 2) {
      cv::Mat blurred;
      cv::blur(seen, blurred, cv::Size(3, 3), cv::Point(-1, -1), cv::BORDER_REFLECT_101);
      const double detail = cv::norm(seen, blurred, cv::NORM_L2) / side;
      EXPECT_GT(detail, 0.06 * options.contrast) << pattern.name << " at " << side;
      cv::resize(seen, seen, cv::Size(side / 2, side / 2), 0, 0, cv::INTER_AREA);
    }
  }
}

TEST(Pattern, RefusesWhatDoesNotFit) {
  PatternOptions odd;
  odd.side = 100;
  for (const NamedPattern& pattern : Patterns()) EXPECT_THROW(pattern.make(odd), InternalError);
  EXPECT_THROW(BrickPattern(Small(), 0), InternalError);
  EXPECT_THROW(BrickPattern(Small(), 200), InternalError);
  EXPECT_THROW(FacadePattern(Small(), 0, 3), InternalError);
  EXPECT_THROW(FacadePattern(Small(), 3, 200), InternalError);
}

}  // namespace
}  // namespace turnscale

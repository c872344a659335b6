// SPDX-License-Identifier: MIT
#include "turnscale/simulation/windscreen.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/refused_field.h"

namespace turnscale {
namespace {

const cv::Size kView(320, 180);
const WindscreenOptions kInterior = {.dashboard = 0.2, .reflection = 0.1, .defocus = 1};

cv::Mat Scene(double brightness) { return {kView, CV_32F, cv::Scalar(brightness)}; }

bool SameImage(const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) == 0; }

TEST(Windscreen, WithoutDashboardTheSceneIsUnchanged) {
  const Windscreen none({}, kView, 1);
  EXPECT_TRUE(none.covered().empty());
  EXPECT_TRUE(SameImage(none.Through(Scene(0.3)), Scene(0.3)));
}

TEST(Windscreen, DashboardCoversTheLowerPartAndNothingOfTheUpperHalf) {
  const Windscreen windscreen(kInterior, kView, 1);
  const cv::Mat& covered = windscreen.covered();
  ASSERT_EQ(covered.size(), kView);
  const double share = cv::countNonZero(covered) / static_cast<double>(kView.area());
  EXPECT_NEAR(share, 0.2, 0.05);
  EXPECT_EQ(cv::countNonZero(covered.rowRange(0, 120)), 0);
  EXPECT_EQ(cv::countNonZero(covered.rowRange(160, 180)), 20 * kView.width);
  // What is covered does not show.
  cv::Mat other = Scene(0.3);
  other.setTo(9, covered);
  EXPECT_TRUE(SameImage(windscreen.Through(Scene(0.3)), windscreen.Through(other)));
}

TEST(Windscreen, ReflectionIsFaintAndOfTheLowerView) {
  const cv::Mat scene = Scene(0.4);
  WindscreenOptions plain = kInterior;
  plain.reflection = 0;
  const cv::Mat reflected = Windscreen(kInterior, kView, 1).Through(scene) - Windscreen(plain, kView, 1).Through(scene);
  double least = 0;
  double most = 0;
  cv::minMaxLoc(reflected, &least, &most);
  EXPECT_GE(least, -1e-6);
  EXPECT_GT(most, 0.02);
  EXPECT_LT(most, 0.1) << "a quarter of the scene";
  EXPECT_LT(cv::norm(reflected.rowRange(0, 40), cv::NORM_INF), 1e-6);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(reflected.rowRange(100, 140), mean, deviation);
  EXPECT_GT(deviation[0], 0.002) << "it has texture";
}

TEST(Windscreen, DashboardIsTexturedAndHasTheLightOfTheScene) {
  const Windscreen windscreen(kInterior, kView, 1);
  const cv::Mat dark = windscreen.Through(Scene(0.1)).rowRange(165, 180);
  const cv::Mat bright = windscreen.Through(Scene(0.4)).rowRange(165, 180);
  EXPECT_LT(cv::norm(bright, 4 * dark, cv::NORM_INF), 1e-5);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(bright, mean, deviation);
  EXPECT_GT(deviation[0], 0.1 * mean[0]);
}

TEST(Windscreen, DefocusTakesFineDetail) {
  const auto detail = [](double defocus) {
    WindscreenOptions options = kInterior;
    options.defocus = defocus;
    cv::Mat edges;
    cv::Laplacian(Windscreen(options, kView, 1).Through(Scene(0.4)), edges, CV_32F);
    return cv::norm(edges.rowRange(150, 180));
  };
  EXPECT_LT(detail(2), 0.3 * detail(0));
}

TEST(Windscreen, DependsOnSeedAlone) {
  const auto image = [](std::uint64_t seed) { return Windscreen(kInterior, kView, seed).Through(Scene(0.4)); };
  EXPECT_TRUE(SameImage(image(1), image(1)));
  EXPECT_FALSE(SameImage(image(1), image(2)));
}

TEST(WindscreenOptions, ComplaintsNameTheField) {
  EXPECT_EQ(RefusedField<WindscreenOptions>([](WindscreenOptions&) {}), "");
  EXPECT_EQ(RefusedField<WindscreenOptions>([](WindscreenOptions& o) { o.dashboard = 1; }), "windscreen.dashboard");
  EXPECT_EQ(RefusedField<WindscreenOptions>([](WindscreenOptions& o) { o.reflection = -1; }), "windscreen.reflection");
  EXPECT_EQ(RefusedField<WindscreenOptions>([](WindscreenOptions& o) { o.defocus = -1; }), "windscreen.defocus");
}

}  // namespace
}  // namespace turnscale

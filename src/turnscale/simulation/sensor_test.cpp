// SPDX-License-Identifier: MIT
#include "turnscale/simulation/sensor.h"

#include <cmath>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"

namespace turnscale {
namespace {

constexpr double kRate = 10;

CameraModel Camera() {
  CameraModel camera;
  camera.width = 160;
  camera.height = 120;
  camera.pinhole = {100, 100, 79.5, 59.5};
  return camera;
}

cv::Mat Even(double brightness) { return {120, 160, CV_32F, cv::Scalar(brightness)}; }

// A sensor that shows the light as it is: white in full light is 255.
SensorOptions Ideal() {
  SensorOptions options;
  options.min_gain = 1;
  options.max_gain = 1;
  options.vignetting = 0;
  options.shot_noise = 0;
  options.read_noise = 0;
  options.response = 1;
  return options;
}

cv::Mat Expose(const SensorOptions& options, const cv::Mat& brightness) {
  return Sensor(options, Camera(), kRate, 1).Expose(brightness);
}

double Mean(const cv::Mat& image) { return cv::mean(image)[0]; }

double Deviation(const cv::Mat& image) {
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(image, mean, deviation);
  return deviation[0];
}

TEST(NormalNoise, HasTheMomentsOfANormalNumber) {
  std::vector<float> values(200000);
  FillNormalNoise(7, values);
  double mean = 0;
  double square = 0;
  double fourth = 0;
  double neighbours = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    const double x = values[i];
    EXPECT_LE(std::abs(x), 4.33);
    mean += x;
    square += x * x;
    fourth += x * x * x * x;
    if (i > 0) neighbours += x * values[i - 1];
  }
  const auto count = static_cast<double>(values.size());
  EXPECT_NEAR(mean / count, 0, 0.01);
  EXPECT_NEAR(square / count, 1, 0.02);
  EXPECT_NEAR(fourth / count, 3, 0.1);
  EXPECT_NEAR(neighbours / count, 0, 0.01);
  std::vector<float> tail(1000);
  FillNormalNoise(7, tail);
  EXPECT_EQ(tail, std::vector<float>(values.begin(), values.begin() + 1000));
  FillNormalNoise(8, tail);
  EXPECT_NE(tail, std::vector<float>(values.begin(), values.begin() + 1000));
}

TEST(Sensor, LeavesTheLightThatItIsGiven) {
  for (const double vignetting : {0.0, 0.4}) {
    SensorOptions options = Ideal();
    options.vignetting = vignetting;
    options.blur = 2;
    cv::Mat light = Even(0.2);
    light.colRange(80, 160) = 0.8;
    const cv::Mat before = light.clone();
    Expose(options, light);
    EXPECT_EQ(cv::norm(light, before, cv::NORM_INF), 0);
  }
}

TEST(Sensor, IdealOneShowsTheLightAsItIs) {
  cv::Mat light = Even(0.5);
  light.at<float>(3, 4) = 0.25F;
  light.at<float>(3, 5) = 3;
  light.at<float>(3, 6) = -1;
  const cv::Mat image = Expose(Ideal(), light);
  ASSERT_EQ(image.type(), CV_8U);
  EXPECT_NEAR(image.at<uchar>(3, 4), 63.75, 0.51);
  EXPECT_EQ(image.at<uchar>(3, 5), 255);
  EXPECT_EQ(image.at<uchar>(3, 6), 0);
  EXPECT_NEAR(image.at<uchar>(60, 80), 127.5, 0.51);
}

TEST(Sensor, DefaultNoiseIsTwoGrayLevelsAtMidGray) {
  SensorOptions options;
  options.vignetting = 0;
  options.target_gray = 128;
  const cv::Mat image = Expose(options, Even(0.3));
  EXPECT_NEAR(Mean(image), 128, 0.5);
  EXPECT_NEAR(Deviation(image), 2, 0.4);
}

TEST(Sensor, NoiseGrowsWithTheRootOfTheLevel) {
  SensorOptions options = Ideal();
  options.shot_noise = 6;
  EXPECT_NEAR(Deviation(Expose(options, Even(128 / 255.0))), 6, 0.1);
  EXPECT_NEAR(Deviation(Expose(options, Even(32 / 255.0))), 3, 0.1);
  options.read_noise = 4;
  EXPECT_NEAR(Deviation(Expose(options, Even(32 / 255.0))), 5, 0.1);
}

TEST(Sensor, NoiseDependsOnSeedAndFrameAlone) {
  SensorOptions options = Ideal();
  options.read_noise = 3;
  const auto differing = [](const cv::Mat& a, const cv::Mat& b) { return cv::countNonZero(a != b); };
  Sensor first(options, Camera(), kRate, 1);
  Sensor second(options, Camera(), kRate, 1);
  const cv::Mat one = first.Expose(Even(0.5));
  EXPECT_EQ(differing(one, second.Expose(Even(0.5))), 0);
  const cv::Mat two = first.Expose(Even(0.5));
  EXPECT_EQ(differing(two, second.Expose(Even(0.5))), 0);
  EXPECT_GT(differing(one, two), 10000);
  EXPECT_GT(differing(one, Sensor(options, Camera(), kRate, 2).Expose(Even(0.5))), 10000);
}

TEST(Sensor, ExposureFollowsTheLightWithItsLag) {
  SensorOptions options = Ideal();
  options.min_gain = 0.01;
  options.max_gain = 100;
  options.target_gray = 100;
  options.exposure_lag = 0.5;
  Sensor sensor(options, Camera(), kRate, 1);
  EXPECT_NEAR(Mean(sensor.Expose(Even(0.2))), 100, 1) << "settled before the first frame";
  EXPECT_NEAR(Mean(sensor.Expose(Even(0.4))), 200, 2) << "and not ahead of the light";
  for (int i = 0; i < 4; ++i) sensor.Expose(Even(0.4));
  EXPECT_NEAR(Mean(sensor.Expose(Even(0.4))), 100 * std::pow(2, std::exp(-1)), 2) << "one lag later";
  for (int i = 0; i < 40; ++i) sensor.Expose(Even(0.4));
  EXPECT_NEAR(Mean(sensor.Expose(Even(0.4))), 100, 1);
  EXPECT_NEAR(sensor.gain(), 100 / 255.0 / 0.4, 0.02);
}

TEST(Sensor, GainStaysWithinItsLimits) {
  SensorOptions options = Ideal();
  options.min_gain = 0.5;
  options.max_gain = 2;
  EXPECT_NEAR(Mean(Expose(options, Even(0.05))), 0.05 * 2 * 255, 0.6);
  EXPECT_NEAR(Mean(Expose(options, Even(1.8))), 1.8 * 0.5 * 255, 0.6);
}

TEST(Sensor, FlickerAndJumpsMoveTheExposure) {
  SensorOptions options = Ideal();
  options.flicker = 0.2;
  options.flicker_hz = 2.5;
  Sensor flickering(options, Camera(), kRate, 1);
  const double expected[] = {1, 1.2, 1, 0.8};
  for (const double factor : expected) EXPECT_NEAR(Mean(flickering.Expose(Even(0.4))), 102 * factor, 0.6);
  options = Ideal();
  options.exposure_step = 0.1;
  options.exposure_step_seconds = 1;
  Sensor jumping(options, Camera(), kRate, 1);
  int up = 0;
  for (int second = 0; second < 20; ++second) {
    const double mean = Mean(jumping.Expose(Even(0.4)));
    EXPECT_NEAR(std::abs(mean - 102), 10.2, 0.6);
    up += mean > 102 ? 1 : 0;
    for (int i = 1; i < 10; ++i) EXPECT_EQ(Mean(jumping.Expose(Even(0.4))), mean);
  }
  EXPECT_GT(up, 3);
  EXPECT_LT(up, 17);
}

TEST(Sensor, CornersAreDarker) {
  SensorOptions options = Ideal();
  options.vignetting = 1;
  const cv::Mat image = Expose(options, Even(0.8));
  const double cosine = 1 / std::sqrt(1 + 0.795 * 0.795 + 0.595 * 0.595);
  EXPECT_NEAR(image.at<uchar>(0, 0), 204 * std::pow(cosine, 4), 0.6);
  EXPECT_NEAR(image.at<uchar>(60, 80), 204, 0.6);
}

TEST(Sensor, ResponseLiftsTheDarkAndBlurSpreads) {
  SensorOptions options = Ideal();
  options.response = 0.5;
  EXPECT_NEAR(Mean(Expose(options, Even(0.25))), 127.5, 0.6);
  options = Ideal();
  options.blur = 1;
  cv::Mat light = Even(0);
  light.at<float>(60, 80) = 1;
  EXPECT_NEAR(Expose(options, light).at<uchar>(60, 80), 255 / (2 * 3.14159), 1.5);
}

TEST(SensorOptions, NamesTheFieldThatMakesNoSense) {
  EXPECT_EQ((RefusedField<SensorOptions>([](auto&) {})), "");
  EXPECT_EQ((RefusedField<SensorOptions>([](auto& o) { o.target_gray = 0; })), "sensor.target_gray");
  EXPECT_EQ((RefusedField<SensorOptions>([](auto& o) { o.exposure_lag = -1; })), "sensor.exposure_lag");
  EXPECT_EQ((RefusedField<SensorOptions>([](auto& o) { o.max_gain = 0.1; })), "sensor.max_gain");
  EXPECT_EQ((RefusedField<SensorOptions>([](auto& o) { o.shot_noise = std::nan(""); })), "sensor.shot_noise");
  EXPECT_EQ((RefusedField<SensorOptions>([](auto& o) { o.vignetting = 1.1; })), "sensor.vignetting");
  EXPECT_EQ((RefusedField<SensorOptions>([](auto& o) { o.response = 0; })), "sensor.response");
  EXPECT_EQ((RefusedField<SensorOptions>([](auto& o) { o.readout_ms = -1; })), "sensor.readout_ms");
}

}  // namespace
}  // namespace turnscale

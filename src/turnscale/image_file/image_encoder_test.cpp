// SPDX-License-Identifier: MIT
#include "turnscale/image_file/image_encoder.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

cv::Mat NoisyPicture(const cv::Size& size, int type) {
  std::mt19937 random(5);
  cv::Mat image(size, type);
  for (int y = 0; y < image.rows; ++y) {
    for (int i = 0; i < image.cols * image.channels(); ++i)
      image.ptr<uint8_t>(y)[i] = static_cast<uint8_t>(60 + i % 90 + y % 60 + random() % 20);
  }
  return image;
}

cv::Mat DecodedByOpenCv(const std::string& bytes) {
  return cv::imdecode(std::vector<uint8_t>(bytes.begin(), bytes.end()), cv::IMREAD_UNCHANGED);
}

TEST(ImageEncoder, PngKeepsAllPixels) {
  for (const cv::Size& size : {cv::Size(1, 1), cv::Size(7, 3), cv::Size(320, 200)}) {
    const cv::Mat image = NoisyPicture(size, CV_8UC1);
    const cv::Mat decoded = DecodedByOpenCv(EncodePng(image));
    ASSERT_EQ(decoded.type(), CV_8UC1);
    ASSERT_EQ(decoded.size(), size);
    EXPECT_EQ(cv::norm(decoded, image, cv::NORM_INF), 0);
  }
  const cv::Mat wide = NoisyPicture({100, 50}, CV_8UC1);
  const cv::Mat part = wide(cv::Rect(10, 5, 31, 20));
  EXPECT_EQ(cv::norm(DecodedByOpenCv(EncodePng(part)), part, cv::NORM_INF), 0) << "rows that are not continuous";
}

TEST(ImageEncoder, TheSameImageGivesTheSameBytes) {
  const cv::Mat gray = NoisyPicture({123, 77}, CV_8UC1);
  const std::string png = EncodePng(gray);
  const std::string jpeg = EncodeJpeg(gray, 60);
  EncodePng(NoisyPicture({50, 50}, CV_8UC1));
  EncodeJpeg(NoisyPicture({50, 50}, CV_8UC3), 20);
  EXPECT_EQ(EncodePng(gray.clone()), png);
  EXPECT_EQ(EncodeJpeg(gray.clone(), 60), jpeg);
}

TEST(ImageEncoder, JpegIsAboutAsGoodAndLargeAsOpenCvs) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    cv::Mat image = NoisyPicture({481, 145}, type);
    cv::GaussianBlur(image, image, {}, 1.0);
    for (const int quality : {10, 30, 60, 72, 95}) {
      std::vector<uint8_t> reference;
      cv::imencode(".jpg", image, reference, {cv::IMWRITE_JPEG_QUALITY, quality});
      const std::string jpeg = EncodeJpeg(image, quality);
      const cv::Mat decoded = DecodedByOpenCv(jpeg);
      const cv::Mat expected = cv::imdecode(reference, cv::IMREAD_UNCHANGED);
      ASSERT_EQ(decoded.size(), image.size());
      ASSERT_EQ(decoded.type(), type);
      const auto error = [&](const cv::Mat& other) {
        return cv::norm(other, image, cv::NORM_L1) / static_cast<double>(image.total());
      };
      EXPECT_LT(error(decoded), 1.1 * error(expected) + 0.3) << quality;
      EXPECT_LT(static_cast<double>(jpeg.size()), 1.25 * static_cast<double>(reference.size()) + 400) << quality;
      EXPECT_GT(static_cast<double>(jpeg.size()), 0.5 * static_cast<double>(reference.size())) << quality;
    }
  }
}

TEST(ImageEncoder, JpegKeepsGrayAndColours) {
  const cv::Mat gray(33, 47, CV_8UC1, cv::Scalar(77));
  const cv::Mat decoded = DecodedByOpenCv(EncodeJpeg(gray, 60));
  ASSERT_EQ(decoded.type(), CV_8UC1);
  EXPECT_LE(cv::norm(decoded, gray, cv::NORM_INF), 1);
  const cv::Mat colour(33, 47, CV_8UC3, cv::Scalar(40, 175, 255));
  EXPECT_LE(cv::norm(DecodedByOpenCv(EncodeJpeg(colour, 90)), colour, cv::NORM_INF), 6);
  EXPECT_EQ(EncodeJpeg(gray, 60).substr(6, 4), "JFIF");
  EXPECT_EQ(EncodeJpeg(gray, 60).find("\xFF\xFE"), std::string::npos) << "a comment";
  EXPECT_EQ(DecodedByOpenCv(EncodeJpeg(cv::Mat(1, 1, CV_8UC1, cv::Scalar(9)), 60)).size(), cv::Size(1, 1));
}

TEST(ImageEncoder, OtherImagesAreRefused) {
  EXPECT_THROW(EncodePng(cv::Mat()), InternalError);
  EXPECT_THROW(EncodePng(cv::Mat(4, 4, CV_16UC1, cv::Scalar(0))), InternalError);
  EXPECT_THROW(EncodeJpeg(cv::Mat(4, 4, CV_32FC1, cv::Scalar(0)), 60), InternalError);
  EXPECT_THROW(EncodeJpeg(cv::Mat(4, 4, CV_8UC1, cv::Scalar(0)), 0), InternalError);
  EXPECT_THROW(EncodeJpeg(cv::Mat(4, 4, CV_8UC1, cv::Scalar(0)), 101), InternalError);
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/bag/image_pixels.h"

#include <vector>

#include <gtest/gtest.h>

#include "turnscale/bag/byte_reader.h"
#include "turnscale/base/error.h"

namespace turnscale {
namespace {

BagImage ImageOf(std::string_view encoding, uint32_t width, uint32_t height, const std::vector<uint8_t>& data) {
  BagImage image;
  image.width = width;
  image.height = height;
  image.encoding = encoding;
  image.step = static_cast<uint32_t>(data.size() / height);
  image.data = data;
  return image;
}

TEST(ImagePixels, GrayWithPaddedRows) {
  const std::vector<uint8_t> data = {1, 2, 99, 3, 4, 99};
  const cv::Mat pixels = PixelsOf(ImageOf("mono8", 2, 2, data));
  ASSERT_EQ(pixels.type(), CV_8UC1);
  EXPECT_EQ(pixels.at<uint8_t>(1, 0), 3);
  BagImage last_row_short = ImageOf("mono8", 2, 2, data);
  last_row_short.data = last_row_short.data.first(5);
  EXPECT_EQ(PixelsOf(last_row_short).at<uint8_t>(1, 1), 4);
}

TEST(ImagePixels, SixteenBitsOfEitherOrder) {
  const std::vector<uint8_t> data = {0x34, 0x12};
  BagImage image = ImageOf("mono16", 1, 1, data);
  EXPECT_EQ(PixelsOf(image).at<uint16_t>(0, 0), 0x1234);
  image.big_endian = true;
  EXPECT_EQ(PixelsOf(image).at<uint16_t>(0, 0), 0x3412);
}

TEST(ImagePixels, ColoursBecomeBlueGreenRed) {
  const std::vector<uint8_t> data = {10, 20, 30};
  EXPECT_EQ(PixelsOf(ImageOf("bgr8", 1, 1, data)).at<cv::Vec3b>(0, 0), cv::Vec3b(10, 20, 30));
  EXPECT_EQ(PixelsOf(ImageOf("rgb8", 1, 1, data)).at<cv::Vec3b>(0, 0), cv::Vec3b(30, 20, 10));
  const std::vector<uint8_t> alpha = {10, 20, 30, 255};
  EXPECT_EQ(PixelsOf(ImageOf("rgba8", 1, 1, alpha)).at<cv::Vec3b>(0, 0), cv::Vec3b(30, 20, 10));
}

// The name of the encoding says the colours of the first two pixels of the first two rows.
TEST(ImagePixels, AColourFilterGivesItsColours) {
  for (const std::string filter : {"rggb", "bggr", "gbrg", "grbg"}) {
    constexpr int kSide = 8;
    std::vector<uint8_t> data;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const char colour = filter[2 * (y % 2) + x % 2];
        data.push_back(colour == 'r' ? 200 : colour == 'g' ? 100 : 50);
      }
    }
    const cv::Mat pixels = PixelsOf(ImageOf("bayer_" + filter + "8", kSide, kSide, data));
    ASSERT_EQ(pixels.type(), CV_8UC3);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) EXPECT_EQ(pixels.at<cv::Vec3b>(y, x), cv::Vec3b(50, 100, 200)) << filter;
    }
    const cv::Mat mosaic(kSide, kSide, CV_8UC1, data.data());
    EXPECT_EQ(WithColour(mosaic, "bayer_" + filter + "8; jpeg compressed ").at<cv::Vec3b>(3, 3),
              cv::Vec3b(50, 100, 200));
    EXPECT_EQ(WithColour(mosaic, "mono8; jpeg compressed ").type(), CV_8UC1);
    EXPECT_EQ(WithColour(mosaic, "jpeg").type(), CV_8UC1);
  }
}

TEST(ImagePixels, SizesThatDoNotFit) {
  const std::vector<uint8_t> data(12);
  EXPECT_THROW(PixelsOf(ImageOf("mono8", 5, 3, data)), MalformedData) << "row longer than its bytes";
  BagImage image = ImageOf("mono8", 4, 3, data);
  EXPECT_NO_THROW(PixelsOf(image));
  image.height = 4;
  EXPECT_THROW(PixelsOf(image), MalformedData);
  image.height = 0;
  EXPECT_THROW(PixelsOf(image), MalformedData);
  image = ImageOf("mono8", 4, 3, data);
  image.width = image.height = image.step = 0xFFFFFFFF;
  EXPECT_THROW(PixelsOf(image), MalformedData);
  EXPECT_THROW(PixelsOf(ImageOf("bayer_rggb8", 2, 2, std::vector<uint8_t>(4))), MalformedData);
}

TEST(ImagePixels, UnknownEncodingsAreNamed) {
  EXPECT_NO_THROW(CheckEncoding("mono8", "a.bag"));
  try {
    CheckEncoding("32FC1", "a.bag: /depth: image 0");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("a.bag: /depth: image 0: image encoding '32FC1' is not"));
  }
}

}  // namespace
}  // namespace turnscale

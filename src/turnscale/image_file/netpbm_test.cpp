// SPDX-License-Identifier: MIT
#include "turnscale/image_file/netpbm.h"

#include <string>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace turnscale {
namespace {

constexpr int64_t kMostPixels = 1000;

cv::Mat FileOf(const std::string& text) {
  cv::Mat file(1, static_cast<int>(text.size()), CV_8U);
  std::copy(text.begin(), text.end(), file.data);
  return file;
}

std::span<const uint8_t> BytesOf(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

// Two rows of three pixels.
const std::string kPixels = "abcdef";
const cv::Mat kImage = (cv::Mat_<uint8_t>(2, 3) << 'a', 'b', 'c', 'd', 'e', 'f');

bool AreEqual(const cv::Mat& a, const cv::Mat& b) { return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0; }

TEST(Netpbm, HeadersAreReadWithCommentsAndAnyWhitespace) {
  for (const std::string header :
       {"P5 3 2 255 ", "P5\n3 2\n255\n", "P5\r3\t2\v255\f", "P5 # two\n# lines\n3 2 #2 4\n255\n", "P5 3#9\n2 255\n"}) {
    SCOPED_TRACE(header);
    EXPECT_TRUE(AreEqual(PgmInPlace(FileOf(header + kPixels)), kImage));
    EXPECT_TRUE(AreEqual(DecodeBinaryNetpbm(BytesOf(header + kPixels), kMostPixels).gray, kImage));
  }
}

TEST(Netpbm, DamagedHeadersAreRefused) {
  for (const std::string header :
       {"", "P", "P5", "P4 3 2 255\n", "P53 2 255\n", "P5 3 2 255", "P5 3 2 255#", "P5 3 2 70000\n", "P5 0 2 255\n",
        "P5 -3 2 255\n", "P5 3 2\n", "P5 a 2 255\n", "P5 1000001 1 255\n", "P5 99999999999 1 255\n"}) {
    EXPECT_FALSE(HeaderOfNetpbm(BytesOf(header))) << header;
    EXPECT_TRUE(PgmInPlace(FileOf(header)).empty()) << header;
    EXPECT_TRUE(DecodeBinaryNetpbm(BytesOf(header), kMostPixels).gray.empty()) << header;
  }
}

TEST(Netpbm, MissingPixelsAreRefused) {
  const std::string cut = "P5 3 2 255\nabcde";
  EXPECT_TRUE(PgmInPlace(FileOf(cut)).empty());
  EXPECT_TRUE(DecodeBinaryNetpbm(BytesOf(cut), kMostPixels).gray.empty());
  EXPECT_TRUE(DecodeBinaryNetpbm(BytesOf("P6 1 1 255\nab"), kMostPixels).gray.empty());
  EXPECT_TRUE(DecodeBinaryNetpbm(BytesOf("P5 1 1 65535\na"), kMostPixels).gray.empty());
}

TEST(Netpbm, TheFirstOfSeveralImagesCounts) {
  const std::string several = "P5 3 2 255\nabcdefP5 3 2 255\nABCDEF";
  EXPECT_TRUE(AreEqual(PgmInPlace(FileOf(several)), kImage));
  EXPECT_TRUE(AreEqual(DecodeBinaryNetpbm(BytesOf(several), kMostPixels).gray, kImage));
}

TEST(Netpbm, OnlyGrayOf8BitsInFullRangeStaysInPlace) {
  for (const std::string header : {"P5 1 1 254\n", "P5 1 1 65535\n", "P6 1 1 255\n"})
    EXPECT_TRUE(PgmInPlace(FileOf(header + kPixels)).empty()) << header;
}

TEST(Netpbm, AnImageInPlaceOutlivesItsFile) {
  cv::Mat image;
  {
    const cv::Mat file = FileOf("P5 3 2 255\n" + kPixels);
    image = PgmInPlace(file);
    EXPECT_EQ(image.data, file.data + 11);
  }
  EXPECT_TRUE(AreEqual(image, kImage));
}

TEST(Netpbm, FiltersSeeNothingButTheImage) {
  const cv::Mat image = PgmInPlace(FileOf("P5 3 2 255\n" + kPixels + "and more bytes"));
  EXPECT_FALSE(image.isSubmatrix());
  cv::Mat in_place;
  cv::Mat copied;
  cv::copyMakeBorder(image, in_place, 2, 2, 2, 2, cv::BORDER_REFLECT_101);
  cv::copyMakeBorder(kImage, copied, 2, 2, 2, 2, cv::BORDER_REFLECT_101);
  EXPECT_TRUE(AreEqual(in_place, copied));
  cv::GaussianBlur(image, in_place, {3, 3}, 0);
  cv::GaussianBlur(kImage, copied, {3, 3}, 0);
  EXPECT_TRUE(AreEqual(in_place, copied));
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/image_file/jpeg_orientation.h"

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace turnscale {
namespace {

std::string NumberBytes(unsigned number, int size, bool big_endian) {
  std::string bytes;
  for (int i = 0; i < size; ++i) {
    const int shift = 8 * (big_endian ? size - 1 - i : i);
    bytes += static_cast<char>(number >> shift & 0xFF);
  }
  return bytes;
}

// APP1 with two entries, of which the second is the orientation, an unsigned short.
std::string ExifSegment(unsigned orientation, bool big_endian) {
  const auto number = [&](unsigned value, int size) { return NumberBytes(value, size, big_endian); };
  const std::string entries = number(0x0100, 2) + number(4, 2) + number(1, 4) + number(64, 4) + number(0x0112, 2) +
                              number(3, 2) + number(1, 4) + number(orientation, 2) + number(0, 2);
  const std::string tiff =
      (big_endian ? "MM" : "II") + number(42, 2) + number(8, 4) + number(2, 2) + entries + number(0, 4);
  const std::string content = std::string("Exif\0\0", 6) + tiff;
  return "\xFF\xE1" + NumberBytes(static_cast<unsigned>(content.size()) + 2, 2, true) + content;
}

std::vector<uint8_t> JpegOfPicture() {
  cv::Mat image(40, 56, CV_8UC1);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) image.at<uint8_t>(y, x) = static_cast<uint8_t>(3 * x + y);
  std::vector<uint8_t> bytes;
  EXPECT_TRUE(cv::imencode(".jpg", image, bytes));
  return bytes;
}

// Behind the start of the image, or behind its first segment, which is JFIF's.
std::vector<uint8_t> WithSegment(const std::string& segment, bool behind_jfif = false) {
  std::vector<uint8_t> bytes = JpegOfPicture();
  const std::ptrdiff_t place = behind_jfif ? 4 + (bytes[4] << 8 | bytes[5]) : 2;
  bytes.insert(bytes.begin() + place, segment.begin(), segment.end());
  return bytes;
}

TEST(JpegOrientation, BothByteOrdersAreRead) {
  for (const bool big_endian : {false, true})
    for (const bool behind_jfif : {false, true})
      for (int orientation = 1; orientation <= 8; ++orientation)
        EXPECT_EQ(
            JpegOrientation(WithSegment(ExifSegment(static_cast<unsigned>(orientation), big_endian), behind_jfif)),
            orientation);
}

TEST(JpegOrientation, WithoutOneTheImageIsUpright) {
  EXPECT_EQ(JpegOrientation({}), kUpright);
  EXPECT_EQ(JpegOrientation(JpegOfPicture()), kUpright);
  for (const unsigned orientation : {0U, 9U, 0xFFFFU})
    EXPECT_EQ(JpegOrientation(WithSegment(ExifSegment(orientation, true))), kUpright);
  std::vector<uint8_t> png;
  ASSERT_TRUE(cv::imencode(".png", cv::Mat(8, 8, CV_8UC1, cv::Scalar(7)), png));
  EXPECT_EQ(JpegOrientation(png), kUpright);
  const std::string xmp = std::string("\xFF\xE1\0\x10http:xmp test.", 18);
  EXPECT_EQ(JpegOrientation(WithSegment(xmp + ExifSegment(6, false))), 6) << "APP1 of XMP";
}

TEST(JpegOrientation, DamagedBytesAreHarmless) {
  for (const bool big_endian : {false, true}) {
    const std::string segment = ExifSegment(6, big_endian);
    const std::vector<uint8_t> whole = WithSegment(segment);
    for (size_t size = 0; size < segment.size() + 2; ++size) {
      // A copy of exactly this size, so that tools notice a byte read beyond it.
      const std::vector<uint8_t> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_EQ(JpegOrientation(cut), kUpright) << size;
    }
    std::mt19937 generator(5);
    for (int round = 0; round < 20'000; ++round) {
      std::vector<uint8_t> damaged(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(segment.size()) + 8);
      for (unsigned changes = 1 + generator() % 4; changes > 0; --changes)
        damaged[generator() % damaged.size()] = static_cast<uint8_t>(generator());
      const int orientation = JpegOrientation(damaged);
      ASSERT_GE(orientation, 1);
      ASSERT_LE(orientation, 8);
    }
  }
}

// OpenCV turns images as it reads them.
TEST(JpegOrientation, ImagesAreTurnedAsOpenCvTurnsThem) {
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const std::vector<uint8_t> bytes = WithSegment(ExifSegment(static_cast<unsigned>(orientation), true));
    const cv::Mat stored = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    const cv::Mat expected = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE);
    const cv::Mat turned = TurnedUpright(stored, orientation);
    ASSERT_EQ(turned.size(), expected.size()) << orientation;
    EXPECT_EQ(cv::norm(turned, expected, cv::NORM_INF), 0) << orientation;
  }
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/image_file/gray_png.h"

#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "turnscale/image_file/png_chunks.h"
#include "turnscale/image_file/test_png.h"

namespace turnscale {
namespace {

cv::Mat Noise(const cv::Size& size) {
  cv::Mat image(size, CV_8UC1);
  std::mt19937 generator(3);
  for (uint8_t& level : cv::Mat_<uint8_t>(image)) level = static_cast<uint8_t>(generator());
  return image;
}

// As the PNG specification defines the filters, byte by byte.
Bytes Filtered(const cv::Mat& image, const std::vector<int>& filters) {
  Bytes rows;
  const auto at = [&](int y, int x) -> int { return y < 0 || x < 0 ? 0 : image.at<uint8_t>(y, x); };
  for (int y = 0; y < image.rows; ++y) {
    const int filter = filters[static_cast<size_t>(y) % filters.size()];
    rows.push_back(static_cast<uint8_t>(filter));
    for (int x = 0; x < image.cols; ++x) {
      const int a = at(y, x - 1);
      const int b = at(y - 1, x);
      const int c = at(y - 1, x - 1);
      const int p = a + b - c;
      const int paeth = std::abs(p - a) <= std::abs(p - b) && std::abs(p - a) <= std::abs(p - c) ? a
                        : std::abs(p - b) <= std::abs(p - c)                                     ? b
                                                                                                 : c;
      const int predicted[] = {0, a, b, (a + b) / 2, paeth, 0};
      rows.push_back(static_cast<uint8_t>(image.at<uint8_t>(y, x) - predicted[filter]));
    }
  }
  return rows;
}

cv::Mat FastDecoded(const Bytes& png) { return DecodeGrayPng(PngChunks(png)); }

bool AreSame(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

TEST(GrayPng, UndoesEveryFilter) {
  for (const cv::Size& size : {cv::Size(37, 23), cv::Size(1, 5), cv::Size(8, 1)}) {
    const cv::Mat image = Noise(size);
    for (const std::vector<int>& filters : std::vector<std::vector<int>>{{0}, {1}, {2}, {3}, {4}, {4, 3, 2, 1, 0}}) {
      const Bytes png = Png({size.width, size.height}, Filtered(image, filters));
      EXPECT_TRUE(AreSame(FastDecoded(png), image)) << size << " filter " << filters[0];
      EXPECT_TRUE(AreSame(cv::imdecode(png, cv::IMREAD_UNCHANGED), image)) << "the test's own file";
    }
  }
}

TEST(GrayPng, LeavesOtherKindsToOthers) {
  cv::Mat gray = Noise({20, 10});
  Bytes png;
  for (const int type : {CV_16UC1, CV_8UC3, CV_8UC4}) {
    cv::imencode(".png", cv::Mat(10, 20, type, cv::Scalar::all(7)), png);
    EXPECT_TRUE(FastDecoded(png).empty()) << type;
  }
  EXPECT_TRUE(FastDecoded(Png({20, 10, 8, 0, 1}, Filtered(gray, {0}))).empty()) << "interlaced";
  EXPECT_TRUE(FastDecoded(Png({20, 10, 8, 3}, Filtered(gray, {0}), Bytes(768))).empty()) << "palette";
  EXPECT_TRUE(FastDecoded(Png({20, 10}, Filtered(gray, {0}), Bytes(768))).empty()) << "a chunk that it does not know";
}

TEST(GrayPng, LeavesDamageToOthers) {
  const cv::Mat gray = Noise({20, 10});
  const Bytes rows = Filtered(gray, {1});
  const Bytes png = Png({20, 10}, rows);
  ASSERT_TRUE(AreSame(FastDecoded(png), gray));
  for (size_t size = kPngSignature.size(); size < png.size(); ++size)
    EXPECT_TRUE(FastDecoded({png.begin(), png.begin() + static_cast<std::ptrdiff_t>(size)}).empty()) << size;
  for (size_t at = kPngSignature.size(); at < png.size(); ++at) {
    Bytes damaged = png;
    damaged[at] ^= 0x10;
    EXPECT_TRUE(FastDecoded(damaged).empty()) << at;
  }
  EXPECT_TRUE(FastDecoded(Png({20, 11}, rows)).empty()) << "a row is missing";
  EXPECT_TRUE(FastDecoded(Png({20, 9}, rows)).empty()) << "a row too many";
  EXPECT_TRUE(FastDecoded(Png({20, 10}, Filtered(gray, {5}))).empty()) << "no such filter";
  EXPECT_TRUE(FastDecoded(Png({0, 10}, rows)).empty()) << "no columns";
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/frames/seen_images.h"

#include <functional>
#include <string>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

// A drive of 6 s; `gray` of a pixel.
std::string Explanation(const std::function<int(int x, int y, int frame)>& gray, int tracked = 300, int frames = 60,
                        const LeftByOptions& left = {}) {
  SeenImages seen;
  for (int i = 0; i < frames; ++i) {
    cv::Mat image(96, 128, CV_8UC1);
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x) image.at<uint8_t>(y, x) = static_cast<uint8_t>(gray(x, y, i));
    seen.Add(image, 0.1 * i, i == 0 ? 0 : tracked);
  }
  return seen.Explanation(left);
}

int Moving(int x, int, int frame) { return 60 + 100 * ((x + 3 * frame) / 16 % 2); }

TEST(SeenImages, SaysWhatKeepsTheMapFromBeginning) {
  const std::string dark = Explanation([](int x, int y, int) { return (x + y) % 9; });
  EXPECT_EQ(dark.find("nothing could be tracked in 60 images (5.9 s): the images are dark"), 0u) << dark;
  EXPECT_NE(Explanation([](int x, int y, int) { return 120 + (x + y) % 3; }).find("hardly any detail"),
            std::string::npos);
  EXPECT_NE(Explanation([](int x, int y, int i) { return Moving(x, y, 0) + i % 2; }).find("as if the car stood still"),
            std::string::npos);
  EXPECT_NE(Explanation(Moving, 20).find("only about 20 points"), std::string::npos);
  EXPECT_NE(Explanation(Moving).find("do not move as they do from a car"), std::string::npos);
  EXPECT_NE(Explanation(Moving, 300, 8).find("too short"), std::string::npos);
}

TEST(SeenImages, NamesTheOptionThatLeavesTooLittle) {
  LeftByOptions left;
  left.part = "--start 1:30 --end 1:31";
  EXPECT_TRUE(Explanation(Moving, 300, 8, left)
                  .ends_with("the part of the drive (--start 1:30 --end 1:31) is too short; widen it"));
  EXPECT_EQ(Explanation(Moving, 300, 60, left).find("--start"), std::string::npos) << "that is long enough";
  left.mask = "--mask bonnet.png";
  left.mask_share = 0.5;
  EXPECT_EQ(Explanation(Moving, 20, 60, left).find("--mask"), std::string::npos);
  left.mask_share = 0.12;
  EXPECT_TRUE(Explanation(Moving, 20, 60, left)
                  .ends_with(": --mask bonnet.png leaves only 12 % of the image; leave out less of it"));
}

}  // namespace
}  // namespace turnscale

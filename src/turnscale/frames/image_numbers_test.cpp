// SPDX-License-Identifier: MIT
#include "turnscale/frames/image_numbers.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;
using Images = std::vector<fs::path>;

// img_0001.png and so on.
Images Numbered(int first, int last, int step = 1, const char* pattern = "img_{:04}.png") {
  Images images;
  for (int i = first; i <= last; i += step) images.push_back(fs::path("drive") / fmt::format(fmt::runtime(pattern), i));
  return images;
}

Images Together(Images images, const Images& more) {
  images.insert(images.end(), more.begin(), more.end());
  return images;
}

std::string NoticeOf(const Images& images, double fps = 10) {
  const auto numbers = ImageNumbers::Find(images);
  return numbers ? numbers->Notice(images, fps, 0, images.size()) : "no numbers";
}

std::string RefusalOf(const Images& images) {
  try {
    RefuseSeveralSeries("drive", images);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(ImageNumbers, CompleteNumbersGiveEvenTimes) {
  for (const Images& images : {Numbered(0, 20, 1, "{:06}.png"), Numbered(98, 112, 1, "{}.png"),
                               Numbered(1, 300, 1, "20230501_120000_{}.jpg"), Numbered(3, 40, 1, "cam0_{}_gray.png")}) {
    EXPECT_EQ(NoticeOf(images), "") << images.front();
    const std::vector<double> times = ImageNumbers::Find(images).value().TimesAt(8);
    ASSERT_EQ(times.size(), images.size());
    for (size_t i = 0; i < times.size(); ++i) EXPECT_EQ(times[i], static_cast<double>(i) / 8);
  }
}

TEST(ImageNumbers, MissingImagesTakeTimeAndAreNamed) {
  Images images = Together(Numbered(1, 400), Numbered(551, 1000));
  images.erase(images.begin() + 20);
  const std::vector<double> times = ImageNumbers::Find(images).value().TimesAt(10);
  EXPECT_EQ(times[0], 0);
  EXPECT_EQ(times[20], 2.1);
  EXPECT_EQ(times[399], 55.0);
  EXPECT_EQ(
      NoticeOf(images),
      "151 images are missing by the numbers of the names, 150 of them between img_0400.png and img_0551.png, and "
      "count as 15.1 s at --fps 10; give --timestamps FILE if no time has passed there");
  const auto numbers = ImageNumbers::Find(images);
  EXPECT_EQ(numbers->Notice(images, 10, 30, 200), "") << "none in this part of the drive";
  EXPECT_EQ(
      numbers->Notice(images, 10, 0, 200),
      "1 image is missing by the numbers of the names, 1 of them between img_0020.png and img_0022.png, and counts "
      "as 0.1 s at --fps 10; give --timestamps FILE if no time has passed there");
}

TEST(ImageNumbers, PickedImagesHaveTheGivenRate) {
  const Images images = Numbered(0, 100, 5);
  EXPECT_EQ(ImageNumbers::Find(images).value().TimesAt(10)[3], 0.3);
  EXPECT_EQ(
      NoticeOf(images),
      "the numbers of the image names increase by 5 (img_0000.png, img_0005.png); --fps 10 is taken as the rate of "
      "these images: if it is the rate of all numbers, give --fps 2");
  const Images gap = Together(images, Numbered(120, 200, 5));
  EXPECT_EQ(ImageNumbers::Find(gap).value().TimesAt(10)[21], 2.4);
  EXPECT_TRUE(
      NoticeOf(gap).starts_with("3 images are missing by the numbers of the names, 3 of them between "
                                "img_0100.png and img_0120.png, and count as 0.3 s"))
      << NoticeOf(gap);
  EXPECT_NE(NoticeOf(gap).find("; the numbers of the image names increase by 5"), std::string::npos);
}

TEST(ImageNumbers, OtherNamesAreNoCount) {
  const std::vector<Images> others = {
      {},
      {"1.png", "2.png"},
      {"a.png", "b.png", "c.png"},
      {"1403636579763555584.png", "1403636579813555456.png", "1403636579863555584.png"},
      {"1403636579.png", "1403636580.png", "1403636590.png"},
      {"20230501_115958.jpg", "20230501_115959.jpg", "20230501_120000.jpg"},
      {"20230501_120058.jpg", "20230501_120059.jpg", "20230501_120100.jpg"},
      {"99999999999999999999999.png", "99999999999999999999998.png", "99999999999999999999999.png"},
      {"0.png", "33.png", "67.png", "100.png"},
      {"0.png", "10.png", "17.png", "25.png"},
      {"1_1.png", "1_2.png", "2_1.png"},
      {"01.png", "1.png", "2.png"},
      {"1.jpg", "1.png", "2.png"},
      {"1.png", "2.png", "3.png", "overview.png"},
  };
  for (const Images& images : others) EXPECT_EQ(NoticeOf(images), "no numbers") << images.size();
}

TEST(ImageSeries, TwoCamerasInAFolderAreRefused) {
  EXPECT_EQ(RefusalOf(Together(Numbered(1, 20, 1, "left_{:04}.png"), Numbered(1, 30, 1, "right_{:04}.png"))),
            "drive: holds images of several cameras or drives, left_0001.png to left_0020.png (20 images) and "
            "right_0001.png to right_0030.png (30 images); give a folder with the images of one camera only");
  Images behind = Together(Numbered(1, 12, 1, "{:04}_l.png"), Numbered(1, 12, 1, "{:04}_r.png"));
  std::sort(behind.begin(), behind.end());
  EXPECT_NE(RefusalOf(behind).find("0001_l.png to 0012_l.png (12 images) and 0001_r.png to 0012_r.png"),
            std::string::npos)
      << RefusalOf(behind);
}

TEST(ImageSeries, SingleImagesAndArbitraryNamesAreNot) {
  EXPECT_EQ(RefusalOf({}), "");
  EXPECT_EQ(RefusalOf(Numbered(1, 100)), "");
  EXPECT_EQ(RefusalOf(Together(Numbered(1, 100), {"overview.png", "start.jpg"})), "");
  EXPECT_EQ(RefusalOf(Together(Numbered(1, 50, 1, "part1_{}.png"), Numbered(1, 50, 1, "part2_{}.png"))), "");
  Images arbitrary;
  for (unsigned i = 0; i < 3000; ++i) arbitrary.push_back(fmt::format("{:04x}.png", i * 40503U % 65536));
  EXPECT_EQ(RefusalOf(arbitrary), "");
}

TEST(ImageSeries, RepeatedNumbersAreNamed) {
  EXPECT_EQ(
      RepeatedNumbersNotice(Together(Numbered(1, 20, 1, "cam0_{:04}.png"), Numbered(1, 20, 1, "cam1_{:04}.png"))),
      "2 images have each number of the names (cam0_0001.png to cam1_0020.png), and all are read as one drive; if "
      "they are of several cameras, give a folder with the images of one camera only");
  Images behind = Together(Numbered(1, 12, 1, "{:04}_0.png"), Numbered(1, 12, 1, "{:04}_1.png"));
  std::sort(behind.begin(), behind.end());
  EXPECT_TRUE(RepeatedNumbersNotice(behind).starts_with("2 images have each number of the names"));
  EXPECT_EQ(RepeatedNumbersNotice({}), "");
  EXPECT_EQ(RepeatedNumbersNotice(Numbered(1, 100)), "");
  EXPECT_EQ(RepeatedNumbersNotice(Together(Numbered(1, 20, 1, "part1_{}.png"), Numbered(1, 15, 1, "part2_{}.png"))), "")
      << "parts of a drive";
  EXPECT_EQ(RepeatedNumbersNotice(Together(Numbered(1, 20), {"a.png"})), "");
}

}  // namespace
}  // namespace turnscale

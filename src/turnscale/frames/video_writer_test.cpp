// SPDX-License-Identifier: MIT
#include "turnscale/frames/video_writer.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/refused_field.h"
#include "turnscale/base/test_files.h"
#include "turnscale/frames/video_file.h"
#include "turnscale/io/output_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

const cv::Size kWrittenSize(128, 96);

// Smooth stripes over all gray levels, black and white among them, that move.
cv::Mat Stripes(int number) {
  cv::Mat image(kWrittenSize, CV_8UC1);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      image.at<uchar>(y, x) = cv::saturate_cast<uchar>(127.5 + 130 * std::sin(0.06 * (x + 2 * y + 5 * number)));
  return image;
}

class VideoWriterTest : public ::testing::Test {
 protected:
  VideoWriterTest() : folder_(ScratchPath("written")) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~VideoWriterTest() override { fs::remove_all(folder_); }

  fs::path Write(const std::string& name, const std::vector<double>& stamps,
                 const VideoWriterOptions& options = {}) const {
    VideoWriter writer(folder_ / name, kWrittenSize, options);
    for (size_t i = 0; i < stamps.size(); ++i) writer.Add(Stripes(static_cast<int>(i)), stamps[i]);
    writer.Finish();
    return folder_ / name;
  }

  fs::path folder_;
};

const std::vector<double> kUnevenStamps = {0, 0.0331, 0.0667, 0.1345, 0.2, 0.3003, 0.3335, 1.5, 1.50004, 2.71828};

TEST_F(VideoWriterTest, ImagesAndStampsReadBack) {
  for (const bool h264 : {true, false}) {
    const fs::path path = Write("v.mp4", kUnevenStamps, {.h264 = h264});
    VideoFile video(path);
    EXPECT_EQ(video.header().size, kWrittenSize);
    EXPECT_EQ(video.header().frames, static_cast<int>(kUnevenStamps.size()));
    EXPECT_EQ(video.header().tick, 1.0 / kVideoTicksPerSecond);
    for (size_t i = 0; i < kUnevenStamps.size(); ++i) {
      ASSERT_TRUE(video.Advance()) << i;
      ASSERT_TRUE(video.Stamp()) << i;
      EXPECT_EQ(*video.Stamp(), std::round(kUnevenStamps[i] * kVideoTicksPerSecond) / kVideoTicksPerSecond);
      const cv::Mat image = video.Gray();
      ASSERT_EQ(image.size(), kWrittenSize);
      const double error =
          cv::norm(image, Stripes(static_cast<int>(i)), cv::NORM_L1) / static_cast<double>(image.total());
      EXPECT_LT(error, 2.5) << i << " h264 " << h264;
      const double other =
          cv::norm(image, Stripes(static_cast<int>(i) + 1), cv::NORM_L1) / static_cast<double>(image.total());
      EXPECT_GT(other, 5 * error) << "the images are told apart";
    }
    EXPECT_FALSE(video.Advance());
  }
}

TEST_F(VideoWriterTest, KeyFramesComeAtTheirInterval) {
  std::vector<double> stamps;
  for (int i = 0; i < 25; ++i) stamps.push_back(i / 10.0);
  for (const bool h264 : {true, false}) {
    const fs::path path = Write("v.mp4", stamps, {.rate_hz = 10, .key_seconds = 1, .h264 = h264});
    const std::vector<FrameStamp> written = VideoFile::ReadStamps(path);
    ASSERT_EQ(written.size(), stamps.size());
    for (size_t i = 0; i < written.size(); ++i) EXPECT_EQ(written[i].key, i % 10 == 0) << i;
  }
}

TEST_F(VideoWriterTest, SameImagesGiveTheSameBytes) {
  const std::string first = TextOf(Write("first.mp4", kUnevenStamps));
  EXPECT_EQ(first == TextOf(Write("second.mp4", kUnevenStamps)), true);
  std::vector<double> later = kUnevenStamps;
  later.back() += 0.1;
  EXPECT_EQ(first == TextOf(Write("third.mp4", later)), false);
}

TEST_F(VideoWriterTest, BitRateIsKept) {
  std::vector<double> stamps;
  for (int i = 0; i < 120; ++i) stamps.push_back(i / 30.0);
  for (const bool h264 : {true, false}) {
    const auto kilobits = [&](double megabits) {
      VideoWriter writer(folder_ / "v.mp4", kWrittenSize, {.megabits_per_second = megabits, .h264 = h264});
      cv::RNG random(1);
      for (const double stamp : stamps) {
        cv::Mat noise(kWrittenSize, CV_8UC1);
        random.fill(noise, cv::RNG::UNIFORM, 0, 256);
        writer.Add(noise, stamp);
      }
      writer.Finish();
      return 8e-3 * static_cast<double>(fs::file_size(folder_ / "v.mp4")) / 4;
    };
    if (h264) {
      EXPECT_NEAR(kilobits(0.8), 800, 200);
      EXPECT_NEAR(kilobits(1.6), 1600, 400);
    } else {
      // Its rate control is slow to use what it may.
      EXPECT_LT(kilobits(0.8), 1000);
    }
  }
}

TEST_F(VideoWriterTest, UnfinishedVideosLeaveNothing) {
  {
    VideoWriter writer(folder_ / "v.mp4", kWrittenSize);
    writer.Add(Stripes(0), 0);
    EXPECT_TRUE(fs::exists(PartOf(folder_ / "v.mp4")));
  }
  EXPECT_TRUE(fs::is_empty(folder_));
  std::ofstream(folder_ / "v.mp4") << "an earlier one";
  {
    VideoWriter writer(folder_ / "v.mp4", kWrittenSize);
    writer.Add(Stripes(0), 0);
  }
  EXPECT_EQ(TextOf(folder_ / "v.mp4"), "an earlier one");
}

TEST_F(VideoWriterTest, WhatCannotBeWrittenIsRefused) {
  EXPECT_THROW(VideoWriter(folder_ / "v.mp4", {127, 96}), InputError);
  EXPECT_THROW(VideoWriter(folder_ / "v.mp4", {128, 95}), InputError);
  EXPECT_THROW(VideoWriter(folder_ / "v.mp4", {0, 0}), InputError);
  EXPECT_THROW(VideoWriter(folder_ / "none" / "v.mp4", kWrittenSize), InputError);
  EXPECT_TRUE(fs::is_empty(folder_));
  VideoWriter writer(folder_ / "v.mp4", kWrittenSize);
  writer.Add(Stripes(0), 1);
  EXPECT_THROW(writer.Add(Stripes(1), 1), InternalError);
  EXPECT_THROW(writer.Add(cv::Mat(96, 64, CV_8UC1), 2), InternalError);
}

TEST(VideoWriterOptions, ComplaintsNameTheField) {
  EXPECT_EQ(RefusedField<VideoWriterOptions>([](VideoWriterOptions&) {}), "");
  EXPECT_EQ(RefusedField<VideoWriterOptions>([](VideoWriterOptions& o) { o.rate_hz = 0; }), "video.rate_hz");
  EXPECT_EQ(RefusedField<VideoWriterOptions>([](VideoWriterOptions& o) { o.megabits_per_second = NAN; }),
            "video.megabits_per_second");
  EXPECT_EQ(RefusedField<VideoWriterOptions>([](VideoWriterOptions& o) { o.key_seconds = -1; }), "video.key_seconds");
}

}  // namespace
}  // namespace turnscale

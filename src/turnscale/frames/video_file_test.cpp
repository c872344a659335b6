// SPDX-License-Identifier: MIT
#include "turnscale/frames/video_file.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/frames/image_rotation.h"
#include "turnscale/frames/test_video.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr double kCodingError = 4;  // gray values

// A bright left half, brighter by frame, and a dark upper right quarter.
cv::Mat Image(int number) {
  cv::Mat image(48, 64, CV_8UC1, cv::Scalar(100));
  image(cv::Rect(0, 0, 32, 48)) = 150 + 5 * number;
  image(cv::Rect(32, 0, 32, 24)) = 20;
  return image;
}

std::vector<cv::Mat> Images(int count) {
  std::vector<cv::Mat> images;
  for (int i = 0; i < count; ++i) images.push_back(Image(i));
  return images;
}

class VideoFileTest : public ::testing::Test {
 protected:
  VideoFileTest() : folder_(ScratchPath("videos")) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~VideoFileTest() override { fs::remove_all(folder_); }

  fs::path Write(const std::string& name, const TestVideo& video = {}, int count = 12) const {
    WriteTestVideo(folder_ / name, Images(count), video);
    return folder_ / name;
  }

  std::string Complaint(const fs::path& path) const {
    try {
      VideoFile video(path);
      while (video.Advance()) {
      }
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

void ExpectNear(const cv::Mat& image, const cv::Mat& expected, const std::string& what) {
  ASSERT_EQ(image.type(), CV_8UC1) << what;
  ASSERT_EQ(image.size(), expected.size()) << what;
  EXPECT_LT(cv::norm(image, expected, cv::NORM_L1) / static_cast<double>(image.total()), kCodingError) << what;
}

TEST_F(VideoFileTest, VariableRateStampsOfContainers) {
  const std::vector<int64_t> ticks = {0, 40, 90, 100, 250, 255, 300, 333, 400, 450, 700, 710};  // ms
  // AVI has frame numbers only.
  for (const std::string name : {"v.mp4", "v.mkv", "v.mov", "v.ts"}) {
    for (const int b_frames : {0, 2}) {
      VideoFile video(Write(
          name, {.codec = name == "v.ts" ? "mpeg2video" : "mpeg4",
                 .ticks_per_second = name == "v.ts" ? 25 : 1000,
                 .stamps = name == "v.ts" ? std::vector<int64_t>{0, 1, 2, 5, 6, 9, 10, 14, 15, 16, 18, 20} : ticks,
                 .b_frames = b_frames}));
      std::vector<double> stamps;
      for (int i = 0; video.Advance(); ++i) {
        ASSERT_TRUE(video.Stamp().has_value()) << name;
        stamps.push_back(*video.Stamp());
        ExpectNear(video.Gray(), Image(i), name);
      }
      ASSERT_EQ(stamps.size(), ticks.size()) << name;
      const std::vector<int64_t> frames = {0, 1, 2, 5, 6, 9, 10, 14, 15, 16, 18, 20};
      for (size_t i = 0; i < stamps.size(); ++i) {
        const double expected =
            name == "v.ts" ? static_cast<double>(frames[i]) / 25 : static_cast<double>(ticks[i]) / 1000;
        EXPECT_NEAR(stamps[i] - stamps[0], expected, 1e-4) << name << " frame " << i;
      }
    }
  }
}

TEST_F(VideoFileTest, HeaderTellsSizeRateAndLength) {
  for (const std::string name : {"v.mp4", "v.mkv", "v.avi"}) {
    const VideoHeader header = VideoFile(Write(name, {.ticks_per_second = 20}, 40)).header();
    EXPECT_EQ(header.size, cv::Size(64, 48)) << name;
    EXPECT_DOUBLE_EQ(header.rate, 20) << name;
    EXPECT_EQ(header.frames, 40) << name;
    EXPECT_EQ(header.counted, name != "v.mkv") << name;
    EXPECT_NEAR(header.duration, 2, 0.06) << name;
    EXPECT_FALSE(header.created.has_value()) << name;
  }
  EXPECT_EQ(VideoFile(Write("c.mp4", {.created = "2023-05-01T12:00:00Z"})).header().created, 1682942400);
  EXPECT_EQ(CountVideoFrames(folder_ / "v.mkv"), 40);
}

TEST_F(VideoFileTest, FramesThatAnEditListHidesAreNotCounted) {
  for (const std::string name : {"v.mp4", "v.mov"}) {
    for (const int b_frames : {0, 2}) {
      TestVideo cut{.ticks_per_second = 10, .b_frames = b_frames};
      // Those before zero are hidden. The cut is between two key frames.
      for (int i = 0; i < 60; ++i) cut.stamps.push_back(i - 17);
      const fs::path path = Write(name, cut, 60);
      const VideoHeader header = VideoFile(path).header();
      EXPECT_EQ(header.frames, 43) << name << " " << b_frames;
      EXPECT_TRUE(header.counted);
      EXPECT_EQ(header.begin, 0);
      EXPECT_EQ(CountVideoFrames(path), 43) << name << " " << b_frames;
    }
  }
}

TEST_F(VideoFileTest, TheFirstOfSeveralTracksIsDecoded) {
  for (const std::string name : {"v.mp4", "v.mkv", "v.avi"}) {
    const std::vector<cv::Mat> small(12, cv::Mat(24, 32, CV_8UC1, cv::Scalar(77)));
    VideoFile video(Write(name, {.first_track = small}));
    EXPECT_EQ(video.header().size, cv::Size(32, 24)) << name;
    EXPECT_EQ(video.header().tracks, 2) << name;
    int count = 0;
    for (; video.Advance(); ++count) EXPECT_NEAR(video.Gray().at<uint8_t>(12, 16), 77, 2) << name;
    EXPECT_EQ(count, 12) << name;
  }
  EXPECT_EQ(VideoFile(Write("v.mp4")).header().tracks, 1);
  const VideoHeader thumbnail =
      VideoFile(Write("v.mp4", {.first_track = {cv::Mat(24, 32, CV_8UC1, cv::Scalar(77))}})).header();
  EXPECT_EQ(thumbnail.size, cv::Size(64, 48)) << "a track of one image";
  EXPECT_EQ(thumbnail.tracks, 1);
  EXPECT_EQ(CountVideoFrames(Write("v.mp4", {}, 1)), 1) << "nothing else";
}

TEST_F(VideoFileTest, BareStreamsHaveNoStampsAndPerhapsARate) {
  VideoFile video(Write("v.m2v", {.codec = "mpeg2video", .b_frames = 2}));
  EXPECT_DOUBLE_EQ(video.header().rate, 25);
  for (int i = 0; i < 12; ++i) {
    ASSERT_TRUE(video.Advance());
    EXPECT_FALSE(video.Stamp().has_value());
    ExpectNear(video.Gray(), Image(i), "m2v");
  }
  EXPECT_FALSE(video.Advance());
  // JPEG images one after another: no rate.
  EXPECT_EQ(VideoFile(Write("v.mjpeg", {.codec = "mjpeg"})).header().rate, 0);
}

TEST_F(VideoFileTest, RangesAndDepthsBecomeTheSameGray) {
  const TestVideo ways[] = {{.codec = "mpeg4"},
                            {.codec = "ffv1"},
                            {.codec = "ffv1", .bits = 10},
                            {.codec = "ffv1", .full_range = true},
                            {.codec = "ffv1", .bits = 10, .full_range = true},
                            {.codec = "mjpeg"}};
  for (const TestVideo& way : ways) {
    VideoFile video(Write("v.mkv", way));
    const std::string what =
        way.codec + " " + std::to_string(way.bits) + (way.full_range ? " bits, full range" : " bits");
    for (int i = 0; i < 12; ++i) {
      ASSERT_TRUE(video.Advance()) << what;
      ExpectNear(video.Gray(), Image(i), what);
    }
    EXPECT_FALSE(video.Advance()) << what;
  }
}

TEST_F(VideoFileTest, ColourBecomesLuma) {
  // Blue, green, red.
  const std::vector<std::pair<cv::Scalar, double>> colours = {
      {{255, 0, 0}, 29}, {{0, 255, 0}, 150}, {{0, 0, 255}, 76}, {{255, 255, 255}, 255}, {{0, 0, 0}, 0}};
  for (const auto& [colour, gray] : colours) {
    WriteTestVideo(folder_ / "v.mkv", {cv::Mat(48, 64, CV_8UC3, colour)}, {.codec = "ffv1"});
    VideoFile video(folder_ / "v.mkv");
    ASSERT_TRUE(video.Advance());
    EXPECT_NEAR(video.Gray().at<uint8_t>(20, 20), gray, 2) << colour;
  }
}

TEST_F(VideoFileTest, RotationAndMirrorOfTheMetadataAreApplied) {
  const int rotations[] = {-1, cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180, cv::ROTATE_90_COUNTERCLOCKWISE};
  for (int quarter_turns = 0; quarter_turns < 4; ++quarter_turns) {
    for (const bool mirrored : {false, true}) {
      cv::Mat expected = Image(0);
      if (quarter_turns > 0) cv::rotate(expected, expected, rotations[quarter_turns]);
      if (mirrored) cv::flip(expected, expected, 1);
      VideoFile video(Write("v.mp4", {.quarter_turns = quarter_turns, .mirrored = mirrored}));
      EXPECT_EQ(video.header().size, expected.size());
      const ReadDirection rotated = Rotated(ReadDirection(), 90 * quarter_turns);
      const ReadDirection read{mirrored ? -rotated.x : rotated.x, rotated.y};
      EXPECT_EQ(video.header().read_direction, read) << quarter_turns << mirrored;
      ASSERT_TRUE(video.Advance());
      ExpectNear(video.Gray(), expected, std::to_string(quarter_turns) + (mirrored ? " turns, mirrored" : " turns"));
    }
  }
}

TEST_F(VideoFileTest, HeaderHasTheShapeOfPixels) {
  EXPECT_EQ(VideoFile(Write("v.mp4", {})).header().pixel_aspect, 1);
  EXPECT_NEAR(VideoFile(Write("v.mp4", {.pixel_aspect = 1.5})).header().pixel_aspect, 1.5, 1e-9);
  const TestVideo sideways{.quarter_turns = 1, .pixel_aspect = 1.5};
  EXPECT_NEAR(VideoFile(Write("v.mp4", sideways)).header().pixel_aspect, 1 / 1.5, 1e-9);
  EXPECT_EQ(VideoFile(Write("v.mp4", {.pixel_aspect = 20})).header().pixel_aspect, 1) << "implausible";
}

TEST_F(VideoFileTest, InterlacedVideoIsRefused) {
  for (const std::string name : {"v.mp4", "v.mkv", "v.ts"}) {
    const std::string complaint = Complaint(Write(name, {.codec = "mpeg2video", .interlaced = true}));
    EXPECT_NE(complaint.find(name + ": is interlaced"), std::string::npos) << complaint;
    EXPECT_NE(complaint.find("ffmpeg -i IN -vf yadif OUT"), std::string::npos) << complaint;
    EXPECT_EQ(Complaint(Write(name, {.codec = "mpeg2video"})), "");
  }
}

TEST_F(VideoFileTest, FilesThatAreNoVideos) {
  EXPECT_NE(Complaint(folder_ / "nowhere.mp4")
                .find("nowhere.mp4: is not a video, or is damaged (a recording that was cut off"),
            std::string::npos);
  EXPECT_NE(Complaint(folder_).find("is not a video"), std::string::npos);
  const std::filesystem::path text = folder_ / "calib.txt";
  std::ofstream(text) << "P0: 707 0 602 0 0 707 183 0 0 0 1 0\n";
  const std::filesystem::path cut = Write("cut.mkv", {});
  std::filesystem::resize_file(cut, 400);
  EXPECT_EQ(Complaint(cut), cut.string() + ": is not a video, or is damaged");
  const std::filesystem::path empty = folder_ / "empty.mp4";
  std::ofstream(empty).close();
  EXPECT_EQ(Complaint(empty), empty.string() + ": is empty");
  EXPECT_NE(Complaint(text).find("calib.txt: is not a video, or is damaged"), std::string::npos);
}

TEST_F(VideoFileTest, ADamagedMiddleIsPassedOver) {
  const fs::path path = Write("v.ts", {.codec = "mpeg2video"}, 60);
  std::string bytes = TextOf(path);
  for (size_t i = bytes.size() / 3; i < bytes.size() / 3 + 300; ++i) bytes[i] = static_cast<char>(i * 31);
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_EQ(Complaint(path), "");
  EXPECT_GT(CountVideoFrames(path), 30);
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/report/thumbnails.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "turnscale/base/random.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

cv::Mat NoiseImage(int seed) {
  cv::Mat image(120, 400, CV_8UC1);
  for (int i = 0; i < 120 * 400; ++i) image.data[i] = static_cast<uchar>(Hash(seed * 100000 + i) & 0xFFU);
  return image;
}

FrameResult FrameAt(int number, TrackingState state = TrackingState::kTracked, double psi = 0) {
  FrameResult frame;
  frame.frame = number;
  frame.time = 0.1 * number;
  frame.state = state;
  frame.keyframe = true;
  frame.psi = psi;
  return frame;
}

class ThumbnailsTest : public ::testing::Test {
 protected:
  ThumbnailsTest() : odometry_({}, {}), folder_(ScratchPath("thumbnails")) {}
  ~ThumbnailsTest() override { fs::remove_all(folder_); }

  Odometry odometry_;
  fs::path folder_;
};

TEST_F(ThumbnailsTest, TurnsAndLossesHaveTheirOwn) {
  ThumbnailCollector collector;
  for (int i = 0; i < 100; ++i) {
    const TrackingState state = i >= 45 && i < 48 ? TrackingState::kBridged : TrackingState::kTracked;
    collector.Add(NoiseImage(i), FrameAt(i, state, i >= 63 && i < 69 ? 0.05 : 0.0), odometry_);
  }
  int lost = 0;
  int turns = 0;
  for (const Thumbnail& thumbnail : collector.thumbnails()) {
    lost += thumbnail.reason == ThumbnailReason::kLost ? 1 : 0;
    turns += thumbnail.reason == ThumbnailReason::kTurn ? 1 : 0;
    const int expected = thumbnail.reason == ThumbnailReason::kLost   ? 45
                         : thumbnail.reason == ThumbnailReason::kTurn ? 63
                                                                      : thumbnail.frame;
    EXPECT_EQ(thumbnail.frame, expected);
    const std::vector<uchar> bytes(thumbnail.jpeg.begin(), thumbnail.jpeg.end());
    EXPECT_EQ(cv::imdecode(bytes, cv::IMREAD_COLOR).cols, 400);
  }
  EXPECT_EQ(lost, 1);
  EXPECT_EQ(turns, 1);
  EXPECT_NEAR(static_cast<double>(collector.thumbnails().size()), 12, 2);
}

TEST_F(ThumbnailsTest, EachLossHasOne) {
  ThumbnailCollector collector;
  std::vector<int> lost;
  for (int i = 0; i < 100; ++i) {
    const bool is_lost = i == 30 || i == 31 || i == 50 || i == 80;
    collector.Add(NoiseImage(i), FrameAt(i, is_lost ? TrackingState::kBridged : TrackingState::kTracked), odometry_);
  }
  for (const Thumbnail& thumbnail : collector.thumbnails())
    if (thumbnail.reason == ThumbnailReason::kLost) lost.push_back(thumbnail.frame);
  EXPECT_EQ(lost, (std::vector<int>{30, 50, 80}));
}

TEST_F(ThumbnailsTest, ALongDriveStaysWithinTheBudget) {
  ThumbnailOptions options;
  options.width = 320;
  options.budget = 300'000;
  ThumbnailCollector collector(options);
  const cv::Mat image = NoiseImage(1);
  for (int i = 0; i < 5000; ++i) collector.Add(image, FrameAt(i), odometry_);
  size_t bytes = 0;
  for (const Thumbnail& thumbnail : collector.thumbnails()) bytes += thumbnail.jpeg.size();
  EXPECT_LE(bytes, options.budget);
  EXPECT_GT(bytes, options.budget / 4);
  // From one end of the drive to the other.
  EXPECT_LT(collector.thumbnails().front().frame, 500);
  EXPECT_GT(collector.thumbnails().back().frame, 4500);
}

TEST_F(ThumbnailsTest, ATinyBudgetKeepsOneOfEachKind) {
  ThumbnailOptions options;
  options.budget = 100;  // less than one
  ThumbnailCollector collector(options);
  for (int i = 0; i < 300; ++i) {
    const TrackingState state = i == 45 ? TrackingState::kBridged : TrackingState::kTracked;
    collector.Add(NoiseImage(i), FrameAt(i, state, i >= 63 && i < 69 ? 0.05 : 0.0), odometry_);
  }
  std::vector<ThumbnailReason> kinds;
  for (const Thumbnail& thumbnail : collector.thumbnails()) kinds.push_back(thumbnail.reason);
  std::sort(kinds.begin(), kinds.end());
  EXPECT_EQ(kinds,
            (std::vector<ThumbnailReason>{ThumbnailReason::kDrive, ThumbnailReason::kTurn, ThumbnailReason::kLost}));
}

TEST_F(ThumbnailsTest, FilesReplaceThoseOfAnEarlierRun) {
  std::vector<FrameResult> frames;
  for (int i = 0; i < 20; ++i) frames.push_back(FrameAt(i));
  fs::create_directories(folder_);
  WriteThumbnails(folder_, {{3, 0.3, ThumbnailReason::kTurn, "abc"}, {12, 1.2, ThumbnailReason::kLost, "d"}});
  std::ofstream(folder_ / "thumbnails" / "mine.jpg") << "kept";
  const std::vector<Thumbnail> read = ReadThumbnails(folder_, frames);
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].reason, ThumbnailReason::kTurn);
  EXPECT_EQ(read[1].frame, 12);
  EXPECT_NEAR(read[1].time, 1.2, 1e-12);
  EXPECT_EQ(read[0].jpeg, "abc");
  WriteThumbnails(folder_, {});
  EXPECT_TRUE(ReadThumbnails(folder_, frames).empty());
  EXPECT_TRUE(fs::exists(folder_ / "thumbnails" / "mine.jpg"));
}

TEST_F(ThumbnailsTest, AreReadInTheOrderOfTheFrames) {
  fs::create_directories(folder_ / "thumbnails");
  // Beyond 999999 frames numbers have more digits.
  for (const char* name : {"000010-turn.jpg", "2-drive.jpg", "000003-drive.jpg"})
    std::ofstream(folder_ / "thumbnails" / name) << name;
  std::vector<int> numbers;
  for (const Thumbnail& thumbnail : ReadThumbnails(folder_, std::vector<FrameResult>(20)))
    numbers.push_back(thumbnail.frame);
  EXPECT_EQ(numbers, (std::vector{2, 3, 10}));
}

// The bytes of a comment of a JPEG file, behind its name; they end where the picture does not need them.
std::string CommentOf(const std::string& jpeg, const std::string& name) {
  const auto byte = [&](size_t place) -> size_t { return static_cast<unsigned char>(jpeg.at(place)); };
  for (size_t place = 2; byte(place) == 0xFF && byte(place + 1) != 0xDA;
       place += 2 + (byte(place + 2) << 8) + byte(place + 3)) {
    const std::string bytes = jpeg.substr(place + 4, (byte(place + 2) << 8) + byte(place + 3) - 2);
    if (byte(place + 1) == 0xFE && bytes.rfind(name + '\0', 0) == 0) return bytes.substr(name.size() + 1);
  }
  return "";
}

TEST_F(ThumbnailsTest, CommentsTellFeaturesAndMask) {
  const cv::Mat gray = NoiseImage(1);
  cv::Mat mask(120, 400, CV_8UC1, cv::Scalar(255));
  mask.rowRange(90, 120) = 0;
  const std::vector<DrawnFeature> features = {{{0, 0}, true}, {{399, 119}, false}, {{100, 30}, true}};
  const std::string jpeg = AnnotatedJpeg(gray, features, mask, 200, 60);
  const cv::Mat image = cv::imdecode(std::vector<uchar>(jpeg.begin(), jpeg.end()), cv::IMREAD_COLOR);
  EXPECT_EQ(image.size(), cv::Size(200, 60));
  std::vector<cv::Mat> channels;
  cv::split(image, channels);
  for (const int i : {1, 2})
    EXPECT_EQ(cv::norm(channels[0], channels[i], cv::NORM_INF), 0) << "nothing is drawn into it";
  EXPECT_EQ(jpeg.substr(6, 4), "JFIF") << "the header stays the first segment";
  const std::string points = CommentOf(jpeg, "turnscale features");
  ASSERT_EQ(points.size(), 9u);
  const auto byte = [](const std::string& bytes, size_t place) {
    return static_cast<int>(static_cast<unsigned char>(bytes[place]));
  };
  const auto bits = [&](const std::string& bytes, size_t at) {
    return byte(bytes, at) << 16 | byte(bytes, at + 1) << 8 | byte(bytes, at + 2);
  };
  EXPECT_EQ(bits(points, 0), 1);
  EXPECT_EQ(bits(points, 3), 0xFFFFFE);
  EXPECT_NEAR((bits(points, 6) >> 12) / 4095.0, 100 / 399.0, 1e-3);
  EXPECT_NEAR((bits(points, 6) >> 1 & 0x7FF) / 2047.0, 30 / 119.0, 1e-3);
  EXPECT_EQ(bits(points, 6) & 1, 1);
  const std::string contour = CommentOf(jpeg, "turnscale mask");
  ASSERT_EQ(contour.size(), 2u + 4 * 3) << "a rectangle";
  EXPECT_EQ(byte(contour, 1), 4);
  for (size_t at = 2; at < contour.size(); at += 3) EXPECT_GE((bits(contour, at) >> 1 & 0x7FF) / 2047.0, 0.74);
  EXPECT_EQ(AnnotatedJpeg(gray, {}, {}, 200, 60).find("turnscale"), std::string::npos);
}

TEST_F(ThumbnailsTest, LeftOutPixelsAreTinted) {
  const cv::Mat gray(100, 200, CV_8UC1, cv::Scalar(120));
  cv::Mat mask(100, 200, CV_8UC1, cv::Scalar(255));
  mask.rowRange(50, 100) = 0;
  const cv::Mat drawn = DrawTracking(gray, {{{100, 20}, true}}, mask, 200);
  EXPECT_EQ(drawn.at<cv::Vec3b>(40, 20), cv::Vec3b(120, 120, 120));
  EXPECT_GT(drawn.at<cv::Vec3b>(80, 20)[2], drawn.at<cv::Vec3b>(80, 20)[0] + 40);
  EXPECT_NE(drawn.at<cv::Vec3b>(20, 100), cv::Vec3b(120, 120, 120));
}

}  // namespace
}  // namespace turnscale

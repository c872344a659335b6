// SPDX-License-Identifier: MIT
#include "turnscale/frames/clip_overlap.h"

#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "turnscale/frames/test_video.h"

namespace turnscale {
namespace {

constexpr double kInterval = 0.1;  // s

ClipTail TailOf(const std::vector<cv::Mat>& images) {
  ClipTail tail;
  for (size_t i = 0; i < images.size(); ++i) tail.Add({kInterval * static_cast<double>(i), images[i]});
  return tail;
}

std::optional<double> Repeated(const ClipTail& tail, const std::vector<cv::Mat>& next) {
  size_t read = 0;
  return tail.RepeatedBy([&]() -> std::optional<ClipImage> {
    if (read == next.size()) return std::nullopt;
    const double time = 100 + kInterval * static_cast<double>(read);
    return ClipImage{time, next[read++]};
  });
}

// As a second compression changes them.
std::vector<cv::Mat> Noisy(std::vector<cv::Mat> images) {
  cv::RNG random(1);
  for (cv::Mat& image : images) {
    cv::Mat noise(image.size(), CV_16SC1);
    random.fill(noise, cv::RNG::UNIFORM, -6, 7);
    cv::add(image, noise, image, cv::noArray(), CV_8U);
  }
  return images;
}

TEST(ClipTail, FindsImagesThatAreRepeated) {
  const ClipTail tail = TailOf(MovingTestImages(0, 40));
  EXPECT_TRUE(tail.IsMoving());
  EXPECT_NEAR(Repeated(tail, Noisy(MovingTestImages(30, 40))).value(), 3, 1e-9);
}

TEST(ClipTail, LooksNoFurtherBackThanTheLongestOverlap) {
  const ClipTail tail = TailOf(MovingTestImages(0, 100));
  EXPECT_TRUE(Repeated(tail, MovingTestImages(50, 60)));
  EXPECT_FALSE(Repeated(tail, MovingTestImages(40, 70)));
}

TEST(ClipTail, SaysNothingOfAClipThatContinues) {
  const ClipTail tail = TailOf(MovingTestImages(0, 40));
  EXPECT_FALSE(Repeated(tail, Noisy(MovingTestImages(40, 20))));
  EXPECT_FALSE(Repeated(tail, Noisy(MovingTestImages(43, 20)))) << "after a gap";
  EXPECT_FALSE(Repeated(tail, {}));
  EXPECT_FALSE(Repeated({}, MovingTestImages(0, 20)));
}

TEST(ClipTail, SaysNothingWhileTheCarStands) {
  const std::vector<cv::Mat> still(40, MovingTestImages(0, 1).front());
  EXPECT_FALSE(Repeated(TailOf(Noisy(still)), still));
  EXPECT_FALSE(TailOf(Noisy(still)).IsMoving());
  EXPECT_FALSE(ClipTail().IsMoving());
}

TEST(ClipTail, SeesMissingImages) {
  const ClipTail tail = TailOf(Noisy(MovingTestImages(0, 40)));
  EXPECT_FALSE(tail.JumpsTo(Noisy(MovingTestImages(40, 1)).front()));
  EXPECT_TRUE(tail.JumpsTo(Noisy(MovingTestImages(45, 1)).front()));
  const std::vector<cv::Mat> still(40, MovingTestImages(0, 1).front());
  EXPECT_FALSE(TailOf(Noisy(still)).JumpsTo(still.front()));
  cv::Mat brighter;
  still.front().convertTo(brighter, CV_8U, 1.1, 5);
  EXPECT_FALSE(TailOf(Noisy(still)).JumpsTo(brighter)) << "another exposure";
  MovingTestImages(40, 1).front().convertTo(brighter, CV_8U, 0.8, 10);
  EXPECT_FALSE(tail.JumpsTo(brighter));
  EXPECT_FALSE(tail.JumpsTo(MovingTestImages(38, 1).front())) << "repeats an image";
  EXPECT_FALSE(TailOf(MovingTestImages(0, 5)).JumpsTo(MovingTestImages(50, 1).front())) << "too short to tell";
  EXPECT_FALSE(ClipTail().JumpsTo(still.front()));
}

TEST(ClipTail, MissingImagesThatAreLikelyAreSeenEarlier) {
  const ClipTail tail = TailOf(MovingTestImages(0, 40));
  EXPECT_FALSE(tail.JumpsTo(MovingTestImages(40, 1).front(), true));
  int seen = 0;
  int seen_if_likely = 0;
  for (int image = 41; image < 60; ++image) {
    const cv::Mat first = MovingTestImages(image, 1).front();
    const bool jumps = tail.JumpsTo(first);
    const bool jumps_if_likely = tail.JumpsTo(first, true);
    EXPECT_TRUE(jumps_if_likely || !jumps) << image;
    seen += jumps ? 1 : 0;
    seen_if_likely += jumps_if_likely ? 1 : 0;
  }
  EXPECT_GE(seen_if_likely, seen);
  EXPECT_TRUE(tail.JumpsTo(MovingTestImages(20, 1).front(), true)) << "no image is repeated across a gap";
}

TEST(ClipTail, AFewLostImagesAreNoGapAtAHighRate) {
  ClipTail tail;
  const std::vector<cv::Mat> images = MovingTestImages(0, 90);
  for (size_t i = 0; i < images.size(); ++i) tail.Add({static_cast<double>(i) / 30, images[i]});
  EXPECT_FALSE(tail.JumpsTo(MovingTestImages(92, 1).front()));
}

TEST(ClipTail, AllOfTheTailHasToBeRepeated) {
  const ClipTail tail = TailOf(MovingTestImages(0, 40));
  std::vector<cv::Mat> next = MovingTestImages(30, 5);
  EXPECT_FALSE(Repeated(tail, next)) << "ends before the tail";
  for (const cv::Mat& image : MovingTestImages(70, 20)) next.push_back(image);
  EXPECT_FALSE(Repeated(tail, next)) << "goes on elsewhere";
}

}  // namespace
}  // namespace turnscale

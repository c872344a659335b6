// SPDX-License-Identifier: MIT
#include "turnscale/run/missing_path.h"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

// 10 frames a second: t tracked, b bridged, u unreadable, r repeated, i before the map; a dash leaves out 2 s.
std::vector<FrameResult> Frames(std::string_view states) {
  std::vector<FrameResult> frames;
  double time = 0;
  for (const char state : states) {
    if (state == '-') {
      time += 2;
      continue;
    }
    FrameResult frame;
    frame.time = time;
    frame.state = state == 't'   ? TrackingState::kTracked
                  : state == 'b' ? TrackingState::kBridged
                  : state == 'u' ? TrackingState::kUnreadable
                  : state == 'r' ? TrackingState::kRepeated
                                 : TrackingState::kInitializing;
    if (state != 'i') frame.world_from_camera = RigidTransform();
    frames.push_back(frame);
    time += 0.1;
  }
  return frames;
}

TEST(MissingPath, NothingIsMissing) {
  EXPECT_TRUE(FindMissingParts(Frames("")).empty());
  EXPECT_TRUE(FindMissingParts(Frames("tttrrtt")).empty());
}

TEST(MissingPath, PartsBeforeTheMapWithinAndAtTheEnd) {
  const auto parts = FindMissingParts(Frames("iiitttbburbtttbb"));
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(MissingPartText(parts[0]), "before initialisation from 0.0 s to 0.3 s (3 frames)");
  EXPECT_EQ(MissingPartText(parts[1]), "tracking lost from 0.6 s to 1.1 s (5 frames)");
  EXPECT_EQ(MissingPartText(parts[2]), "tracking lost from 1.4 s to 1.5 s (2 frames)");
  EXPECT_NEAR(TotalSeconds(parts), 0.9, 1e-9);
}

TEST(MissingPath, ImagesThatCannotBeReadAreNoLossOfTracking) {
  EXPECT_EQ(MissingPartText(FindMissingParts(Frames("tturut"))[0]), "images unreadable from 0.2 s to 0.5 s (3 frames)");
  EXPECT_EQ(FindMissingParts(Frames("ttubut"))[0].reason, MissingReason::kLost);
  EXPECT_EQ(FindMissingParts(Frames("ttt-rrt"))[1].reason, MissingReason::kLost) << "all images could be read";
}

TEST(MissingPath, APauseOfTheRecorderIsNotTakenForLostTracking) {
  const auto tracked = FindMissingParts(Frames("ttt-ttt"));
  ASSERT_EQ(tracked.size(), 1u);
  EXPECT_EQ(MissingPartText(tracked[0]), "not recorded from 0.3 s to 2.3 s");
  EXPECT_NEAR(TotalSeconds(tracked), 2, 1e-9) << "as long as the gap";
  const auto lost = FindMissingParts(Frames("ttt-bbt"));
  ASSERT_EQ(lost.size(), 2u);
  EXPECT_EQ(MissingPartText(lost[0]), "not recorded from 0.3 s to 2.3 s");
  EXPECT_EQ(MissingPartText(lost[1]), "tracking lost from 2.3 s to 2.5 s (2 frames)");
  const auto before = FindMissingParts(Frames("tbb-bt"));
  ASSERT_EQ(before.size(), 3u);
  EXPECT_EQ(MissingPartText(before[0]), "tracking lost from 0.1 s to 0.2 s (2 frames)");
  EXPECT_EQ(MissingPartText(before[1]), "not recorded from 0.3 s to 2.3 s");
  EXPECT_EQ(MissingPartText(before[2]), "tracking lost from 2.3 s to 2.4 s (1 frame)");
}

TEST(MissingPath, StepsIntoAndAcrossAPartAreInIt) {
  const auto frames = Frames("ttbbt-tt");
  const auto parts = FindMissingParts(frames);
  const auto is_missing = [&](int i) { return IsMissing(parts, frames[i].time, frames[i + 1].time); };
  for (int i = 0; i + 1 < static_cast<int>(frames.size()); ++i) EXPECT_EQ(is_missing(i), i >= 2 && i <= 4) << i;
}

TEST(MissingPath, UnreadableImagesAndPausesBeforeTheMapArePartsOfTheSameBeginning) {
  for (const char* states : {"iiiut", "uuuut", "uiiit"}) {
    const auto parts = FindMissingParts(Frames(states));
    ASSERT_EQ(parts.size(), 1u) << states;
    EXPECT_EQ(MissingPartText(parts[0]), "before initialisation from 0.0 s to 0.4 s (4 frames)") << states;
  }
  EXPECT_EQ(FindMissingParts(Frames("tiit"))[0].reason, MissingReason::kLost) << "a new map begins";
  const auto before = [](std::string_view states) {
    const std::optional<MissingPart> part = PartBeforeMap(Frames(states));
    return part ? MissingPartText(*part) : "";
  };
  EXPECT_EQ(before("uii-iutbt"), "before initialisation from 0.0 s to 2.5 s (5 frames)");
  EXPECT_EQ(before("iii-t"), "before initialisation from 0.0 s to 2.3 s (3 frames)");
  EXPECT_EQ(before("iiit-t"), "before initialisation from 0.0 s to 0.3 s (3 frames)") << "the pause follows";
  EXPECT_EQ(before("tuut"), "");
  EXPECT_EQ(before("iii"), "") << "no map at all";
}

TEST(MissingPath, ALateBeginningIsLongAndNoSmallPartOfTheDrive) {
  const auto is_late = [](int initializing, int tracked, double least_share) {
    const auto frames = Frames(std::string(initializing, 'i') + std::string(tracked, 't'));
    return IsLate(PartBeforeMap(frames).value(), frames, least_share);
  };
  EXPECT_FALSE(is_late(19, 20, 0));
  EXPECT_FALSE(is_late(25, 40, 0.5));
  EXPECT_TRUE(is_late(25, 40, 0.3));
}

TEST(MissingPath, ACarThatWaitsIsNoFault) {
  const auto text = [](int step) {
    SeenImages seen;
    for (int i = 0; i < 40; ++i) {
      cv::Mat image(96, 128, CV_8UC1);
      for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x) image.at<uint8_t>(y, x) = (x + step * i) / 16 % 2 == 0 ? 60 : 160;
      seen.Add(image, 0.1 * i, 300);
    }
    return LateBeginningText({MissingReason::kNotBegun, 0, 4, 40}, 100, seen);
  };
  EXPECT_EQ(text(0), "");
  EXPECT_EQ(text(3).find("no map could be started before 4.0 s (40 of 100 frames): the points"), 0u) << text(3);
  EXPECT_EQ(LateBeginningText({MissingReason::kNotBegun, 0, 4, 40}, 100, {}),
            "no map could be started before 4.0 s (40 of 100 frames)")
      << "no image could be read";
  SeenImages one;
  one.Add(cv::Mat(96, 128, CV_8UC1, cv::Scalar(120)), 0, 0);
  EXPECT_EQ(LateBeginningText({MissingReason::kNotBegun, 0, 4, 40}, 100, one).find("the drive is too short"),
            std::string::npos);
}

TEST(MissingPath, TheLengthBeforeTheMapIsThatAtTheFirstSpeed) {
  auto frames = Frames(std::string(30, 'i') + std::string(20, 't'));
  for (size_t i = 30; i < frames.size(); ++i)
    frames[i].world_from_camera = RigidTransform{Eigen::Quaterniond::Identity(), {0, 0, 0.8 * static_cast<double>(i)}};
  EXPECT_NEAR(LengthBefore(FindMissingParts(frames).front(), frames), 24, 1e-9);
  frames.resize(31);
  EXPECT_EQ(LengthBefore({MissingReason::kNotBegun, 0, 3, 30}, frames), 0) << "no speed";
}

TEST(MissingPath, TheLongestInTheOrderOfTime) {
  const auto parts = LongestParts(FindMissingParts(Frames("tbtbbbtbbtbtt")), 2);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].frames, 3);
  EXPECT_EQ(parts[1].frames, 2);
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/frames/clip_names.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace turnscale {
namespace {

TEST(ClipNames, ChaptersOfGoPro) {
  for (const char* name : {"GX020123", "GH020123", "GL020123", "GP020123", "gx020123"}) {
    const auto chapter = ChapterInName(name);
    ASSERT_TRUE(chapter.has_value()) << name;
    EXPECT_EQ(chapter->recording, 123) << name;
    EXPECT_EQ(chapter->number, 2) << name;
  }
  const auto first = ChapterInName("GOPR0123");
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->recording, 123);
  EXPECT_EQ(first->number, 0);
  for (const char* name : {"", "GX02012", "GX0201234", "GX02012a", "GA020123", "GOPR012a", "XX020123", "20230501"})
    EXPECT_FALSE(ChapterInName(name).has_value()) << name;
}

TEST(ClipNames, ChaptersOfARecordingStandTogether) {
  const std::vector<std::string> sorted = {"2.mp4",        "10.mp4",       "GH010009.MP4", "GP010009.MP4",
                                           "GX020009.MP4", "GOPR0012.MP4", "GP010012.MP4", "GP100012.MP4",
                                           "GX010123.MP4", "GX020123.MP4", "GX015.MP4",    "drive.mp4"};
  for (size_t i = 0; i < sorted.size(); ++i)
    for (size_t k = 0; k < sorted.size(); ++k)
      EXPECT_EQ(ClipNameLess(sorted[i], sorted[k]), i < k) << sorted[i] << " " << sorted[k];
}

}  // namespace
}  // namespace turnscale

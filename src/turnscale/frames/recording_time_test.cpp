// SPDX-License-Identifier: MIT
#include "turnscale/frames/recording_time.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

constexpr double kMayNoon = 1682942400;  // 2023-05-01 12:00:00

VideoHeader Header(double duration, std::optional<double> created = {}) {
  VideoHeader header;
  header.duration = duration;
  header.created = created;
  return header;
}

std::string Complaint(const RecordingTimes& times) {
  try {
    times.CheckContinuity();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(TimeInName, CommonFormats) {
  for (const char* name : {"20230501_120000", "20230501120000", "2023_0501_120000_0042F", "2023-05-01_12-00-00",
                           "2023-05-01T12:00:00", "NO20230501-120000-000042F", "VID_20230501_120000123"}) {
    EXPECT_EQ(TimeInName(name), kMayNoon) << name;
  }
}

TEST(TimeInName, OtherNumbersAreNoTimes) {
  for (const char* name : {"", "drive", "GOPR0042", "20230501", "20230501_1200", "20231301_120000", "20230231_120000",
                           "20230501_240000", "18990501_120000", "120230501_120000", "2023__0501_120000"}) {
    EXPECT_FALSE(TimeInName(name).has_value()) << name;
  }
}

TEST(ShortTimeInName, DateAndTimeAreApart) {
  for (const char* name : {"230501_120000", "FILE230501-120000F", "REC_23-05-01_12-00-00_0042", "23.05.01 12.00.00"})
    EXPECT_EQ(ShortTimeInName(name), kMayNoon) << name;
  for (const char* name :
       {"230501120000", "230501_1200", "23-05-01_12-00", "23-05-01_12-00_00", "23_0501_120000", "231301_120000",
        "010523_250000", "230501_1200001", "20230501_120000", "201203220714", "20120322_071405", "0000230501_120000"})
    EXPECT_FALSE(ShortTimeInName(name).has_value()) << name;
  EXPECT_FALSE(TimeInName("230501_120000").has_value());
}

TEST(RecordingTimes, YearsOfTwoDigitsCountWhereTheClipsFollowOneAnother) {
  const RecordingTimes times({"230501_235900.mp4", "230502_000002.mp4"}, {Header(60), Header(60)});
  EXPECT_TRUE(times.AreInNames());
  EXPECT_EQ(Complaint(times), "");
  EXPECT_DOUBLE_EQ(times.GapAfter(0, 60), 2);
  // A count of clips, day before month before year, another drive, and one name without a time.
  for (const char* second : {"230501_235901.mp4", "240501_000002.mp4", "230502_010002.mp4", "b.mp4"}) {
    const std::vector<std::filesystem::path> clips = {"230501_235900.mp4", second};
    const RecordingTimes unknown(clips, {Header(60), Header(60)});
    EXPECT_FALSE(unknown.AreInNames()) << second;
    EXPECT_FALSE(unknown.AreKnown()) << second;
    EXPECT_EQ(Complaint(unknown), "") << second;
    const RecordingTimes created(clips, {Header(60, kMayNoon), Header(60, kMayNoon + 100)});
    EXPECT_DOUBLE_EQ(created.GapAfter(0, 60), 40) << second;
    EXPECT_EQ(created.WhyNotByNames(), "") << second;
  }
}

TEST(RecordingTimes, TimesInNamesThatAreNotUsedAreNamed) {
  const auto why = [](const std::string& first, const std::string& second) {
    return RecordingTimes({first, second}, {Header(60), Header(60)}).WhyNotByNames();
  };
  EXPECT_EQ(why("230501_120000.mp4", "230501_120100.mp4"), "");
  EXPECT_EQ(why("20230501_120000.mp4", "20230501_120100.mp4"), "");
  EXPECT_EQ(why("a.mp4", "b.mp4"), "");
  const std::string question = ": are the clips of one drive and one camera, in their order?";
  EXPECT_EQ(why("d/230501_120000F.mp4", "d/230501_120000R.mp4"),
            "the times in the names of the clips are not used, as 230501_120000R.mp4 begins 60.0 s before "
            "230501_120000F.mp4 ends by them" +
                question);
  EXPECT_EQ(why("230501_120000.mp4", "230501_130100.mp4"),
            "the times in the names of the clips are not used, as 230501_130100.mp4 begins 60 minutes after "
            "230501_120000.mp4 ends by them" +
                question);
  EXPECT_EQ(why("20230501_120000.mp4", "b.mp4"), "the times in the names of the clips are not used, as b.mp4 has none");
}

TEST(RecorderTimeText, IsThatOfTheName) {
  EXPECT_EQ(RecorderTimeText(kMayNoon), "2023-05-01T12:00:00");
  EXPECT_EQ(RecorderTimeText(kMayNoon + 86399.9 - 12 * 3600), "2023-05-01T23:59:59");
}

TEST(RecordingTimes, TheFirstNameTellsWhenTheDriveBegins) {
  EXPECT_EQ(RecordingTimes({"20230501_120000.mp4"}, {Header(60)}).Begin(), kMayNoon);
  EXPECT_EQ(RecordingTimes({"230501_120000.mp4", "230501_120100.mp4"}, {Header(60), Header(60)}).Begin(), kMayNoon);
  EXPECT_FALSE(RecordingTimes({"a.mp4"}, {Header(60, kMayNoon)}).Begin().has_value()) << "it may be that of the end";
}

TEST(RecordingTimes, APauseThatRoundingDoesNotExplainIsLikely) {
  const RecordingTimes named({"20230501_120000.mp4", "20230501_120101.mp4"}, {Header(60), Header(60)});
  EXPECT_DOUBLE_EQ(named.LikelyGapAfter(0, 60), 1);
  EXPECT_EQ(named.LikelyGapAfter(0, 60.2), 0) << "rounding";
  EXPECT_EQ(named.LikelyGapAfter(0, 59), 0) << "a gap without doubt";
  EXPECT_EQ(named.LikelyGapAfter(1, 60), 0) << "no other clip";
  EXPECT_EQ(RecordingTimes({"a.mp4", "b.mp4"}, {Header(60, kMayNoon), Header(60, kMayNoon + 61)}).LikelyGapAfter(0, 60),
            0);
}

TEST(RecordingTimes, AGapIsLongerThanTheResolutionOfTheNames) {
  const RecordingTimes times({"20230501_120000.mp4", "20230501_120100.mp4", "20230501_120203.mp4"},
                             {Header(60), Header(60), Header(60)});
  EXPECT_EQ(Complaint(times), "");
  EXPECT_EQ(times.GapAfter(0, 59.2), 0);
  EXPECT_DOUBLE_EQ(times.GapAfter(1, 60), 3);
  EXPECT_EQ(times.GapAfter(2, 60), 0);
}

TEST(RecordingTimes, ClipsOfAnotherDriveAreRefused) {
  EXPECT_EQ(Complaint({{"d/20230501_120000.mp4", "d/20230501_120500.mp4"}, {Header(60), Header(60)}}), "");
  const std::string complaint =
      Complaint({{"d/20230501_120000.mp4", "d/20230501_130100.mp4"}, {Header(60), Header(60)}});
  EXPECT_NE(complaint.find("d/20230501_130100.mp4: begins 60 minutes after 20230501_120000.mp4 ends, by the times in "
                           "their names: another drive; name the clips of one drive instead"),
            std::string::npos)
      << complaint;
}

TEST(RecordingTimes, OverlappingNamesAreRefused) {
  const std::string complaint =
      Complaint({{"d/20230501_120000_F.mp4", "d/20230501_120000_R.mp4"}, {Header(60), Header(60)}});
  EXPECT_NE(complaint.find("d/20230501_120000_R.mp4: begins 60.0 s before 20230501_120000_F.mp4 ends"),
            std::string::npos)
      << complaint;
  EXPECT_NE(Complaint({{"20230501_120000.mp4", "20230501_120050.mp4"}, {Header(60), Header(60)}}), "");
  EXPECT_NE(Complaint({{"20230501_120000_F.mp4", "20230501_120000_R.mp4"}, {Header(5), Header(5)}}), "") << "short";
}

TEST(RecordingTimes, ShortOverlapsAreMeasured) {
  const RecordingTimes overlapping({"20230501_120000.mp4", "20230501_120057.mp4"}, {Header(60), Header(60)});
  EXPECT_EQ(Complaint(overlapping), "");
  EXPECT_DOUBLE_EQ(overlapping.OverlapAfter(0, 60), 3);
  EXPECT_EQ(overlapping.GapAfter(0, 60), 0);
  const RecordingTimes rounded({"20230501_120000.mp4", "20230501_120059.mp4"}, {Header(60), Header(60)});
  EXPECT_EQ(Complaint(rounded), "");
  EXPECT_EQ(rounded.OverlapAfter(0, 60), 0);
}

TEST(RecordingTimes, CreationTimesStandInForNames) {
  const std::vector<std::filesystem::path> clips = {"a.mp4", "b.mp4"};
  EXPECT_DOUBLE_EQ(RecordingTimes(clips, {Header(60, kMayNoon), Header(60, kMayNoon + 100)}).GapAfter(0, 60), 40);
  EXPECT_EQ(RecordingTimes(clips, {Header(60, kMayNoon), Header(60)}).GapAfter(0, 60), 0) << "one is unknown";
  // Written when the file was closed: the last clip is shorter.
  const RecordingTimes closed(clips, {Header(60, kMayNoon), Header(20, kMayNoon + 20)});
  EXPECT_EQ(Complaint(closed), "");
  EXPECT_EQ(closed.GapAfter(0, 60), 0);
  EXPECT_NE(Complaint({clips, {Header(60, kMayNoon), Header(60, kMayNoon + 30)}}).find("creation_time"),
            std::string::npos);
}

TEST(RecordingTimes, MissingImagesTellWhatThePauseIs) {
  const RecordingTimes named({"20230501_120000.mp4", "20230501_120101.mp4"}, {Header(60), Header(60)});
  EXPECT_EQ(named.GapAfter(0, 60), 0);
  EXPECT_DOUBLE_EQ(named.GapAtJump(0, 60), 1);
  EXPECT_DOUBLE_EQ(named.GapAtJump(0, 60.9), 0.5) << "times are rounded down";
  EXPECT_EQ(named.GapAtJump(1, 60), 0) << "no other clip";
  const std::vector<std::filesystem::path> clips = {"a.mp4", "b.mp4"};
  EXPECT_EQ(RecordingTimes(clips, {Header(60), Header(60)}).GapAtJump(0, 60), 0) << "nothing tells";
  // The second clip is as long as the time between the two: written at its end, or after a gap.
  const RecordingTimes ambiguous(clips, {Header(7, kMayNoon), Header(9, kMayNoon + 9)});
  EXPECT_EQ(ambiguous.GapAfter(0, 7), 0);
  EXPECT_DOUBLE_EQ(ambiguous.GapAtJump(0, 7), 2);
  const RecordingTimes closed(clips, {Header(60, kMayNoon), Header(20, kMayNoon + 21)});
  EXPECT_DOUBLE_EQ(closed.GapAtJump(0, 60), 1);
  // The last clip is shorter, or longer, than the one before.
  EXPECT_DOUBLE_EQ(RecordingTimes(clips, {Header(60, kMayNoon), Header(20, kMayNoon + 61)}).GapAtJump(0, 60), 1);
  EXPECT_DOUBLE_EQ(RecordingTimes(clips, {Header(60, kMayNoon), Header(80, kMayNoon + 81)}).GapAtJump(0, 60), 1);
  EXPECT_EQ(RecordingTimes({"20230501_120000.mp4", "20230501_120059.mp4"}, {Header(60), Header(60)}).GapAtJump(0, 60),
            0)
      << "the clips overlap, if anything";
}

TEST(RecordingTimes, ChaptersWithOneCreationTimeFollowOneAnother) {
  const RecordingTimes times({"GX010123.MP4", "GX020123.MP4", "GX030123.MP4", "GX010124.MP4", "GX020124.MP4"},
                             {Header(708, kMayNoon), Header(708, kMayNoon), Header(20, kMayNoon + 1),
                              Header(708, kMayNoon + 1500), Header(9, kMayNoon + 1500)});
  EXPECT_TRUE(times.AreKnown());
  EXPECT_FALSE(times.Guessed().has_value());
  EXPECT_EQ(Complaint(times), "");
  EXPECT_EQ(times.GapAfter(0, 708), 0);
  EXPECT_EQ(times.OverlapAfter(0, 708), 0);
  EXPECT_EQ(times.GapAfter(1, 707.5), 0);
  EXPECT_DOUBLE_EQ(times.GapAfter(0, 600), 108) << "its end is damaged";
  EXPECT_DOUBLE_EQ(times.GapAfter(2, 20), 64) << "the next recording";
  EXPECT_EQ(times.GapAfter(3, 708), 0);
  const std::string complaint =
      Complaint({{"GX010123.MP4", "GX010124.MP4"}, {Header(708, kMayNoon), Header(708, kMayNoon + 7200)}});
  EXPECT_NE(complaint.find("another drive; name the clips of one drive instead"), std::string::npos) << complaint;
}

TEST(RecordingTimes, AChapterThatIsMissingIsNamed) {
  const std::string expected =
      "d/GX030123.MP4: is chapter 3 of its recording, but follows chapter 1 (GX010123.MP4); give chapters that follow "
      "one another, in their order";
  const std::vector<std::filesystem::path> clips = {"d/GX010123.MP4", "d/GX030123.MP4"};
  EXPECT_EQ(Complaint({clips, {Header(708, kMayNoon), Header(708, kMayNoon)}}), expected);
  EXPECT_EQ(Complaint({clips, {Header(708), Header(708)}}), expected);
  EXPECT_EQ(Complaint({clips, {Header(500, kMayNoon), Header(500, kMayNoon + 1000)}}), "") << "the times tell";
  EXPECT_EQ(Complaint({{"GOPR0123.MP4", "GP010123.MP4", "GP020123.MP4"}, {Header(708), Header(708), Header(9)}}), "");
  EXPECT_NE(Complaint({{"GX020123.MP4", "GX010123.MP4"}, {Header(708), Header(708)}}), "") << "order";
}

TEST(RecordingTimes, OtherClipsWithOneCreationTimeMayBeOfTwoCameras) {
  const RecordingTimes two({"a.mp4", "b.mp4"}, {Header(60, kMayNoon), Header(60, kMayNoon)});
  EXPECT_EQ(Complaint(two), "");
  EXPECT_EQ(two.Guessed(), 1u);
  EXPECT_FALSE(two.AreKnown());
  EXPECT_EQ(two.GapAfter(0, 60), 0);
  const RecordingTimes pairs(
      {"1F.mp4", "1R.mp4", "2F.mp4", "2R.mp4"},
      {Header(60, kMayNoon), Header(60, kMayNoon), Header(60, kMayNoon + 60), Header(60, kMayNoon + 60)});
  EXPECT_NE(Complaint(pairs).find("2F.mp4: begins 60.0 s before 1R.mp4 ends"), std::string::npos) << Complaint(pairs);
  const RecordingTimes closed({"a.mp4", "b.mp4"}, {Header(60, kMayNoon), Header(1, kMayNoon + 1)});
  EXPECT_FALSE(closed.Guessed().has_value());
  EXPECT_EQ(Complaint(closed), "");
  EXPECT_EQ(closed.GapAfter(0, 60), 0);
}

}  // namespace
}  // namespace turnscale

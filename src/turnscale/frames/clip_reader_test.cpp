// SPDX-License-Identifier: MIT
#include "turnscale/frames/clip_reader.h"

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/frames/test_video.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr int kRate = 10;

class ClipReaderTest : public ::testing::Test {
 protected:
  ClipReaderTest() : folder_(ScratchPath("clips")) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~ClipReaderTest() override { fs::remove_all(folder_); }

  // Gray values count from `first`.
  fs::path Write(const std::string& name, int first, int count, TestVideo video = {.ticks_per_second = kRate},
                 cv::Size size = {64, 48}) const {
    std::vector<cv::Mat> images;
    for (int i = 0; i < count; ++i) images.emplace_back(size, CV_8UC1, cv::Scalar(first + i));
    WriteTestVideo(folder_ / name, images, video);
    return folder_ / name;
  }

  fs::path WriteMoving(const std::string& name, int first, int count) const {
    WriteTestVideo(folder_ / name, MovingTestImages(first, count), {.ticks_per_second = kRate});
    return folder_ / name;
  }

  static std::vector<DriveImage> ReadAll(ClipReader reader) {
    std::vector<DriveImage> images;
    while (auto image = reader.Read()) images.push_back(*image);
    return images;
  }

  std::string Complaint(const std::vector<fs::path>& clips) const {
    try {
      const ClipReader reader(clips, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(ClipReaderTest, ClipsContinueOneAnother) {
  const auto images = ReadAll({{Write("a.mp4", 50, 20), Write("b.mkv", 70, 20), Write("c.avi", 90, 20)}, {}});
  ASSERT_EQ(images.size(), 60u);
  for (int i = 0; i < 60; ++i) {
    EXPECT_NEAR(*images[i].time, i / 10.0, 1e-9) << i;
    EXPECT_NEAR(images[i].image.gray.at<uint8_t>(20, 20), 50 + i, 3) << i;
    EXPECT_EQ(images[i].clip, i / 20);
    EXPECT_EQ(images[i].notice, "");
  }
  EXPECT_EQ(images[25].name, (folder_ / "b.mkv").string() + ": frame 5");
}

TEST_F(ClipReaderTest, VariableRateAndTheRateGiven) {
  const TestVideo uneven = {.ticks_per_second = 1000, .stamps = {0, 100, 130, 300}};
  const std::vector<fs::path> clips = {Write("a.mkv", 0, 4, uneven), Write("b.mkv", 4, 4, uneven)};
  const auto images = ReadAll({clips, {}});
  ASSERT_EQ(images.size(), 8u);
  EXPECT_NEAR(*images[2].time, 0.13, 1e-9);
  EXPECT_NEAR(*images[3].time, 0.3, 1e-9);
  EXPECT_NEAR(*images[6].time - *images[4].time, 0.13, 1e-9);
  const auto even = ReadAll({clips, {.fps = 5}});
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(*even[i].time, i / 5.0, 1e-9);
  EXPECT_EQ(images[0].notice, "");
  EXPECT_NE(even[0].notice.find("--fps 5 replaces the video's own times"), std::string::npos) << even[0].notice;
  EXPECT_EQ(even[1].notice, "") << "once";
}

TEST_F(ClipReaderTest, PixelsOfAnotherShapeAreNamed) {
  const TestVideo anamorphic{.ticks_per_second = kRate, .pixel_aspect = 1.5};
  const auto images = ReadAll({{Write("a.mp4", 0, 20, anamorphic), Write("b.mp4", 20, 20)}, {}});
  ASSERT_EQ(images.size(), 40u);
  EXPECT_EQ(images[0].notice, "");
  EXPECT_EQ(images[20].notice,
            "b.mp4: its pixels are 1 times as wide as high, those of a.mp4 1.5 times, which is used for both");
}

TEST_F(ClipReaderTest, GapsAreNamedAndCounted) {
  const auto images = ReadAll({{Write("20230501_120000.mp4", 0, 20), Write("20230501_120002.mp4", 20, 20),
                                Write("20230501_120007.mp4", 40, 20)},
                               {}});
  ASSERT_EQ(images.size(), 60u);
  EXPECT_NEAR(*images[20].time, 2, 1e-9);
  EXPECT_EQ(images[20].notice, "");
  EXPECT_NEAR(*images[40].time, 7, 1e-9);
  EXPECT_NEAR(images[40].gap, 3, 1e-9);
  EXPECT_EQ(images[40].notice,
            "gap of 3.0 s between 20230501_120002.mp4 and 20230501_120007.mp4 (at 4.0 s of the drive)");
}

TEST_F(ClipReaderTest, AStartInAGapIsNamed) {
  const std::vector<fs::path> clips = {Write("20230501_120000.mp4", 0, 20), Write("20230501_120007.mp4", 20, 20)};
  const auto images = ReadAll({clips, {.start = 3}});
  ASSERT_EQ(images.size(), 20u);
  EXPECT_NEAR(*images[0].time, 7, 1e-9);
  EXPECT_EQ(images[0].notice, "--start lies in a gap of 5.0 s: the path begins 4.0 s later, at 7.0 s of the drive");
  EXPECT_EQ(ReadAll({clips, {.start = 7}})[0].notice, "");
}

// Image i of the drive is image i of the moving texture.
void ExpectMovingImages(const std::vector<DriveImage>& images, size_t count, int first = 0) {
  ASSERT_EQ(images.size(), count);
  const std::vector<cv::Mat> expected = MovingTestImages(first, static_cast<int>(count));
  for (size_t i = 0; i < count; ++i) {
    EXPECT_NEAR(*images[i].time, (first + static_cast<int>(i)) / 10.0, 1e-9) << i;
    const double difference = cv::norm(images[i].image.gray, expected[i], cv::NORM_L1);
    EXPECT_LT(difference, 4.0 * static_cast<double>(expected[i].total())) << i;
  }
}

TEST_F(ClipReaderTest, ImagesThatClipsRepeatAreLeftOut) {
  const std::vector<fs::path> clips = {WriteMoving("a.mp4", 0, 30), WriteMoving("b.mp4", 20, 30),
                                       WriteMoving("c.mp4", 40, 20)};
  const auto images = ReadAll({clips, {}});
  ExpectMovingImages(images, 60);
  EXPECT_EQ(images[30].notice, "b.mp4 repeats the last 1.0 s of a.mp4: images that clips repeat are left out");
  EXPECT_EQ(images[30].clip, 1);
  EXPECT_EQ(images[30].gap, 0);
  EXPECT_EQ(images[50].notice, "") << "once";
  const auto part = ReadAll({clips, {.start = 3.5}});
  ExpectMovingImages(part, 25, 35);
  EXPECT_EQ(part[15].notice.find("c.mp4 repeats the last 1.0 s of b.mp4"), 0u) << "the first in the part";
  EXPECT_EQ(ReadAll({clips, {.timed = false}}).size(), 80u) << "each image has a time of its own elsewhere";
}

TEST_F(ClipReaderTest, ClipsThatOverlapMayLackImages) {
  std::vector<cv::Mat> images = MovingTestImages(0, 30);
  images.erase(images.begin() + 25);
  TestVideo lacking{.ticks_per_second = kRate};
  for (int i = 0; i < 30; ++i)
    if (i != 25) lacking.stamps.push_back(i);
  WriteTestVideo(folder_ / "a.mkv", images, lacking);
  const auto read = ReadAll({{folder_ / "a.mkv", WriteMoving("b.mkv", 20, 30)}, {}});
  ASSERT_EQ(read.size(), 49u);
  for (size_t i = 1; i < read.size(); ++i) EXPECT_GT(*read[i].time, *read[i - 1].time + 0.05) << i;
}

TEST_F(ClipReaderTest, AStartLongAfterAnOverlapKeepsTheTimes) {
  const std::vector<fs::path> clips = {WriteMoving("a.mkv", 0, 100), WriteMoving("b.mkv", 90, 100)};
  ExpectMovingImages(ReadAll({clips, {.start = 15}}), 40, 150);
}

TEST_F(ClipReaderTest, OverlapsByTheNamesAreLookedFor) {
  const fs::path first = WriteMoving("20230501_120000.mp4", 0, 40);
  ExpectMovingImages(ReadAll({{first, WriteMoving("20230501_120002.mp4", 20, 40)}, {}}), 60);
  const auto other = ReadAll({{first, WriteMoving("20230501_120002.mp4", 100, 40)}, {}});
  ASSERT_EQ(other.size(), 80u);
  EXPECT_EQ(other[40].notice,
            "20230501_120002.mp4 begins 2.0 s before 20230501_120000.mp4 ends, by the times of recording, but does not "
            "repeat its images: is it of another camera?");
  EXPECT_NEAR(*other[40].time, 4, 1e-9);
}

// Times to the second leave it open whether images are missing.
TEST_F(ClipReaderTest, ShortGapsAreSeen) {
  const fs::path first = WriteMoving("20230501_120000.mp4", 0, 40);
  const auto images = ReadAll({{first, WriteMoving("20230501_120005.mp4", 50, 40)}, {}});
  ASSERT_EQ(images.size(), 80u);
  EXPECT_NEAR(*images[40].time, 5, 1e-9);
  EXPECT_NEAR(images[40].gap, 1, 1e-9);
  EXPECT_EQ(images[40].notice,
            "gap of 1.0 s between 20230501_120000.mp4 and 20230501_120005.mp4 (at 4.0 s of the drive): the images show "
            "it, its length is known to a second");
  ExpectMovingImages(ReadAll({{first, WriteMoving("20230501_120005.mp4", 40, 40)}, {}}), 80);

  const auto unknown = ReadAll({{WriteMoving("a.mp4", 0, 40), WriteMoving("b.mp4", 50, 40)}, {}});
  EXPECT_NEAR(*unknown[40].time, 4, 1e-9);
  EXPECT_EQ(
      unknown[40].notice,
      "images seem to be missing between a.mp4 and b.mp4 (at 4.0 s of the drive), nothing tells for how long: the "
      "path may be too short there");
  EXPECT_TRUE(unknown[40].unknown_gap);
  EXPECT_FALSE(unknown[41].unknown_gap);
  EXPECT_FALSE(images[40].unknown_gap);
}

TEST_F(ClipReaderTest, AGapThatOnlyTheNamesTellIsKeptInMind) {
  const fs::path first = WriteMoving("20230501_120000.mp4", 0, 40);
  // The images go on, though a second is missing by the names.
  const auto images = ReadAll({{first, WriteMoving("20230501_120005.mp4", 40, 40)}, {}});
  EXPECT_NEAR(*images[40].time, 4, 1e-9);
  EXPECT_NEAR(images[40].likely_gap, 1, 1e-9);
  EXPECT_EQ(images[41].likely_gap, 0);
  EXPECT_EQ(ReadAll({{first, WriteMoving("20230501_120004.mp4", 40, 40)}, {}})[40].likely_gap, 0);
  EXPECT_EQ(ReadAll({{first, WriteMoving("20230501_120005.mp4", 50, 40)}, {}})[40].likely_gap, 0) << "the gap is kept";
}

TEST_F(ClipReaderTest, TimesOfNamesThatAreNotUsedAreNamed) {
  const fs::path front = Write("230501_120000F.mp4", 0, 20);
  EXPECT_EQ(ClipReader({front, Write("230501_120000R.mp4", 20, 20)}, {}).NoticeOfTimes(),
            "the times in the names of the clips are not used, as 230501_120000R.mp4 begins 2.0 s before "
            "230501_120000F.mp4 ends by them: are the clips of one drive and one camera, in their order?");
  const ClipReader reader({front, Write("230501_120002F.mp4", 20, 20)}, {});
  EXPECT_EQ(reader.NoticeOfTimes(), "");
  EXPECT_EQ(reader.RecordedFrom(), 1682942400);
}

TEST_F(ClipReaderTest, TheCountOfAPartLeavesOutGaps) {
  const std::vector<fs::path> clips = {Write("20230501_120000.mp4", 0, 20), Write("20230501_120010.mp4", 20, 20)};
  const ClipReader reader(clips, {});
  for (const auto& [start, end, count] :
       {std::tuple{0.0, std::optional<double>(), 40}, {0.5, {}, 35}, {5, {}, 20}, {11, {}, 10}, {1, 11, 20}, {3, 9, 0}})
    EXPECT_EQ(reader.CountBetween(start, end), count) << start;
}

TEST_F(ClipReaderTest, AGapWithinAVideoIsNamed) {
  const auto images =
      ReadAll({{Write("a.mkv", 0, 4, {.ticks_per_second = 10, .stamps = {0, 1, 50, 51}})}, {.fps = {}}});
  ASSERT_EQ(images.size(), 4u);
  EXPECT_NEAR(*images[2].time, 5, 1e-9);
  EXPECT_NE(images[2].notice.find("s in a.mkv (at "), std::string::npos) << images[2].notice;
}

TEST_F(ClipReaderTest, ADamagedClipLeavesAGap) {
  const fs::path damaged = Write("a.avi", 0, 40, {.codec = "mjpeg", .ticks_per_second = kRate});
  fs::resize_file(damaged, fs::file_size(damaged) / 2);
  const auto images = ReadAll({{damaged, Write("b.avi", 0, 20)}, {}});
  const size_t second = images.size() - 20;
  ASSERT_LT(second, 30u);
  EXPECT_NEAR(*images[second].time, 4, 0.01);
  EXPECT_NE(images[second].notice.find("a.avi: the video ends after"), std::string::npos) << images[second].notice;
  EXPECT_NE(images[second].notice.find("s between a.avi and b.avi"), std::string::npos) << images[second].notice;
  EXPECT_TRUE(images[second].lacks.starts_with("a.avi: the video ends after ")) << images[second].lacks;
  EXPECT_EQ(images[second + 1].lacks, "");
  EXPECT_EQ(ReadAll({{damaged, folder_ / "b.avi"}, {.start = 4}})[0].lacks, "") << "nothing of the part";
  EXPECT_EQ(ReadAll({{damaged, folder_ / "b.avi"}, {.start = 2.4}})[0].lacks, images[second].lacks) << "in the gap";
}

TEST_F(ClipReaderTest, ACutByAnEditListLeavesNoGap) {
  TestVideo cut{.ticks_per_second = kRate};
  for (int i = 0; i < 60; ++i) cut.stamps.push_back(i - 17);
  ClipReader reader({Write("a.mp4", 0, 60, cut), Write("b.mp4", 60, 60, cut)}, {});
  EXPECT_EQ(reader.count(), 86);
  std::vector<DriveImage> images;
  while (auto image = reader.Read()) images.push_back(*image);
  ASSERT_EQ(images.size(), 86u);
  for (size_t i = 0; i < images.size(); ++i) {
    EXPECT_NEAR(images[i].image.gray.at<uint8_t>(20, 20), 17 + static_cast<int>(i) + (i < 43 ? 0 : 17), 3) << i;
    EXPECT_EQ(images[i].notice, "") << i;
    EXPECT_EQ(images[i].gap, 0) << i;
  }
  EXPECT_NEAR(*images[43].time, 4.3, 0.01);
  EXPECT_EQ(reader.EndsEarly(), "");
  EXPECT_EQ(reader.NoticeAtEnd(), "");
}

TEST_F(ClipReaderTest, MissingFramesDoNotEndAClip) {
  // Empty chunks stand for dropped frames.
  TestVideo dropped{.codec = "mjpeg", .ticks_per_second = kRate};
  for (int i = 0; i < 60; ++i) dropped.stamps.push_back(i + i / 10);
  const std::vector<fs::path> clips = {Write("a.avi", 0, 60, dropped), Write("b.avi", 60, 60, dropped)};
  const auto notices = [](ClipReader reader) {
    std::vector<std::string> found;
    while (const auto image = reader.Read())
      if (!image->notice.empty()) found.push_back(image->notice);
    EXPECT_EQ(reader.EndsEarly(), "");
    found.push_back(reader.NoticeAtEnd());
    return found;
  };
  const std::string missing = ": 5 of 65 frames are missing or cannot be decoded";
  EXPECT_EQ(notices({clips, {}}), std::vector<std::string>({"a.avi" + missing, "b.avi" + missing}));
  EXPECT_NEAR(*ReadAll({clips, {}})[60].time, 6.5, 1e-6);
  EXPECT_EQ(notices({{clips[0]}, {.start = 3}}), std::vector<std::string>({"a.avi" + missing}));
  const std::string by_rate = "; --fps does not allow for that: leave it out";
  EXPECT_EQ(notices({{clips[0]}, {.fps = kRate}}), std::vector<std::string>({"a.avi" + missing + by_rate}));

  // Some frames in the middle are damaged, and the first ones.
  const fs::path damaged = Write("d.mp4", 0, 60, {.ticks_per_second = kRate, .key_interval = 1});
  std::string bytes = TextOf(damaged);
  const size_t data = bytes.find("mdat") + 4;
  const size_t size = (bytes.find("moov") - data) / 60;
  for (const size_t first : {0, 25})
    for (size_t i = data + size * first; i < data + size * (first + 5); ++i) bytes[i] = 0;
  std::ofstream(damaged, std::ios::binary) << bytes;
  const auto found = notices({{damaged}, {}});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].find("of 60 frames are missing or cannot be decoded"), std::string::npos) << found[0];
}

TEST_F(ClipReaderTest, SeveralTracksAreNamed) {
  const std::vector<cv::Mat> front(20, cv::Mat(24, 32, CV_8UC1, cv::Scalar(77)));
  const TestVideo both{.ticks_per_second = kRate, .first_track = front};
  const std::vector<fs::path> clips = {Write("a.mp4", 0, 20, both), Write("b.mp4", 0, 20, both)};
  for (const double start : {0.0, 1.0}) {
    const auto images = ReadAll({clips, {.start = start}});
    EXPECT_EQ(images[0].notice, "a.mp4: has 2 video tracks; the first, 32x24, is used");
    for (size_t i = 1; i < images.size(); ++i) EXPECT_EQ(images[i].notice, "") << i;
    for (const DriveImage& image : images) EXPECT_NEAR(image.image.gray.at<uint8_t>(12, 16), 77, 2);
  }
}

TEST_F(ClipReaderTest, ClipsWithOneCreationTimeFollowOneAnother) {
  const TestVideo video{.ticks_per_second = kRate, .created = "2023-05-01T12:00:00Z"};
  const std::vector<fs::path> chapters = {Write("GX010123.MP4", 0, 20, video), Write("GX020123.MP4", 20, 20, video),
                                          Write("GX030123.MP4", 40, 20, video)};
  const auto images = ReadAll({chapters, {}});
  ASSERT_EQ(images.size(), 60u);
  for (size_t i = 0; i < images.size(); ++i) {
    EXPECT_NEAR(*images[i].time, static_cast<double>(i) / kRate, 1e-9);
    EXPECT_EQ(images[i].notice, "");
  }
  const std::vector<fs::path> others = {Write("a.mp4", 0, 20, video), Write("b.mp4", 20, 20, video)};
  EXPECT_EQ(ReadAll({others, {}})[20].notice,
            "b.mp4 was made at the same time as a.mp4 (creation_time), and is taken to follow it: is it of another "
            "camera?");
}

TEST_F(ClipReaderTest, SeveralRecordingsNeedTimes) {
  const std::vector<fs::path> clips = {Write("GX010123.MP4", 0, 20), Write("GX010124.MP4", 20, 20)};
  EXPECT_EQ(ReadAll({clips, {}}).size(), 40u) << "named by the user";
  try {
    const ClipReader in_folder(clips, {.in_any_order = true});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              clips[1].string() + ": is of another recording than " + clips[0].string() +
                  ", and their recording times are not known; name the clips of one drive in their order");
  }
}

TEST_F(ClipReaderTest, AClipThatCannotBeDecodedIsLeftOut) {
  const auto broken = [&](const std::string& name) {
    std::ofstream(folder_ / name) << "no video";
    return folder_ / name;
  };
  const std::vector<fs::path> ends = {broken("a.mp4"), Write("b.mp4", 0, 20), Write("c.mp4", 20, 20), broken("d.mp4")};
  ClipReader reader(ends, {});
  EXPECT_EQ(reader.clips(), std::vector<fs::path>({ends[1], ends[2]}));
  ASSERT_EQ(reader.left_out().size(), 2u);
  EXPECT_NE(reader.left_out()[0].find("the beginning of the drive is missing, and times count from b.mp4"),
            std::string::npos)
      << reader.left_out()[0];
  EXPECT_EQ(reader.left_out()[1].find((folder_ / "d.mp4").string() + ": "), 0u) << reader.left_out()[1];
  EXPECT_NE(reader.left_out()[1].find("; the clip is left out"), std::string::npos) << reader.left_out()[1];
  int read = 0;
  while (reader.Read()) ++read;
  EXPECT_EQ(read, 40);
  EXPECT_EQ(reader.BeginsLate(), "a.mp4: cannot be decoded: the beginning of the drive is missing");
  EXPECT_EQ(reader.EndsEarly(), "d.mp4: cannot be decoded: the end of the drive is missing");
  ClipReader late({ends[0], ends[1]}, {});
  while (late.Read()) continue;
  EXPECT_NE(late.BeginsLate(), "");
  EXPECT_EQ(late.EndsEarly(), "");
  ClipReader early({ends[1], ends[3]}, {});
  while (early.Read()) continue;
  EXPECT_EQ(early.BeginsLate(), "");
  EXPECT_NE(early.EndsEarly(), "");

  const std::string problem =
      ": is not a video, or is damaged (a recording that was cut off lacks its index; a repair "
      "tool may restore it)";
  const std::string separately =
      "; the gap that it leaves is of unknown length: process the clips before and after it separately";
  EXPECT_EQ(Complaint({ends[1], ends[0], ends[2]}), ends[0].string() + problem + separately);
  EXPECT_EQ(Complaint({ends[0], ends[3]}), ends[0].string() + problem);
  for (const bool at_end : {false, true}) {
    try {
      const ClipReader untimed(at_end ? std::vector{ends[1], ends[3]} : std::vector{ends[1], ends[3], ends[2]},
                               {.timed = false});
      FAIL();
    } catch (const InputError& error) {
      EXPECT_EQ(error.what(), ends[3].string() + problem +
                                  (at_end ? "; leave out the clip, and its times (--timestamps)" : separately));
    }
  }
  try {
    const ClipReader in_folders({ends[1], ends[2]}, {.in_any_order = true});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("their recording times are not known"), std::string::npos);
  }
  const auto images = ReadAll(
      {{Write("20230501_120000.mp4", 0, 20), broken("20230501_120002.mp4"), Write("20230501_120007.mp4", 20, 20)}, {}});
  ASSERT_EQ(images.size(), 40u);
  EXPECT_NEAR(*images[20].time, 7, 1e-9);
  EXPECT_EQ(images[20].lacks, "20230501_120002.mp4: cannot be decoded: a part of the drive is missing");
}

TEST_F(ClipReaderTest, SizesHaveToAgree) {
  const fs::path small = Write("b.mp4", 0, 4, {}, {32, 24});
  EXPECT_EQ(Complaint({Write("a.mp4", 0, 4), small}),
            small.string() + ": is 32x24 pixels, but a.mp4 is 64x48; give the clips of one camera");
}

TEST_F(ClipReaderTest, FramesBeforeTheStartAreLeftOut) {
  const std::vector<fs::path> clips = {Write("20230501_120000.mp4", 0, 20), Write("20230501_120010.mp4", 20, 20)};
  const auto images = ReadAll({clips, {.start = 1.05}});
  ASSERT_EQ(images.size(), 29u);
  EXPECT_NEAR(*images[0].time, 1.1, 1e-9);
  EXPECT_NE(images[9].notice, "");
  const auto second = ReadAll({clips, {.start = 3}});
  ASSERT_EQ(second.size(), 20u);
  EXPECT_NEAR(*second[0].time, 10, 1e-9);
  ClipReader untimed(clips, {.timed = false});
  untimed.Skip(25);
  EXPECT_NEAR(untimed.Read()->image.gray.at<uint8_t>(20, 20), 25, 3);
}

TEST_F(ClipReaderTest, PassingOverTheStartChangesNoTimeAndNoImage) {
  const TestVideo uneven = {.ticks_per_second = 1000, .stamps = {}, .b_frames = 2, .key_interval = 6};
  for (const std::string name : {"v.mp4", "v.mkv", "v.ts", "v.avi", "v.m2v"}) {
    TestVideo video = uneven;
    if (name == "v.ts" || name == "v.m2v") video.codec = "mpeg2video";
    if (name == "v.mp4" || name == "v.mkv") {
      for (int i = 0; i < 40; ++i) video.stamps.push_back(100 * i + i * i % 37);
    } else {
      video.ticks_per_second = 25;
    }
    const fs::path path = Write(name, 0, 40, video);
    const auto all = ReadAll({{path}, {}});
    ASSERT_EQ(all.size(), 40u) << name;
    for (const size_t first : {1, 5, 6, 7, 17, 39}) {
      const auto part = ReadAll({{path}, {.start = *all[first].time}});
      ASSERT_EQ(part.size(), 40 - first) << name;
      for (size_t i = 0; i < part.size(); ++i) {
        EXPECT_EQ(*part[i].time, *all[first + i].time) << name << " " << i;
        EXPECT_EQ(part[i].name, all[first + i].name);
        EXPECT_EQ(cv::norm(part[i].image.gray, all[first + i].image.gray, cv::NORM_INF), 0) << name << " " << i;
      }
    }
  }
}

}  // namespace
}  // namespace turnscale

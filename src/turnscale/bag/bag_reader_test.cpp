// SPDX-License-Identifier: MIT
#include "turnscale/bag/bag_reader.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/bag/messages.h"
#include "turnscale/bag/test_bag.h"
#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

struct Container {
  std::string extension;
  TestBag bag;
};

std::string NameOf(const Container& container) {
  return container.extension.substr(1) + "_" + container.bag.compression +
         (container.bag.indexed ? "" : "_without_index") + (container.bag.chunks ? "" : "_without_chunks");
}

std::string ComplaintOf(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

class BagReaderTest : public ::testing::TestWithParam<Container> {
 protected:
  std::filesystem::path Path() const { return folder_.Path() / ("drive" + GetParam().extension); }

  // Images 0 to 4 on /a and on /b, and a camera info of /a.
  std::vector<TestBagMessage> Messages() const {
    const BagSerialization serialization = SerializationOf(Path());
    std::vector<TestBagMessage> messages = {{"/camera_info", "CameraInfo", 1, TestCameraInfoMessage(serialization)},
                                            {"/scan", "LaserScan", 2, {1, 2, 3, 4, 5, 6, 7, 8}}};
    for (int i = 0; i < 5; ++i) {
      const std::vector<uint8_t> pixels(12, static_cast<uint8_t>(i));
      const int64_t time = 100 + i;
      messages.push_back({"/a", "Image", time, TestImageMessage(serialization, time, 4, 3, "mono8", pixels)});
      messages.push_back({"/b", "CompressedImage", time, TestCompressedMessage(serialization, time, "png", pixels)});
    }
    return messages;
  }

 private:
  ScratchFolder folder_;
};

TEST_P(BagReaderTest, GivesTheMessagesInTheirOrder) {
  WriteTestBag(Path(), Messages(), GetParam().bag);
  const auto reader = OpenBag(Path());
  std::vector<std::string> topics;
  while (const auto message = reader->Next()) {
    topics.push_back(message->topic->name);
    if (message->topic->name == "/camera_info") {
      EXPECT_EQ(ReadBagCameraInfo(*message).width, 64u);
    }
    if (message->topic->name != "/a") continue;
    const BagImage image = ReadBagImage(*message);
    EXPECT_EQ(image.stamp, message->logged);
    EXPECT_EQ(image.width, 4u);
    EXPECT_EQ(image.height, 3u);
    EXPECT_EQ(image.encoding, "mono8");
    ASSERT_EQ(image.data.size(), 12u);
    EXPECT_EQ(image.data[11], image.stamp - 100);
  }
  ASSERT_EQ(topics.size(), 11u) << "others are left out";
  EXPECT_EQ(topics[0], "/camera_info");
  EXPECT_EQ(topics[10], "/b");
}

TEST_P(BagReaderTest, ReadsOnlyTheTopicsAskedFor) {
  WriteTestBag(Path(), Messages(), GetParam().bag);
  const auto reader = OpenBag(Path(), {"/b"});
  int count = 0;
  for (; const auto message = reader->Next(); ++count) EXPECT_EQ(ReadBagCompressedImage(*message).stamp, 100 + count);
  EXPECT_EQ(count, 5);
}

TEST_P(BagReaderTest, ListsTopicsWithAndWithoutIndex) {
  WriteTestBag(Path(), Messages(), GetParam().bag);
  const bool indexed = GetParam().bag.indexed;
  EXPECT_EQ(OpenBag(Path())->TopicsInIndex().has_value(), indexed);
  const auto topics = ListTopics(Path());
  ASSERT_EQ(topics.size(), 3u);
  EXPECT_EQ(topics[0].name, "/a");
  EXPECT_EQ(topics[0].messages, 5u);
  EXPECT_EQ(topics[1].content, BagContent::kCompressedImage);
  EXPECT_EQ(topics[2].messages, 1u);
}

TEST_P(BagReaderTest, TruncatedAnywhereItEndsOrIsRefused) {
  WriteTestBag(Path(), Messages(), GetParam().bag);
  const auto size = std::filesystem::file_size(Path());
  int refused = 0;
  for (uintmax_t length = size - 1; length > 20; length -= std::min<uintmax_t>(length, 37)) {
    std::filesystem::resize_file(Path(), length);
    const std::string complaint = ComplaintOf([&] {
      const auto reader = OpenBag(Path());
      while (reader->Next()) {
      }
    });
    if (complaint == "no error") continue;
    ++refused;
    EXPECT_TRUE(complaint.starts_with(Path().string() + ": ")) << complaint;
    EXPECT_EQ(complaint.find('\n'), std::string::npos);
  }
  EXPECT_GT(refused, 5);
}

TEST_P(BagReaderTest, WhatComesBeforeDamageIsListed) {
  // There sqlite3 tells what it can read.
  if (Path().extension() == ".db3") return;
  WriteTestBag(Path(), Messages(), GetParam().bag);
  // Without the index, and within a record.
  std::filesystem::resize_file(Path(),
                               std::filesystem::file_size(Path()) * (Path().extension() == ".bag" ? 88 : 70) / 100);
  const auto topics = ListTopics(Path());
  ASSERT_FALSE(topics.empty());
  EXPECT_EQ(topics[0].name, "/a");
}

INSTANTIATE_TEST_SUITE_P(
    All, BagReaderTest,
    ::testing::Values(Container{".bag", {}}, Container{".bag", {.compression = "lz4"}},
                      Container{".bag", {.compression = "bz2"}}, Container{".bag", {.indexed = false}},
                      Container{".bag", {.indexed = false, .chunks = false}}, Container{".mcap", {}},
                      Container{".mcap", {.compression = "lz4"}}, Container{".mcap", {.compression = "zstd"}},
                      Container{".mcap", {.compression = "zstd", .indexed = false}},
                      Container{".mcap", {.indexed = false, .chunks = false}}, Container{".db3", {}}),
    [](const auto& tested) { return NameOf(tested.param); });

class DamagedBagTest : public ::testing::Test {
 protected:
  std::filesystem::path Write(const std::string& name, const std::string& text) const {
    const std::filesystem::path path = ScratchPath(name);
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  static std::string ReadAll(const std::filesystem::path& path) {
    return ComplaintOf([&] {
      const auto reader = OpenBag(path);
      while (reader->Next()) {
      }
    });
  }
};

TEST_F(DamagedBagTest, OtherFilesAreNoBags) {
  EXPECT_NE(ReadAll(Write("a.bag", "")).find("a.bag: is not a bag"), std::string::npos);
  EXPECT_NE(ReadAll(Write("a.mcap", "no bag at all")).find("is not a bag"), std::string::npos);
  EXPECT_NE(ReadAll(Write("a.bag", "#ROSBAG V1.2\nwhatever")).find("older format than 2.0"), std::string::npos);
  EXPECT_NE(ReadAll(Write("a.db3", std::string("SQLite format 3\0and no more", 27))).find("cannot be read as a bag"),
            std::string::npos);
  EXPECT_NE(ReadAll(ScratchPath("nowhere.bag")).find("is not a file"), std::string::npos);
  EXPECT_TRUE(IsBag("drive.BAG"));
  EXPECT_FALSE(IsBag("drive.mp4"));
  EXPECT_TRUE(IsBag(Write("renamed", "#ROSBAG V2.0\n")));
}

TEST_F(DamagedBagTest, GreatSizesAreRefusedBeforeMemoryIsTaken) {
  const std::filesystem::path path = ScratchPath("great.mcap");
  WriteTestBag(
      path, {{"/a", "Image", 1, TestImageMessage(BagSerialization::kCdr, 1, 1, 1, "mono8", std::vector<uint8_t>{1})}},
      {.compression = "zstd"});
  std::string text = TextOf(path);
  // Of the chunk, after the magic, the header record and two times: its uncompressed size.
  const size_t size_at = text.find(std::string("\x04\0\0\0zstd", 8)) - 4 - 8;
  const uint64_t great = uint64_t{1} << 60;
  std::copy_n(reinterpret_cast<const char*>(&great), 8, text.begin() + static_cast<std::ptrdiff_t>(size_at));
  EXPECT_NE(ReadAll(Write("great.mcap", text)).find("is too large (record at byte "), std::string::npos);
}

TEST_F(DamagedBagTest, AWrongChecksumIsNoticed) {
  const std::filesystem::path path = ScratchPath("sum.mcap");
  const std::vector<uint8_t> pixels = {'p', 'i', 'x', 'e', 'l', 's'};
  WriteTestBag(path, {{"/a", "Image", 1, TestImageMessage(BagSerialization::kCdr, 1, 3, 2, "mono8", pixels)}});
  std::string text = TextOf(path);
  text[text.find("pixels")] = 'P';
  EXPECT_NE(ReadAll(Write("sum.mcap", text)).find("wrong checksum"), std::string::npos);
}

}  // namespace
}  // namespace turnscale

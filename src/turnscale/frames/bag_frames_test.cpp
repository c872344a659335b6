// SPDX-License-Identifier: MIT
#include "turnscale/frames/bag_frames.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "turnscale/bag/messages.h"
#include "turnscale/bag/test_bag.h"
#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/frames/image_source.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kBagSecond = 1'000'000'000;
constexpr int64_t kBagEpoch = 1'700'000'000 * kBagSecond;
constexpr const char* kBagTopic = "/camera/image_raw";
constexpr uint32_t kBagWidth = 8;
constexpr uint32_t kBagHeight = 6;

class BagFramesTest : public ::testing::Test {
 protected:
  fs::path Path(const std::string& name) const { return folder_.Path() / name; }

  // An image whose gray tells its number.
  static TestBagMessage BagImageAt(int64_t stamp, int number, const std::string& topic = kBagTopic,
                                   BagSerialization serialization = BagSerialization::kRos1) {
    const std::vector<uint8_t> pixels(kBagWidth * kBagHeight, static_cast<uint8_t>(number));
    return {topic, "Image", stamp, TestImageMessage(serialization, stamp, kBagWidth, kBagHeight, "mono8", pixels)};
  }

  // Ten images a second.
  static std::vector<TestBagMessage> BagImages(int first, int count, const std::string& topic = kBagTopic,
                                               BagSerialization serialization = BagSerialization::kRos1) {
    std::vector<TestBagMessage> messages;
    for (int i = first; i < first + count; ++i)
      messages.push_back(BagImageAt(kBagEpoch + i * kBagSecond / 10, i, topic, serialization));
    return messages;
  }

  fs::path Write(const std::string& name, const std::vector<TestBagMessage>& messages, const TestBag& bag = {}) const {
    WriteTestBag(Path(name), messages, bag);
    return Path(name);
  }

  static std::vector<SourceFrame> ReadBags(const std::vector<fs::path>& bags, const ImageSourceOptions& options = {},
                                           const std::string& topic = {}) {
    ImageSource source(FindDrive(bags, topic), options);
    std::vector<SourceFrame> frames;
    while (auto frame = source.Next()) frames.push_back(*frame);
    return frames;
  }

  static std::string BagComplaint(const std::vector<fs::path>& bags, const ImageSourceOptions& options = {},
                                  const std::string& topic = {}) {
    try {
      ReadBags(bags, options, topic);
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return "no error";
  }

  static void ExpectHolds(const std::string& complaint, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) EXPECT_NE(complaint.find(part), std::string::npos) << complaint;
  }

 private:
  ScratchFolder folder_;
};

TEST_F(BagFramesTest, ImagesWithTheTimesOfTheirHeaders) {
  for (const std::string name : {"a.bag", "a.mcap", "a.db3"}) {
    std::vector<TestBagMessage> messages = BagImages(0, 5, kBagTopic, SerializationOf(name));
    for (TestBagMessage& message : messages) message.logged += kBagSecond / 20;
    ImageSource source(FindDrive(Write(name, messages)), {});
    EXPECT_EQ(source.count(), 5);
    for (int i = 0; i < 5; ++i) {
      const auto frame = source.Next();
      ASSERT_TRUE(frame.has_value());
      EXPECT_EQ(frame->index, i);
      EXPECT_EQ(frame->time, SecondsOfStamp(kBagEpoch + i * kBagSecond / 10));
      EXPECT_EQ(frame->gray.at<uint8_t>(3, 3), i);
      EXPECT_EQ(frame->gray.size(), cv::Size(kBagWidth, kBagHeight));
    }
    EXPECT_FALSE(source.Next().has_value());
    ASSERT_EQ(source.clips().size(), 1u);
    EXPECT_EQ(source.clips()[0].frames, 5);
  }
}

TEST_F(BagFramesTest, OneOfSeveralTopicsHasToBeNamed) {
  std::vector<TestBagMessage> messages = BagImages(0, 3, "/left/image_raw");
  for (const TestBagMessage& message : BagImages(10, 4, "/right/image_raw")) messages.push_back(message);
  const fs::path bag = Write("two.bag", messages);
  ExpectHolds(BagComplaint({bag}), {"two.bag: holds images on several topics; give one of them with --topic: "
                                    "/left/image_raw, /right/image_raw"});
  const auto frames = ReadBags({bag}, {}, "/right/image_raw");
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(frames[0].gray.at<uint8_t>(0, 0), 10);
  ExpectHolds(BagComplaint({bag}, {}, "/rear"), {"two.bag: holds no images on /rear, but on /left/image_raw, /right"});
  ExpectHolds(BagComplaint({Write("none.bag", {{"/scan", "LaserScan", 1, {0}}})}), {"none.bag: holds no images"});
}

TEST_F(BagFramesTest, BagsContinueOneAnother) {
  const fs::path first = Write("1.bag", BagImages(0, 4));
  const fs::path second = Write("2.bag", BagImages(4, 3));
  const auto frames = ReadBags({first, second});
  ASSERT_EQ(frames.size(), 7u);
  for (int i = 0; i < 7; ++i) {
    EXPECT_EQ(frames[i].gray.at<uint8_t>(0, 0), i);
    EXPECT_EQ(frames[i].notice, "");
  }
  ExpectHolds(BagComplaint({second, first}), {"1.bag: begins before ", "2.bag; give the bags in their order"});
  ExpectHolds(BagComplaint({second, first}, {.fps = 10}), {"give the bags in their order"});
  ExpectHolds(BagComplaint({first, first}), {"is given twice"});
  fs::copy_file(first, Path("copy.bag"));
  ExpectHolds(BagComplaint({first, Path("copy.bag")}), {"give the bags in their order"});
}

TEST_F(BagFramesTest, BagsThatOverlapAreRefusedWhereTheyMeet) {
  const fs::path first = Write("1.bag", BagImages(0, 6));
  const fs::path second = Write("2.bag", BagImages(3, 6));
  ExpectHolds(BagComplaint({first, second}), {"2.bag: /camera/image_raw: image 0: its header stamp, 1700000000.300 s, "
                                              "is not after the last one of ",
                                              "give the bags in their order"});
}

TEST_F(BagFramesTest, GapsAreTold) {
  const fs::path first = Write("1.bag", BagImages(0, 4));
  ImageSource source(FindDrive({first, Write("2.bag", BagImages(54, 3))}, ""), {});
  std::vector<SourceFrame> frames;
  while (auto frame = source.Next()) frames.push_back(*frame);
  ASSERT_EQ(frames.size(), 7u);
  EXPECT_EQ(frames[4].notice, "gap of 5.0 s between 1.bag and 2.bag (at 0.4 s of the drive)");
  ASSERT_EQ(source.clips().size(), 2u);
  EXPECT_NEAR(source.clips()[1].gap_before, 5.0, 1e-9);
  EXPECT_EQ(source.clips()[1].frames, 3);
}

TEST_F(BagFramesTest, PartOfADrive) {
  const fs::path first = Write("1.bag", BagImages(0, 10));
  const fs::path second = Write("2.bag", BagImages(10, 10));
  for (const std::optional<double> fps : {std::optional<double>(), std::optional<double>(10)}) {
    const auto frames = ReadBags({first, second}, {.fps = fps, .start = 0.75, .end = 1.25});
    ASSERT_EQ(frames.size(), 5u);
    EXPECT_EQ(frames.front().gray.at<uint8_t>(0, 0), 8);
    EXPECT_EQ(frames.front().index, 0);
    EXPECT_EQ(frames.back().gray.at<uint8_t>(0, 0), 12);
    EXPECT_NEAR(frames.front().time - (fps ? 0 : 1.7e9), 0.8, 1e-6);
    ExpectHolds(BagComplaint({first, second}, {.fps = fps, .start = 60}), {"--start 60 s: the drive ends at 1.9 s"});
  }
}

TEST_F(BagFramesTest, TimesOfTheUserGoFirst) {
  const fs::path bag = Write("1.bag", BagImages(0, 3), {.indexed = false});
  EXPECT_EQ(ReadBags({bag}, {.fps = 2})[2].time, 1.0);
  std::ofstream(Path("times.txt")) << "5\n6\n7.5\n";
  const auto frames = ReadBags({bag}, {.timestamps = Path("times.txt")});
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[2].time, 7.5);
  std::ofstream(Path("times.txt")) << "5\n6\n";
  ExpectHolds(BagComplaint({bag}, {.timestamps = Path("times.txt")}), {"times.txt:2: ends after 2 times", "3 frames"});
}

TEST_F(BagFramesTest, StampsThatAreMissingOrGoBack) {
  const fs::path none = Write("none.bag", {BagImageAt(0, 0), BagImageAt(0, 1)});
  ExpectHolds(BagComplaint({none}), {"none.bag: /camera/image_raw: image 1: has no header stamp; give --fps X"});
  EXPECT_EQ(ReadBags({none}, {.fps = 10}).size(), 2u);
  std::vector<TestBagMessage> messages = BagImages(20, 3);
  messages.push_back(BagImageAt(kBagEpoch, 9));
  ExpectHolds(BagComplaint({Write("back.bag", messages)}),
              {"image 3: its header stamp goes back from 1700000002.200 to 1700000000.000 s"});
}

TEST_F(BagFramesTest, LateAndRepeatedImagesAreLeftOut) {
  const auto at = [](int tenth) { return BagImageAt(kBagEpoch + tenth * kBagSecond / 10, tenth); };
  const auto frames = ReadBags({Write("late.bag", {at(0), at(2), at(2), at(1), at(3)})});
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[1].gray.at<uint8_t>(0, 0), 2);
  EXPECT_EQ(frames[2].gray.at<uint8_t>(0, 0), 3);
  ExpectHolds(frames[2].notice, {"image 2: its header stamp is not after the one before; such images are left out"});
}

TEST_F(BagFramesTest, DamagedImagesAreSkippedAndDamagedBagsEnd) {
  std::vector<TestBagMessage> messages = BagImages(0, 5);
  const std::vector<uint8_t> few(7);
  messages[2].bytes = TestImageMessage(BagSerialization::kRos1, messages[2].logged, 10, 1, "mono8", few);
  const fs::path bag = Write("a.bag", messages, {.indexed = false, .chunk_messages = 1});
  const auto frames = ReadBags({bag});
  ASSERT_EQ(frames.size(), 5u);
  EXPECT_TRUE(frames[2].gray.empty());
  ExpectHolds(frames[2].problem, {"a.bag: /camera/image_raw: image 2: an image of 10x1 pixels in mono8 has 7 bytes"});
  fs::resize_file(bag, fs::file_size(bag) - 5);
  ImageSource source(FindDrive(bag), {});
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(source.Next().has_value()) << "what comes before the damage is used";
  EXPECT_THROW(source.Next(), InputError);
  messages = BagImages(0, 2);
  messages[1].bytes = TestImageMessage(BagSerialization::kRos1, messages[1].logged, 1, 1, "32FC1", few);
  ExpectHolds(BagComplaint({Write("depth.bag", messages)}), {"image 1: image encoding '32FC1' is not supported"});
}

TEST_F(BagFramesTest, TextOfABagIsEscapedInMessages) {
  const std::vector<uint8_t> pixels(10);
  std::vector<TestBagMessage> messages = BagImages(0, 1, "/left\nright");
  messages.push_back(messages[0]);
  messages[1].logged += kBagSecond;
  messages[1].bytes = TestImageMessage(BagSerialization::kRos1, messages[1].logged, 10, 1, "mono\n8", pixels);
  ExpectHolds(BagComplaint({Write("lines.bag", messages)}),
              {"/left\\x0aright: image 1: image encoding 'mono\\x0a8' is"});
  messages = BagImages(0, 1, "/left\n");
  messages.push_back(BagImages(0, 1, "/right")[0]);
  ExpectHolds(BagComplaint({Write("topics.bag", messages)}), {"--topic: /left\\x0a, /right"});
}

TEST_F(BagFramesTest, CompressedImages) {
  cv::Mat picture(kBagHeight, kBagWidth, CV_8UC1, cv::Scalar(77));
  std::vector<TestBagMessage> messages;
  for (const std::string extension : {".png", ".jpg", ".bmp"}) {
    std::vector<uint8_t> bytes;
    cv::imencode(extension, picture, bytes);
    const int64_t time = kBagEpoch + static_cast<int64_t>(messages.size()) * kBagSecond / 10;
    messages.push_back({"/image/compressed", "CompressedImage", time,
                        TestCompressedMessage(BagSerialization::kRos1, time, extension.substr(1), bytes)});
  }
  const int64_t end = kBagEpoch + kBagSecond;
  std::vector<uint8_t> cut;
  cv::imencode(".png", picture, cut);
  cut.erase(cut.end() - 15, cut.end());
  messages.push_back(
      {"/image/compressed", "CompressedImage", end, TestCompressedMessage(BagSerialization::kRos1, end, "png", cut)});
  // Announces 60000 x 60000 pixels.
  std::vector<uint8_t> great;
  cv::imencode(".png", picture, great);
  for (const size_t at : {18u, 22u}) {
    great[at] = 0xEA;
    great[at + 1] = 0x60;
  }
  messages.push_back({"/image/compressed", "CompressedImage", end + kBagSecond,
                      TestCompressedMessage(BagSerialization::kRos1, end + kBagSecond, "png", great)});
  const auto frames = ReadBags({Write("c.bag", messages)});
  ASSERT_EQ(frames.size(), 5u);
  EXPECT_EQ(frames[0].gray.at<uint8_t>(2, 2), 77);
  EXPECT_NEAR(frames[1].gray.at<uint8_t>(2, 2), 77, 1);
  ExpectHolds(frames[2].problem, {"image 2: is neither JPEG nor PNG"});
  ExpectHolds(frames[3].problem, {"image 3: is truncated"});
  ExpectHolds(frames[4].problem, {"image 4: is not a readable image"});
}

TEST_F(BagFramesTest, TheCameraIsThatBesideTheImages) {
  TestCameraInfo info;
  info.d = {-0.25, 0.1, 0, 0, 0};
  const auto info_on = [&](const std::string& topic) {
    return TestBagMessage{topic, "CameraInfo", kBagEpoch, TestCameraInfoMessage(BagSerialization::kRos1, info)};
  };
  std::vector<TestBagMessage> messages = BagImages(0, 2);
  messages.push_back(info_on("/other/camera_info"));
  const auto camera_of = [](const fs::path& bag) { return ReadBagCamera(FindDrive(bag).bags.value()); };
  EXPECT_FALSE(camera_of(Write("a.bag", messages)).has_value());
  messages.push_back(info_on("/camera/camera_info"));
  const auto camera = camera_of(Write("b.bag", messages));
  ASSERT_TRUE(camera.has_value());
  EXPECT_EQ(camera->name, Path("b.bag").string() + ": /camera/camera_info");
  EXPECT_EQ(camera->model.distortion[0], -0.25);
  ExpectHolds(BagComplaint({Path("b.bag")},
                           {.width = camera->model.width, .height = camera->model.height, .camera_file = camera->name}),
              {"image 0: is 8x6 pixels, but ", "b.bag: /camera/camera_info says 64x48"});
}

TEST_F(BagFramesTest, AFolderOfRos2IsABag) {
  fs::create_directories(Path("drive"));
  Write("drive/drive_0.db3", BagImages(0, 3, kBagTopic, BagSerialization::kCdr));
  EXPECT_THROW(FindDrive(Path("drive")), InputError) << "bags of many drives may lie in one folder";
  std::ofstream(Path("drive/metadata.yaml")) << "rosbag2_bagfile_information:\n";
  Write("drive/drive_1.db3", BagImages(3, 3, kBagTopic, BagSerialization::kCdr));
  EXPECT_EQ(ReadBags({Path("drive")}).size(), 6u);
}

TEST_F(BagFramesTest, KindsAreNotMixed) {
  const fs::path bag = Write("1.bag", BagImages(0, 4));
  std::ofstream(Path("clip.mp4")) << "x";
  ExpectHolds(BagComplaint({bag, Path("clip.mp4")}), {"1.bag: is a bag, but ", "clip.mp4 is not"});
  ExpectHolds(BagComplaint({Path("clip.mp4")}, {}, "/a"), {"--topic /a: ", "clip.mp4 is not a bag"});
  std::ofstream(Path("no.bag")) << "x";
  ExpectHolds(BagComplaint({Path("no.bag")}), {"no.bag: is not a bag of ROS 1"});
}

TEST_F(BagFramesTest, TwelveBitsOfMono16KeepTheirLevels) {
  std::vector<TestBagMessage> messages;
  for (int i = 0; i < 3; ++i) {
    std::vector<uint8_t> pixels;
    for (uint32_t pixel = 0; pixel < kBagWidth * kBagHeight; ++pixel) {
      const uint32_t level = 80 * pixel + 16;
      pixels.push_back(static_cast<uint8_t>(level & 0xFF));
      pixels.push_back(static_cast<uint8_t>(level >> 8));
    }
    const int64_t stamp = kBagEpoch + i * kBagSecond / 10;
    messages.push_back({kBagTopic, "Image", stamp,
                        TestImageMessage(BagSerialization::kRos1, stamp, kBagWidth, kBagHeight, "mono16", pixels)});
  }
  const auto frames = ReadBags({Write("deep.bag", messages)});
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0].notice, "the 16-bit images are read as 12 bits: the brightest level of the first one is 3776");
  EXPECT_EQ(frames[1].notice, "");
  for (const SourceFrame& frame : frames)
    for (int pixel = 0; pixel < frame.gray.cols * frame.gray.rows; ++pixel)
      ASSERT_EQ(frame.gray.ptr<uint8_t>(0)[pixel], 5 * pixel + 1);
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/bag/messages.h"

#include <gtest/gtest.h>

#include "turnscale/bag/byte_reader.h"
#include "turnscale/bag/test_bag.h"
#include "turnscale/base/number_text.h"

namespace turnscale {
namespace {

class MessagesTest : public ::testing::TestWithParam<BagSerialization> {
 protected:
  BagMessage Message(const std::vector<uint8_t>& bytes) {
    topic_.serialization = GetParam();
    bytes_ = bytes;
    return {&topic_, 0, bytes_};
  }

  BagTopic topic_;
  std::vector<uint8_t> bytes_;
};

TEST_P(MessagesTest, CameraInfoOfAnyNumberOfCoefficients) {
  for (const size_t count : {0u, 1u, 4u, 5u, 8u}) {
    TestCameraInfo written;
    written.d.assign(count, 0.25);
    written.model = std::string("model").substr(0, count);
    const BagCameraInfo info = ReadBagCameraInfo(Message(TestCameraInfoMessage(GetParam(), written)));
    EXPECT_EQ(info.d, written.d);
    EXPECT_EQ(info.distortion_model, written.model);
    EXPECT_EQ(info.k[0], 50);
    EXPECT_EQ(info.k[8], 1);
    EXPECT_EQ(info.p[5], 41);
    EXPECT_EQ(info.width, 64u);
    EXPECT_EQ(info.height, 48u);
  }
}

TEST_P(MessagesTest, EveryShorterMessageIsRefused) {
  const std::vector<uint8_t> pixels(12, 3);
  const std::vector<uint8_t> image = TestImageMessage(GetParam(), 5, 4, 3, "mono8", pixels);
  EXPECT_EQ(ReadBagImage(Message(image)).stamp, 5);
  for (size_t size = 0; size < image.size(); ++size)
    EXPECT_THROW(ReadBagImage(Message({image.begin(), image.begin() + static_cast<std::ptrdiff_t>(size)})),
                 MalformedData);
}

TEST_P(MessagesTest, StampsThatAreNoTimes) {
  TestMessage message(GetParam());
  if (GetParam() == BagSerialization::kRos1) message.Add(uint32_t{0});
  message.Add(uint32_t{1}).Add(uint32_t{1'000'000'000}).Text("").Text("").Bytes({});
  EXPECT_THROW(ReadBagStamp(Message(message.bytes())), MalformedData);
}

INSTANTIATE_TEST_SUITE_P(Both, MessagesTest, ::testing::Values(BagSerialization::kRos1, BagSerialization::kCdr),
                         [](const auto& tested) { return tested.param == BagSerialization::kCdr ? "cdr" : "ros1"; });

TEST(Messages, CdrOfTheOtherByteOrder) {
  BagTopic topic;
  topic.serialization = BagSerialization::kCdr;
  const std::vector<uint8_t> data = {9, 8};
  const TestMessage message = TestMessage(BagSerialization::kCdr, true).Header(1'500'000'002).Text("png").Bytes(data);
  const BagCompressedImage image = ReadBagCompressedImage({&topic, 0, message.bytes()});
  EXPECT_EQ(image.stamp, 1'500'000'002);
  EXPECT_EQ(image.format, "png");
  EXPECT_EQ(image.data.size(), 2u);
}

TEST(Messages, OtherSerializationsAreNamed) {
  BagTopic topic;
  topic.serialization = BagSerialization::kCdr;
  const std::vector<uint8_t> zstd = {0x28, 0xB5, 0x2F, 0xFD, 0, 0};
  try {
    ReadBagStamp({&topic, 0, zstd});
    ADD_FAILURE();
  } catch (const MalformedData& error) {
    EXPECT_NE(std::string(error.what()).find("ros2 bag convert"), std::string::npos);
  }
  const std::vector<uint8_t> xcdr2 = {0, 7, 0, 0, 0, 0, 0, 0};
  EXPECT_THROW(ReadBagStamp({&topic, 0, xcdr2}), MalformedData);
}

TEST(Messages, SecondsAreThoseOfTheDecimalNumber) {
  EXPECT_EQ(SecondsOfStamp(0), 0.0);
  EXPECT_EQ(SecondsOfStamp(3'300'000'000), 3.3);
  EXPECT_EQ(SecondsOfStamp(1'700'000'000'103'600'001), 1700000000.103600001);
}

}  // namespace
}  // namespace turnscale

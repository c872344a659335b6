// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "turnscale/bag/test_bag.h"
#include "turnscale/base/error.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/test_files.h"
#include "turnscale/frames/bag_drive.h"
#include "turnscale/frames/bag_frames.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMutatedSecond = 1'000'000'000;

struct MutatedKind {
  std::string name;
  TestBag bag;
};

// A camera info, and images of all kinds.
std::vector<TestBagMessage> MessagesToMutate(BagSerialization serialization) {
  TestCameraInfo info;
  info.width = 8;
  info.height = 6;
  info.d = {0.1, 0.01, 0, 0, 0};
  std::vector<TestBagMessage> messages = {
      {"/camera_info", "CameraInfo", kMutatedSecond, TestCameraInfoMessage(serialization, info)}};
  int64_t time = kMutatedSecond;
  for (const auto& [encoding, bytes] : std::vector<std::pair<std::string, int>>{
           {"mono8", 1}, {"mono16", 2}, {"rgb8", 3}, {"bayer_rggb8", 1}, {"bayer_gbrg16", 2}}) {
    std::vector<uint8_t> data(static_cast<size_t>(8 * 6 * bytes));
    for (size_t i = 0; i < data.size(); ++i) data[i] = static_cast<uint8_t>(37 * i);
    time += kMutatedSecond / 10;
    messages.push_back({"/image", "Image", time, TestImageMessage(serialization, time, 8, 6, encoding, data)});
  }
  return messages;
}

std::vector<TestBagMessage> CompressedToMutate(BagSerialization serialization) {
  std::vector<TestBagMessage> messages;
  int64_t time = kMutatedSecond;
  const cv::Mat picture(6, 8, CV_8UC1, cv::Scalar(100));
  for (const std::string extension : {"png", "jpg"}) {
    std::vector<uint8_t> bytes;
    cv::imencode("." + extension, picture, bytes);
    time += kMutatedSecond / 10;
    messages.push_back({"/image", "CompressedImage", time,
                        TestCompressedMessage(serialization, time, "bayer_rggb8; " + extension, bytes)});
  }
  return messages;
}

// Changes a few places: bits, bytes, lengths, pieces that are lost or come twice, the end.
std::string Mutated(std::string text, std::mt19937_64& random) {
  const auto below = [&](size_t limit) { return static_cast<size_t>(random() % std::max<size_t>(limit, 1)); };
  for (size_t changes = 1 + below(4); changes > 0 && text.size() > 8; --changes) {
    const size_t at = below(text.size());
    switch (below(7)) {
      case 0:
        text[at] = static_cast<char>(text[at] ^ 1 << below(8));
        break;
      case 1:
        text[at] = static_cast<char>(random());
        break;
      case 2: {
        constexpr uint32_t kLimits[] = {0, 1, 0x7F, 0xFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x10000000};
        const uint32_t value = kLimits[below(std::size(kLimits))];
        const size_t begin = std::min(at, text.size() - sizeof(value));
        std::copy_n(reinterpret_cast<const char*>(&value), sizeof(value), text.begin() + begin);
        break;
      }
      case 3:
        text.erase(at, 1 + below(16));
        break;
      case 4:
        text.insert(at, text.substr(below(text.size()), 1 + below(64)));
        break;
      case 5:
        text[at] = static_cast<char>(text[at] + 1);
        break;
      default:
        if (below(8) == 0) text.resize(at);
    }
  }
  return text;
}

// What a drive reads from a bag.
void ReadWhole(const fs::path& path) {
  const BagDrive drive = FindBagDrive({path}, "");
  try {
    ReadBagCamera(drive);
  } catch (const InputError&) {
    // The images are still read.
  }
  for (const bool timed : {true, false}) {
    BagFrames frames(drive, {timed, 0});
    while (frames.Read()) {
    }
  }
}

int NumberFrom(const char* variable, int otherwise) {
  const char* value = std::getenv(variable);
  return ParseNumber<int>(value == nullptr ? "" : value).value_or(otherwise);
}

// No mutated bag does more than be refused in one line. TURNSCALE_MUTATIONS sets how many there are of each kind, and
// TURNSCALE_SEED which.
TEST(MutatedBags, AreReadOrRefused) {
  const int mutations = NumberFrom("TURNSCALE_MUTATIONS", 150);
  const auto seed = static_cast<uint64_t>(NumberFrom("TURNSCALE_SEED", 1));
  const std::vector<MutatedKind> kinds = {{"a.bag", {}},
                                          {"lz4.bag", {.compression = "lz4"}},
                                          {"bz2.bag", {.compression = "bz2"}},
                                          {"open.bag", {.indexed = false, .chunks = false}},
                                          {"a.mcap", {}},
                                          {"lz4.mcap", {.compression = "lz4"}},
                                          {"zstd.mcap", {.compression = "zstd"}},
                                          {"open.mcap", {.indexed = false, .chunks = false}},
                                          {"a.db3", {}}};
  const ScratchFolder folder;
  const fs::path path = folder.Path() / "mutated.bin";
  int read = 0;
  int refused = 0;
  for (const MutatedKind& kind : kinds) {
    for (const bool compressed : {false, true}) {
      const fs::path original = folder.Path() / kind.name;
      const BagSerialization serialization = SerializationOf(original);
      WriteTestBag(original, compressed ? CompressedToMutate(serialization) : MessagesToMutate(serialization),
                   kind.bag);
      ASSERT_NO_THROW(ReadWhole(original)) << kind.name;
      const std::string text = TextOf(original);
      std::mt19937_64 random(1000 * seed + 17 * text.size() + (compressed ? 1 : 0));
      for (int i = 0; i < (compressed ? mutations / 5 : mutations); ++i) {
        std::ofstream(path, std::ios::binary) << Mutated(text, random);
        try {
          ReadWhole(path);
          ++read;
        } catch (const InputError& error) {
          ++refused;
          ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        }
      }
    }
  }
  EXPECT_GT(read, 0);
  EXPECT_GT(refused, 0);
  RecordProperty("read", read);
  RecordProperty("refused", refused);
}

}  // namespace
}  // namespace turnscale

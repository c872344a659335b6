// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "turnscale/bag/bag_reader.h"

namespace turnscale {

/// Writes the fields of a message one after another, in either serialization.
class TestMessage {
 public:
  explicit TestMessage(BagSerialization serialization, bool big_endian = false);

  template <class Number>
  TestMessage& Add(Number value) {
    Put(reinterpret_cast<const uint8_t*>(&value), sizeof(Number));
    return *this;
  }
  TestMessage& Text(std::string_view text);
  TestMessage& Bytes(std::span<const uint8_t> bytes);
  TestMessage& Header(int64_t stamp);

  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  void Put(const uint8_t* value, size_t size);

  bool cdr_;
  bool big_endian_;
  std::vector<uint8_t> bytes_;
};

/// An image message of rows without padding.
std::vector<uint8_t> TestImageMessage(BagSerialization serialization, int64_t stamp, uint32_t width, uint32_t height,
                                      std::string_view encoding, std::span<const uint8_t> data);
std::vector<uint8_t> TestCompressedMessage(BagSerialization serialization, int64_t stamp, std::string_view format,
                                           std::span<const uint8_t> data);

/// A camera info with k = [fx 0 cx; 0 fy cy; 0 0 1].
struct TestCameraInfo {
  uint32_t width = 64;
  uint32_t height = 48;
  std::string model = "plumb_bob";
  std::vector<double> d = {0, 0, 0, 0, 0};
  std::vector<double> k = {50, 0, 31.5, 0, 51, 23.5, 0, 0, 1};
  std::vector<double> p = {40, 0, 30, 0, 0, 41, 22, 0, 0, 0, 1, 0};
  uint32_t binning = 0;
  std::vector<uint32_t> roi = {0, 0, 0, 0};
};
std::vector<uint8_t> TestCameraInfoMessage(BagSerialization serialization, const TestCameraInfo& info = {});

/// A message of a test's bag.
struct TestBagMessage {
  std::string topic;
  std::string type;  ///< such as "Image", of sensor_msgs
  int64_t logged = 0;
  std::vector<uint8_t> bytes;
};

/// How a test's bag is written. The extension of its name chooses the container.
struct TestBag {
  std::string compression = "none";  ///< of chunks: none, lz4, and bz2 (.bag) or zstd (.mcap)
  bool indexed = true;
  bool chunks = true;         ///< else messages lie in the file by themselves
  size_t chunk_messages = 2;  ///< messages in a chunk
};

void WriteTestBag(const std::filesystem::path& path, const std::vector<TestBagMessage>& messages,
                  const TestBag& bag = {});

/// The serialization of a container by its extension.
BagSerialization SerializationOf(const std::filesystem::path& path);

}  // namespace turnscale

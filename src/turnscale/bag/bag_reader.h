// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace turnscale {

/// No record, chunk or message of a bag may be larger, bytes: a damaged file shall not take all memory.
constexpr uint64_t kLargestRecord = uint64_t{256} << 20;
/// No bag may have more topics, and no name of one more bytes.
constexpr size_t kMostTopics = 65536;
constexpr size_t kLongestTopicName = 4096;

/// What the messages of a topic are, as far as a drive needs them.
enum class BagContent { kImage, kCompressedImage, kCameraInfo };

/// How the fields of a message become bytes.
enum class BagSerialization { kRos1, kCdr };

struct BagTopic {
  std::string name;
  BagContent content = BagContent::kImage;
  BagSerialization serialization = BagSerialization::kRos1;
  uint64_t messages = 0;  ///< as far as the reader knows
};

struct BagMessage {
  const BagTopic* topic = nullptr;  ///< of the reader
  int64_t logged = 0;               ///< when it was recorded, nanoseconds of the recorder's clock
  std::span<const uint8_t> bytes;   ///< valid until the next call of the reader
};

/// Reads the images and camera infos of a bag in the order in which they are stored. Memory does not grow with the
/// bag's length.
class BagReader {
 public:
  virtual ~BagReader() = default;

  /// The next message; nothing at the end. Throws InputError that names file and place where the bag is damaged or ends
  /// early.
  virtual std::optional<BagMessage> Next() = 0;

  /// Topics with images or camera infos and the numbers of their messages, from the bag's index; nothing where it has
  /// none that can be read. To be called before the first message is read.
  virtual std::optional<std::vector<BagTopic>> TopicsInIndex() = 0;
};

/// Whether the file is a bag by its first bytes (ROS 1, MCAP) or its name (.bag, .mcap, .db3).
bool IsBag(const std::filesystem::path& path);

/// Opens a ROS 1 bag, an MCAP file or a .db3 of ROS 2. Reads only these topics; empty: all. Throws InputError where the
/// file is none of them.
std::unique_ptr<BagReader> OpenBag(const std::filesystem::path& path, std::vector<std::string> topics = {});

/// Topics with images or camera infos that have a message, by name. Reads the whole bag where it has no index: of a
/// damaged bag what comes before the damage. Throws InputError, also where that is nothing.
std::vector<BagTopic> ListTopics(const std::filesystem::path& path);

/// What a ROS 1 or ROS 2 message type is for a drive; nothing for others.
std::optional<BagContent> ContentOf(std::string_view type);

/// Adds messages to the entry of the topic, which is made where there is none.
void CountMessages(std::vector<BagTopic>& topics, const BagTopic& topic, uint64_t messages);

}  // namespace turnscale

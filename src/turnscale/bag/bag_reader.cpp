// SPDX-License-Identifier: MIT
#include "turnscale/bag/bag_reader.h"

#include <algorithm>
#include <array>
#include <exception>
#include <fstream>
#include <utility>

#include "turnscale/bag/db3.h"
#include "turnscale/bag/mcap.h"
#include "turnscale/bag/ros1_bag.h"
#include "turnscale/base/error.h"
#include "turnscale/base/file_extension.h"

namespace turnscale {
namespace {

// As many as identify the formats.
std::string FirstBytes(const std::filesystem::path& path) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(path, none)) return {};
  std::array<char, 16> bytes{};
  std::ifstream stream(path, std::ios::binary);
  stream.read(bytes.data(), bytes.size());
  return {bytes.data(), static_cast<size_t>(stream.gcount())};
}

bool IsDatabase(const std::string& first) { return first == std::string_view("SQLite format 3\0", 16); }

}  // namespace

bool IsBag(const std::filesystem::path& path) {
  const std::string extension = LowerExtension(path);
  if (extension == ".bag" || extension == ".mcap" || extension == ".db3") return true;
  const std::string first = FirstBytes(path);
  return first.starts_with(kRos1Magic.substr(0, 8)) || first.starts_with(kMcapMagic);
}

std::unique_ptr<BagReader> OpenBag(const std::filesystem::path& path, std::vector<std::string> topics) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path.string() + ": is not a file");
  if (!std::ifstream(path, std::ios::binary)) throw InputError(path.string() + ": cannot be read");
  const std::string first = FirstBytes(path);
  if (first.starts_with(kRos1Magic)) return OpenRos1Bag(path, std::move(topics));
  if (first.starts_with(kRos1Magic.substr(0, 8)))
    throw InputError(path.string() + ": is a bag of an older format than 2.0; convert it with rosbag fix");
  if (first.starts_with(kMcapMagic)) return OpenMcap(path, std::move(topics));
  if (IsDatabase(first)) return OpenDb3(path, std::move(topics));
  throw InputError(path.string() + ": is not a bag of ROS 1 (.bag) or ROS 2 (.mcap, .db3)");
}

std::vector<BagTopic> ListTopics(const std::filesystem::path& path) {
  const std::unique_ptr<BagReader> indexed = OpenBag(path);
  std::optional<std::vector<BagTopic>> topics = indexed->TopicsInIndex();
  if (!topics) {
    topics.emplace();
    const std::unique_ptr<BagReader> reader = OpenBag(path);
    try {
      while (const std::optional<BagMessage> message = reader->Next()) CountMessages(*topics, *message->topic, 1);
    } catch (const InputError&) {
      if (topics->empty()) throw;
    }
  }
  std::erase_if(*topics, [](const BagTopic& topic) { return topic.messages == 0; });
  std::sort(topics->begin(), topics->end(), [](const BagTopic& a, const BagTopic& b) { return a.name < b.name; });
  return *topics;
}

std::optional<BagContent> ContentOf(std::string_view type) {
  constexpr std::string_view kPackage = "sensor_msgs/";
  constexpr std::string_view kInRos2 = "msg/";
  if (!type.starts_with(kPackage)) return std::nullopt;
  type.remove_prefix(kPackage.size());
  if (type.starts_with(kInRos2)) type.remove_prefix(kInRos2.size());
  if (type == "Image") return BagContent::kImage;
  if (type == "CompressedImage") return BagContent::kCompressedImage;
  if (type == "CameraInfo") return BagContent::kCameraInfo;
  return std::nullopt;
}

void CountMessages(std::vector<BagTopic>& topics, const BagTopic& topic, uint64_t messages) {
  const auto same = [&](const BagTopic& other) { return other.name == topic.name && other.content == topic.content; };
  auto entry = std::find_if(topics.begin(), topics.end(), same);
  if (entry == topics.end()) {
    entry = topics.insert(topics.end(), topic);
    entry->messages = 0;
  }
  entry->messages += messages;
}

}  // namespace turnscale

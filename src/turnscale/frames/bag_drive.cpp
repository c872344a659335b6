// SPDX-License-Identifier: MIT
#include "turnscale/frames/bag_drive.h"

#include <algorithm>
#include <climits>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "turnscale/bag/bag_reader.h"
#include "turnscale/bag/byte_reader.h"
#include "turnscale/bag/camera_info.h"
#include "turnscale/bag/messages.h"
#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"

namespace turnscale {
namespace {

bool IsOfImages(const BagTopic& topic) { return topic.content != BagContent::kCameraInfo; }

// Removes the topics with images and gives them.
std::vector<BagTopic> TakeImageTopics(std::vector<BagTopic>& topics, const std::filesystem::path& bag) {
  const auto infos = std::stable_partition(topics.begin(), topics.end(), IsOfImages);
  const std::vector<BagTopic> images(topics.begin(), infos);
  topics.erase(topics.begin(), infos);
  if (images.empty())
    throw InputError(bag.string() + ": holds no images (no messages of sensor_msgs Image or CompressedImage)");
  return images;
}

std::string NamesOf(const std::vector<BagTopic>& topics) {
  constexpr size_t kMostShown = 20;
  std::vector<std::string> names;
  for (const BagTopic& topic : topics) {
    if (names.size() == kMostShown) {
      names.push_back(fmt::format("and {} more", topics.size() - kMostShown));
      break;
    }
    names.push_back(Printable(topic.name));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

// When the first image of the topic was recorded, and its header stamp. Nanoseconds.
struct FirstImage {
  int64_t logged = 0;
  int64_t stamp = 0;
};

FirstImage ReadFirstImage(const std::filesystem::path& bag, const std::string& topic) {
  const std::unique_ptr<BagReader> reader = OpenBag(bag, {topic});
  while (const std::optional<BagMessage> message = reader->Next()) {
    if (!IsOfImages(*message->topic)) continue;
    try {
      return {message->logged, ReadBagStamp(*message)};
    } catch (const MalformedData& error) {
      throw InputError(fmt::format("{}: {}: image 0: {}", bag.string(), Printable(topic), error.what()));
    }
  }
  throw InputError(fmt::format("{}: holds no images on {}", bag.string(), Printable(topic)));
}

// Drivers that set no stamps leave the recorder's clock to tell. Gives the stamp of the drive's first image.
int64_t CheckBagOrder(const std::vector<std::filesystem::path>& bags, const std::string& topic) {
  const FirstImage drive = ReadFirstImage(bags.front(), topic);
  FirstImage before = drive;
  for (size_t i = 1; i < bags.size(); ++i) {
    const FirstImage first = ReadFirstImage(bags[i], topic);
    if (first.logged < before.logged || first.stamp < before.stamp) {
      throw InputError(
          fmt::format("{}: begins before {}; give the bags in their order", bags[i].string(), bags[i - 1].string()));
    }
    before = first;
  }
  return drive.stamp;
}

}  // namespace

BagDrive FindBagDrive(const std::vector<std::filesystem::path>& bags, const std::string& topic) {
  BagDrive drive;
  drive.bags = bags;
  drive.topic = topic;
  uint64_t images = 0;
  for (const std::filesystem::path& bag : bags) {
    std::vector<BagTopic> infos = ListTopics(bag);
    const std::vector<BagTopic> topics = TakeImageTopics(infos, bag);
    if (drive.topic.empty() && topics.size() > 1) {
      throw InputError(fmt::format("{}: holds images on several topics; give one of them with --topic: {}",
                                   bag.string(), NamesOf(topics)));
    }
    if (drive.topic.empty()) drive.topic = topics.front().name;
    const auto found =
        std::find_if(topics.begin(), topics.end(), [&](const auto& other) { return other.name == drive.topic; });
    if (found == topics.end()) {
      throw InputError(fmt::format("{}: holds no images on {}, but on {}", bag.string(), drive.topic, NamesOf(topics)));
    }
    images += found->messages;
    const std::string beside = CameraInfoTopic(drive.topic);
    const bool has_camera =
        std::any_of(infos.begin(), infos.end(), [&](const auto& info) { return info.name == beside; });
    if (has_camera && !drive.camera_bag) drive.camera_bag = bag;
  }
  drive.images = static_cast<int>(std::min<uint64_t>(images, INT_MAX));
  drive.first_stamp = CheckBagOrder(bags, drive.topic);
  return drive;
}

std::optional<BagCamera> ReadBagCamera(const BagDrive& drive) {
  if (!drive.camera_bag) return std::nullopt;
  const std::string topic = CameraInfoTopic(drive.topic);
  const std::string name = fmt::format("{}: {}", drive.camera_bag->string(), Printable(topic));
  const std::unique_ptr<BagReader> reader = OpenBag(*drive.camera_bag, {topic});
  while (const std::optional<BagMessage> message = reader->Next()) {
    if (IsOfImages(*message->topic)) continue;
    try {
      const auto camera = CameraOf(ReadBagCameraInfo(*message), IsRectified(drive.topic), name);
      return camera ? std::optional(BagCamera{name, *camera}) : std::nullopt;
    } catch (const MalformedData& error) {
      throw InputError(fmt::format("{}: {}; give --camera FILE", name, error.what()));
    }
  }
  return std::nullopt;
}

}  // namespace turnscale

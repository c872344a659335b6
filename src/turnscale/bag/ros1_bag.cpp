// SPDX-License-Identifier: MIT
#include "turnscale/bag/ros1_bag.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "turnscale/bag/bag_bytes.h"
#include "turnscale/bag/byte_reader.h"
#include "turnscale/bag/decompression.h"
#include "turnscale/base/error.h"

namespace turnscale {
namespace {

enum class Ros1Op : uint8_t {
  kMessage = 0x02,
  kBagHeader = 0x03,
  kChunk = 0x05,
  kChunkInfo = 0x06,
  kConnection = 0x07,
};

constexpr std::string_view kRos1Repair = "rosbag reindex";
constexpr uint32_t kLongestHeader = 1 << 20;

// Fields "name=value" of a record's or a connection's header.
class Ros1Fields {
 public:
  explicit Ros1Fields(std::span<const uint8_t> bytes) {
    ByteReader reader(bytes);
    while (reader.left() > 0) {
      const std::string_view field = reader.Text(reader.Read<uint32_t>());
      const size_t equals = field.find('=');
      if (equals == std::string_view::npos) throw MalformedData("header field without '='");
      fields_.emplace_back(field.substr(0, equals), field.substr(equals + 1));
    }
  }

  std::optional<std::string_view> Find(std::string_view name) const {
    const auto found =
        std::find_if(fields_.begin(), fields_.end(), [&](const auto& field) { return field.first == name; });
    return found == fields_.end() ? std::nullopt : std::optional(found->second);
  }

  std::string_view Text(std::string_view name) const {
    const auto value = Find(name);
    if (!value) throw MalformedData(fmt::format("record without field '{}'", name));
    return *value;
  }

  template <class Number>
  Number Read(std::string_view name) const {
    const std::string_view value = Text(name);
    if (value.size() != sizeof(Number)) throw MalformedData(fmt::format("field '{}' has a wrong size", name));
    return ByteReader({reinterpret_cast<const uint8_t*>(value.data()), value.size()}).Read<Number>();
  }

  Ros1Op Op() const { return static_cast<Ros1Op>(Read<uint8_t>("op")); }

  // Nanoseconds.
  int64_t Time(std::string_view name) const {
    const auto both = Read<uint64_t>(name);
    const auto seconds = static_cast<int64_t>(both & 0xFFFFFFFF);
    return seconds * 1'000'000'000 + static_cast<int64_t>(both >> 32);
  }

 private:
  std::vector<std::pair<std::string_view, std::string_view>> fields_;
};

class Ros1BagReader : public BagReader {
 public:
  Ros1BagReader(const std::filesystem::path& path, std::vector<std::string> topics)
      : bytes_(path), topics_(std::move(topics)) {
    bytes_.ReadRecord(kRos1Repair, [&] {
      bytes_.Skip(kRos1Magic.size());
      const Ros1Fields header = ReadHeader();
      if (header.Op() != Ros1Op::kBagHeader) throw MalformedData("first record is not a bag header");
      index_ = header.Read<uint64_t>("index_pos");
      if (!header.Find("encryptor").value_or("").empty())
        throw InputError(bytes_.name() + ": is encrypted; decrypt it with rosbag");
      bytes_.Skip(bytes_.Read<uint32_t>());
    });
  }

  std::optional<BagMessage> Next() override {
    return bytes_.ReadRecord(kRos1Repair, [&] { return Advance(); });
  }

  std::optional<std::vector<BagTopic>> TopicsInIndex() override {
    if (index_ == 0) return std::nullopt;
    auto found = bytes_.Peek([&] { return std::optional(ReadIndex()); });
    connections_.clear();
    return found;
  }

 private:
  // Its fields live until the next record is read.
  Ros1Fields ReadHeader() {
    bytes_.BeginRecord();
    const auto length = bytes_.Read<uint32_t>();
    if (length > kLongestHeader) throw MalformedData("record header is too long");
    bytes_.Read(length, header_);
    return Ros1Fields(header_);
  }

  std::vector<BagTopic> ReadIndex() {
    std::vector<BagTopic> topics;
    bytes_.Seek(index_);
    while (bytes_.left() > 0) {
      const Ros1Fields header = ReadHeader();
      bytes_.Read(bytes_.Read<uint32_t>(), stored_);
      if (header.Op() == Ros1Op::kConnection) AddConnection(header, stored_);
      if (header.Op() != Ros1Op::kChunkInfo) continue;
      ByteReader counts(stored_);
      while (counts.left() > 0) {
        const auto connection = connections_.find(counts.Read<uint32_t>());
        const auto messages = counts.Read<uint32_t>();
        if (connection == connections_.end()) throw MalformedData("chunk of an unknown connection");
        if (connection->second) CountMessages(topics, *connection->second, messages);
      }
    }
    if (connections_.empty()) throw MalformedData("index without connections");
    return topics;
  }

  void AddConnection(const Ros1Fields& header, std::span<const uint8_t> data) {
    const auto id = header.Read<uint32_t>("conn");
    if (connections_.contains(id)) return;
    if (connections_.size() == kMostTopics) throw MalformedData("too many connections");
    const std::string_view name = header.Text("topic");
    if (name.size() > kLongestTopicName) throw MalformedData("topic name is too long");
    const std::optional<BagContent> content = ContentOf(Ros1Fields(data).Text("type"));
    const bool wanted = topics_.empty() || std::find(topics_.begin(), topics_.end(), name) != topics_.end();
    connections_[id] = content && wanted ? std::optional(BagTopic{std::string(name), *content, BagSerialization::kRos1})
                                         : std::nullopt;
  }

  std::optional<BagMessage> Advance() {
    for (;;) {
      while (chunk_.left() > 0) {
        // Errors name the record that holds the chunk.
        const Ros1Fields header(chunk_.Bytes(chunk_.Read<uint32_t>()));
        const auto data = chunk_.Bytes(chunk_.Read<uint32_t>());
        if (const auto message = Take(header, data)) return message;
      }
      if (bytes_.left() == 0) return std::nullopt;
      const Ros1Fields header = ReadHeader();
      const auto size = bytes_.Read<uint32_t>();
      switch (header.Op()) {
        case Ros1Op::kChunk:
          OpenChunk(header, size);
          break;
        case Ros1Op::kMessage:
        case Ros1Op::kConnection:
          bytes_.Read(size, stored_);
          if (const auto message = Take(header, stored_)) return message;
          break;
        default:
          bytes_.Skip(size);
      }
    }
  }

  void OpenChunk(const Ros1Fields& header, uint32_t stored_size) {
    const std::string_view compression = header.Text("compression");
    const auto size = header.Read<uint32_t>("size");
    if (size > kLargestRecord) throw MalformedData(fmt::format("chunk of {} bytes is too large", size));
    bytes_.Read(stored_size, stored_);
    if (compression == "none") {
      chunk_ = ByteReader(stored_);
      return;
    }
    Decompress(compression, stored_, size, decompressed_);
    chunk_ = ByteReader(decompressed_);
  }

  std::optional<BagMessage> Take(const Ros1Fields& header, std::span<const uint8_t> data) {
    const Ros1Op op = header.Op();
    if (op == Ros1Op::kConnection) AddConnection(header, data);
    if (op != Ros1Op::kMessage) return std::nullopt;
    const auto connection = connections_.find(header.Read<uint32_t>("conn"));
    if (connection == connections_.end()) throw MalformedData("message of an unknown connection");
    if (!connection->second) return std::nullopt;
    return BagMessage{&*connection->second, header.Time("time"), data};
  }

  BagBytes bytes_;
  std::vector<std::string> topics_;
  uint64_t index_ = 0;
  std::vector<uint8_t> header_;
  std::vector<uint8_t> stored_;
  std::vector<uint8_t> decompressed_;
  ByteReader chunk_{{}};                                     // what is left of the chunk
  std::map<uint32_t, std::optional<BagTopic>> connections_;  // empty: of no use
};

}  // namespace

std::unique_ptr<BagReader> OpenRos1Bag(const std::filesystem::path& path, std::vector<std::string> topics) {
  return std::make_unique<Ros1BagReader>(path, std::move(topics));
}

}  // namespace turnscale

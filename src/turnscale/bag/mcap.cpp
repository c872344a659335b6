// SPDX-License-Identifier: MIT
#include "turnscale/bag/mcap.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <libdeflate.h>

#include "turnscale/bag/bag_bytes.h"
#include "turnscale/bag/byte_reader.h"
#include "turnscale/bag/decompression.h"
#include "turnscale/base/error.h"

namespace turnscale {
namespace {

enum class McapOp : uint8_t {
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kStatistics = 0x0B,
  kDataEnd = 0x0F,
};

constexpr std::string_view kMcapRepair = "mcap recover";
constexpr uint64_t kFooterSize = 8 + 8 + 4;

std::string_view McapText(ByteReader& reader) { return reader.Text(reader.Read<uint32_t>()); }

class McapReader : public BagReader {
 public:
  McapReader(const std::filesystem::path& path, std::vector<std::string> topics)
      : bytes_(path), topics_(std::move(topics)) {
    bytes_.ReadRecord(kMcapRepair, [&] { bytes_.Skip(kMcapMagic.size()); });
  }

  std::optional<BagMessage> Next() override {
    return bytes_.ReadRecord(kMcapRepair, [&] { return Advance(); });
  }

  std::optional<std::vector<BagTopic>> TopicsInIndex() override {
    auto found = bytes_.Peek([&] { return ReadSummary(); });
    schemas_.clear();
    channels_.clear();
    return found;
  }

 private:
  std::optional<std::vector<BagTopic>> ReadSummary() {
    const uint64_t end = 9 + kFooterSize + kMcapMagic.size();
    if (bytes_.size() < end) return std::nullopt;
    const uint64_t footer = bytes_.size() - end;
    bytes_.Seek(footer);
    if (McapOp{bytes_.Read<uint8_t>()} != McapOp::kFooter || bytes_.Read<uint64_t>() != kFooterSize)
      return std::nullopt;
    const auto summary = bytes_.Read<uint64_t>();
    if (summary == 0) return std::nullopt;
    std::optional<std::vector<BagTopic>> topics;
    bytes_.Seek(summary);
    while (bytes_.position() < footer) {
      const McapOp op{bytes_.Read<uint8_t>()};
      const auto size = bytes_.Read<uint64_t>();
      if (op != McapOp::kSchema && op != McapOp::kChannel && op != McapOp::kStatistics) {
        bytes_.Skip(size);
        continue;
      }
      bytes_.Read(size, stored_);
      if (op == McapOp::kStatistics) {
        topics = CountByStatistics();
      } else {
        Take(op, stored_);
      }
    }
    return topics;
  }

  // Nothing where the summary does not name the channels.
  std::optional<std::vector<BagTopic>> CountByStatistics() const {
    ByteReader statistics(stored_);
    const auto messages = statistics.Read<uint64_t>();
    statistics.Bytes(2 + 4 + 4 + 4 + 4 + 8 + 8);
    ByteReader counts(statistics.Bytes(statistics.Read<uint32_t>()));
    std::vector<BagTopic> topics;
    uint64_t counted = 0;
    while (counts.left() > 0) {
      const auto channel = channels_.find(counts.Read<uint16_t>());
      const auto count = counts.Read<uint64_t>();
      if (channel == channels_.end()) return std::nullopt;
      counted += count;
      if (channel->second) CountMessages(topics, *channel->second, count);
    }
    return counted == messages ? std::optional(topics) : std::nullopt;
  }

  std::optional<BagMessage> Advance() {
    for (;;) {
      while (chunk_.left() > 0) {
        // Errors name the record that holds the chunk.
        const McapOp op{chunk_.Read<uint8_t>()};
        if (const auto message = Take(op, chunk_.Bytes(chunk_.Read<uint64_t>()))) return message;
      }
      if (ended_ || bytes_.left() == 0) return std::nullopt;
      bytes_.BeginRecord();
      const McapOp op{bytes_.Read<uint8_t>()};
      const auto size = bytes_.Read<uint64_t>();
      switch (op) {
        case McapOp::kSchema:
        case McapOp::kChannel:
        case McapOp::kMessage:
          bytes_.Read(size, stored_);
          if (const auto message = Take(op, stored_)) return message;
          break;
        case McapOp::kChunk:
          OpenChunk(size);
          break;
        case McapOp::kDataEnd:
        case McapOp::kFooter:
          ended_ = true;
          break;
        default:
          bytes_.Skip(size);
      }
    }
  }

  void OpenChunk(uint64_t record_size) {
    bytes_.Read(record_size, stored_);
    ByteReader reader(stored_);
    reader.Bytes(8 + 8);
    const auto size = reader.Read<uint64_t>();
    const auto checksum = reader.Read<uint32_t>();
    const std::string_view compression = McapText(reader);
    const auto records = reader.Bytes(reader.Read<uint64_t>());
    if (size > kLargestRecord) throw MalformedData(fmt::format("chunk of {} bytes is too large", size));
    std::span<const uint8_t> content = records;
    if (!compression.empty()) {
      Decompress(compression, records, static_cast<size_t>(size), decompressed_);
      content = decompressed_;
    }
    if (checksum != 0 && libdeflate_crc32(0, content.data(), content.size()) != checksum)
      throw MalformedData("chunk with a wrong checksum");
    chunk_ = ByteReader(content);
  }

  std::optional<BagMessage> Take(McapOp op, std::span<const uint8_t> record) {
    ByteReader reader(record);
    if (op == McapOp::kSchema) AddSchema(reader);
    if (op == McapOp::kChannel) AddChannel(reader);
    if (op != McapOp::kMessage) return std::nullopt;
    const auto channel = channels_.find(reader.Read<uint16_t>());
    if (channel == channels_.end()) throw MalformedData("message of an unknown channel");
    if (!channel->second) return std::nullopt;
    reader.Read<uint32_t>();
    const auto logged = static_cast<int64_t>(reader.Read<uint64_t>());
    reader.Read<uint64_t>();
    return BagMessage{&*channel->second, logged, reader.Bytes(reader.left())};
  }

  void AddSchema(ByteReader& reader) {
    const auto id = reader.Read<uint16_t>();
    schemas_.emplace(id, ContentOf(McapText(reader)));
  }

  void AddChannel(ByteReader& reader) {
    const auto id = reader.Read<uint16_t>();
    if (channels_.contains(id)) return;
    const auto schema = schemas_.find(reader.Read<uint16_t>());
    const std::string_view name = McapText(reader);
    const std::string_view encoding = McapText(reader);
    if (name.size() > kLongestTopicName) throw MalformedData("topic name is too long");
    const bool wanted = topics_.empty() || std::find(topics_.begin(), topics_.end(), name) != topics_.end();
    const bool known = encoding == "cdr" || encoding == "ros1";
    std::optional<BagTopic>& channel = channels_[id];
    if (!wanted || !known || schema == schemas_.end() || !schema->second) return;
    channel = {std::string(name), *schema->second,
               encoding == "cdr" ? BagSerialization::kCdr : BagSerialization::kRos1};
  }

  BagBytes bytes_;
  std::vector<std::string> topics_;
  bool ended_ = false;
  std::vector<uint8_t> stored_;
  std::vector<uint8_t> decompressed_;
  ByteReader chunk_{{}};                                   // what is left of the chunk
  std::map<uint16_t, std::optional<BagContent>> schemas_;  // empty: of no use
  std::map<uint16_t, std::optional<BagTopic>> channels_;   // empty: of no use
};

}  // namespace

std::unique_ptr<BagReader> OpenMcap(const std::filesystem::path& path, std::vector<std::string> topics) {
  return std::make_unique<McapReader>(path, std::move(topics));
}

}  // namespace turnscale

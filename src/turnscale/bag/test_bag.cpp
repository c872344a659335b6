// SPDX-License-Identifier: MIT
#include "turnscale/bag/test_bag.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <stdexcept>
#include <utility>

#include <bzlib.h>
#include <libdeflate.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zstd.h>

#include "turnscale/bag/mcap.h"
#include "turnscale/bag/ros1_bag.h"

namespace turnscale {
namespace {

constexpr int64_t kTestSecond = 1'000'000'000;

// Little-endian bytes, as this machine's.
class TestBytes {
 public:
  template <class Number>
  TestBytes& Add(Number value) {
    const auto* bytes = reinterpret_cast<const char*>(&value);
    text_.append(bytes, sizeof(Number));
    return *this;
  }
  TestBytes& Raw(std::string_view text) {
    text_ += text;
    return *this;
  }
  // With its length before it.
  TestBytes& Text(std::string_view text) { return Add(static_cast<uint32_t>(text.size())).Raw(text); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string AsText(const std::vector<uint8_t>& bytes) { return {bytes.begin(), bytes.end()}; }

std::string Compressed(const std::string& compression, const std::string& text) {
  std::string out(2 * text.size() + 4096, '\0');
  size_t size = 0;
  if (compression == "lz4") {
    size = LZ4F_compressFrame(out.data(), out.size(), text.data(), text.size(), nullptr);
  } else if (compression == "zstd") {
    size = ZSTD_compress(out.data(), out.size(), text.data(), text.size(), 1);
  } else if (compression == "bz2") {
    auto written = static_cast<unsigned>(out.size());
    std::string in = text;
    BZ2_bzBuffToBuffCompress(out.data(), &written, in.data(), static_cast<unsigned>(in.size()), 1, 0, 0);
    size = written;
  } else {
    return text;
  }
  return out.substr(0, size);
}

std::string Field(std::string_view name, std::string_view value) {
  return TestBytes().Text(std::string(name) + "=" + std::string(value)).text();
}

template <class Number>
std::string NumberField(std::string_view name, Number value) {
  return Field(name, TestBytes().Add(value).text());
}

uint64_t Ros1Time(int64_t time) {
  return static_cast<uint64_t>(time / kTestSecond) | static_cast<uint64_t>(time % kTestSecond) << 32;
}

std::string Ros1Record(const std::string& header, const std::string& data) {
  return TestBytes().Text(header).Text(data).text();
}

std::string Ros1Connection(uint32_t id, const TestBagMessage& message) {
  return Ros1Record(NumberField<uint8_t>("op", 7) + NumberField("conn", id) + Field("topic", message.topic),
                    Field("topic", message.topic) + Field("type", "sensor_msgs/" + message.type) +
                        Field("md5sum", std::string(32, '0')) + Field("message_definition", ""));
}

// Groups of messages that are stored together.
std::vector<std::vector<TestBagMessage>> Grouped(const std::vector<TestBagMessage>& messages, size_t size) {
  std::vector<std::vector<TestBagMessage>> groups;
  for (const TestBagMessage& message : messages) {
    if (groups.empty() || groups.back().size() == size) groups.emplace_back();
    groups.back().push_back(message);
  }
  return groups;
}

std::string Ros1Text(const std::vector<TestBagMessage>& messages, const TestBag& bag) {
  std::map<std::string, uint32_t> ids;
  std::map<std::string, std::string> connections;
  for (const TestBagMessage& message : messages) {
    const auto [entry, added] = ids.emplace(message.topic, ids.size());
    if (added) connections[message.topic] = Ros1Connection(entry->second, message);
  }
  const auto header = [&](uint64_t index, uint32_t chunks) {
    const std::string fields = NumberField<uint8_t>("op", 3) + NumberField("index_pos", index) +
                               NumberField("conn_count", static_cast<uint32_t>(ids.size())) +
                               NumberField("chunk_count", chunks);
    return std::string(kRos1Magic) + Ros1Record(fields, std::string(4096 - 8 - fields.size(), ' '));
  };
  std::string body;
  std::string infos;
  std::map<std::string, bool> written;
  const auto groups = Grouped(messages, bag.chunk_messages);
  for (const auto& group : groups) {
    std::string chunk;
    std::map<uint32_t, uint32_t> counts;
    for (const TestBagMessage& message : group) {
      const uint32_t id = ids[message.topic];
      if (!std::exchange(written[message.topic], true)) chunk += connections[message.topic];
      ++counts[id];
      chunk += Ros1Record(
          NumberField<uint8_t>("op", 2) + NumberField("conn", id) + NumberField("time", Ros1Time(message.logged)),
          AsText(message.bytes));
    }
    std::string data;
    for (const auto& [id, count] : counts) data += TestBytes().Add(id).Add(count).text();
    infos += Ros1Record(NumberField<uint8_t>("op", 6) + NumberField<uint32_t>("ver", 1) +
                            NumberField<uint64_t>("chunk_pos", header(0, 0).size() + body.size()) +
                            NumberField("start_time", Ros1Time(group.front().logged)) +
                            NumberField("end_time", Ros1Time(group.back().logged)) +
                            NumberField("count", static_cast<uint32_t>(counts.size())),
                        data);
    if (!bag.chunks) {
      body += chunk;
      continue;
    }
    body += Ros1Record(NumberField<uint8_t>("op", 5) + Field("compression", bag.compression) +
                           NumberField("size", static_cast<uint32_t>(chunk.size())),
                       Compressed(bag.compression, chunk));
  }
  if (!bag.indexed) return header(0, 0) + body;
  std::string index;
  for (const auto& [topic, connection] : connections) index += connection;
  const auto chunks = static_cast<uint32_t>(groups.size());
  return header(header(0, 0).size() + body.size(), chunks) + body + index + infos;
}

std::string McapRecord(uint8_t op, const std::string& content) {
  return TestBytes().Add(op).Add(static_cast<uint64_t>(content.size())).Raw(content).text();
}

std::string McapText(const std::vector<TestBagMessage>& messages, const TestBag& bag) {
  std::map<std::string, uint16_t> ids;
  std::string channels;
  std::map<uint16_t, uint64_t> counts;
  for (const TestBagMessage& message : messages) {
    const auto [entry, added] = ids.emplace(message.topic, static_cast<uint16_t>(ids.size() + 1));
    ++counts[entry->second];
    if (!added) continue;
    channels += McapRecord(
        3,
        TestBytes().Add(entry->second).Text("sensor_msgs/msg/" + message.type).Text("ros2msg").Add(uint32_t{0}).text());
    channels += McapRecord(
        4, TestBytes().Add(entry->second).Add(entry->second).Text(message.topic).Text("cdr").Add(uint32_t{0}).text());
  }
  std::string file = std::string(kMcapMagic) + McapRecord(1, TestBytes().Text("ros2").Text("test").text());
  bool first = true;
  for (const auto& group : Grouped(messages, bag.chunk_messages)) {
    std::string chunk = std::exchange(first, false) ? channels : "";
    for (const TestBagMessage& message : group) {
      chunk += McapRecord(5, TestBytes()
                                 .Add(ids[message.topic])
                                 .Add(uint32_t{0})
                                 .Add(message.logged)
                                 .Add(message.logged)
                                 .Raw(AsText(message.bytes))
                                 .text());
    }
    if (!bag.chunks) {
      file += chunk;
      continue;
    }
    const auto checksum =
        static_cast<uint32_t>(libdeflate_crc32(0, reinterpret_cast<const uint8_t*>(chunk.data()), chunk.size()));
    const std::string records = Compressed(bag.compression, chunk);
    file += McapRecord(6, TestBytes()
                              .Add(group.front().logged)
                              .Add(group.back().logged)
                              .Add(static_cast<uint64_t>(chunk.size()))
                              .Add(checksum)
                              .Text(bag.compression == "none" ? "" : bag.compression)
                              .Add(static_cast<uint64_t>(records.size()))
                              .Raw(records)
                              .text());
  }
  file += McapRecord(15, TestBytes().Add(uint32_t{0}).text());
  const uint64_t summary = file.size();
  if (bag.indexed) {
    TestBytes statistics;
    statistics.Add(static_cast<uint64_t>(messages.size())).Raw(std::string(2 + 4 * 4 + 8 + 8, '\0'));
    TestBytes map;
    for (const auto& [id, count] : counts) map.Add(id).Add(count);
    file += channels + McapRecord(11, statistics.Text(map.text()).text());
  }
  return file + McapRecord(2, TestBytes().Add(bag.indexed ? summary : 0).Add(uint64_t{0}).Add(uint32_t{0}).text()) +
         std::string(kMcapMagic);
}

void WriteTestDb3(const std::filesystem::path& path, const std::vector<TestBagMessage>& messages) {
  std::filesystem::remove(path);
  sqlite3* database = nullptr;
  const auto check = [&](int result) {
    if (result != SQLITE_OK && result != SQLITE_DONE) throw std::runtime_error(sqlite3_errmsg(database));
  };
  check(sqlite3_open(path.c_str(), &database));
  check(sqlite3_exec(database,
                     "CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,"
                     "serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL);"
                     "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,"
                     "timestamp INTEGER NOT NULL,data BLOB NOT NULL);"
                     "CREATE INDEX timestamp_idx ON messages (timestamp ASC); BEGIN",
                     nullptr, nullptr, nullptr));
  std::map<std::string, int> ids;
  for (const TestBagMessage& message : messages) {
    const auto [entry, added] = ids.emplace(message.topic, static_cast<int>(ids.size()) + 1);
    if (added) {
      const std::string insert = "INSERT INTO topics VALUES(" + std::to_string(entry->second) + ",'" + message.topic +
                                 "','sensor_msgs/msg/" + message.type + "','cdr','')";
      check(sqlite3_exec(database, insert.c_str(), nullptr, nullptr, nullptr));
    }
    sqlite3_stmt* statement = nullptr;
    check(sqlite3_prepare_v2(database, "INSERT INTO messages(topic_id,timestamp,data) VALUES(?,?,?)", -1, &statement,
                             nullptr));
    sqlite3_bind_int(statement, 1, entry->second);
    sqlite3_bind_int64(statement, 2, message.logged);
    sqlite3_bind_blob(statement, 3, message.bytes.data(), static_cast<int>(message.bytes.size()), SQLITE_TRANSIENT);
    check(sqlite3_step(statement));
    sqlite3_finalize(statement);
  }
  check(sqlite3_exec(database, "COMMIT", nullptr, nullptr, nullptr));
  sqlite3_close(database);
}

}  // namespace

TestMessage::TestMessage(BagSerialization serialization, bool big_endian)
    : cdr_(serialization == BagSerialization::kCdr), big_endian_(big_endian) {
  if (cdr_) bytes_ = {0, static_cast<uint8_t>(big_endian ? 0 : 1), 0, 0};
}

void TestMessage::Put(const uint8_t* value, size_t size) {
  while (cdr_ && (bytes_.size() - 4) % size != 0) bytes_.push_back(0);
  bytes_.insert(bytes_.end(), value, value + size);
  if (big_endian_) std::reverse(bytes_.end() - static_cast<std::ptrdiff_t>(size), bytes_.end());
}

TestMessage& TestMessage::Text(std::string_view text) {
  Add(static_cast<uint32_t>(text.size() + (cdr_ ? 1 : 0)));
  bytes_.insert(bytes_.end(), text.begin(), text.end());
  if (cdr_) bytes_.push_back(0);
  return *this;
}

TestMessage& TestMessage::Bytes(std::span<const uint8_t> bytes) {
  Add(static_cast<uint32_t>(bytes.size()));
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  return *this;
}

TestMessage& TestMessage::Header(int64_t stamp) {
  if (!cdr_) Add(uint32_t{7});
  return Add(static_cast<uint32_t>(stamp / kTestSecond)).Add(static_cast<uint32_t>(stamp % kTestSecond)).Text("camera");
}

std::vector<uint8_t> TestImageMessage(BagSerialization serialization, int64_t stamp, uint32_t width, uint32_t height,
                                      std::string_view encoding, std::span<const uint8_t> data) {
  TestMessage message(serialization);
  const auto step = static_cast<uint32_t>(data.size() / height);
  message.Header(stamp).Add(height).Add(width).Text(encoding).Add(uint8_t{0}).Add(step).Bytes(data);
  return message.bytes();
}

std::vector<uint8_t> TestCompressedMessage(BagSerialization serialization, int64_t stamp, std::string_view format,
                                           std::span<const uint8_t> data) {
  return TestMessage(serialization).Header(stamp).Text(format).Bytes(data).bytes();
}

std::vector<uint8_t> TestCameraInfoMessage(BagSerialization serialization, const TestCameraInfo& info) {
  TestMessage message(serialization);
  message.Header(0).Add(info.height).Add(info.width).Text(info.model).Add(static_cast<uint32_t>(info.d.size()));
  for (const double value : info.d) message.Add(value);
  for (const double value : info.k) message.Add(value);
  for (int i = 0; i < 9; ++i) message.Add(double{0});
  for (const double value : info.p) message.Add(value);
  message.Add(info.binning).Add(info.binning);
  for (const uint32_t value : info.roi) message.Add(value);
  return message.Add(uint8_t{0}).bytes();
}

void WriteTestBag(const std::filesystem::path& path, const std::vector<TestBagMessage>& messages, const TestBag& bag) {
  if (path.extension() == ".db3") return WriteTestDb3(path, messages);
  std::ofstream(path, std::ios::binary) << (path.extension() == ".bag" ? Ros1Text(messages, bag)
                                                                       : McapText(messages, bag));
}

BagSerialization SerializationOf(const std::filesystem::path& path) {
  return path.extension() == ".bag" ? BagSerialization::kRos1 : BagSerialization::kCdr;
}

}  // namespace turnscale

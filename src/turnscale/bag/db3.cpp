// SPDX-License-Identifier: MIT
#include "turnscale/bag/db3.h"

#include <algorithm>
#include <limits>
#include <map>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <sqlite3.h>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"

namespace turnscale {
namespace {

struct FinalizeStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Db3Statement = std::unique_ptr<sqlite3_stmt, FinalizeStatement>;

// The file as a URI. It is read as it is, without locks, unless a recorder left a log of changes beside it.
std::string Db3Uri(const std::filesystem::path& path) {
  std::error_code none;
  std::string uri = "file:";
  for (const unsigned char c : std::filesystem::absolute(path, none).string()) {
    if (c == '?' || c == '#' || c == '%') {
      uri += fmt::format("%{:02X}", c);
    } else {
      uri += static_cast<char>(c);
    }
  }
  const bool logged = std::filesystem::exists(path.string() + "-wal", none);
  return uri + (logged ? "?mode=ro" : "?immutable=1");
}

class Db3Reader : public BagReader {
 public:
  Db3Reader(const std::filesystem::path& path, std::vector<std::string> topics)
      : name_(path.string()), topics_(std::move(topics)) {
    sqlite3* database = nullptr;
    const int result = sqlite3_open_v2(Db3Uri(path).c_str(), &database,
                                       SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, nullptr);
    database_.reset(database);
    if (result != SQLITE_OK) Refuse();
    sqlite3_limit(database, SQLITE_LIMIT_LENGTH, static_cast<int>(kLargestRecord));
    // What a file from elsewhere defines is not run: tables are read, nothing else.
    sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(database, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
    sqlite3_db_config(database, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
    ReadTopics();
    messages_ = Prepare("SELECT id, topic_id, timestamp, data FROM messages ORDER BY id");
  }

  std::optional<BagMessage> Next() override {
    while (Step(messages_.get())) {
      const int64_t id = sqlite3_column_int64(messages_.get(), 0);
      CheckOrder(id);
      const auto topic = by_id_.find(sqlite3_column_int64(messages_.get(), 1));
      if (topic == by_id_.end()) continue;
      const int64_t logged = sqlite3_column_int64(messages_.get(), 2);
      const auto* data = static_cast<const uint8_t*>(sqlite3_column_blob(messages_.get(), 3));
      const int size = sqlite3_column_bytes(messages_.get(), 3);
      // As for text, and for data that cannot be read.
      if (data == nullptr) throw InputError(fmt::format("{}: message {} has no data; record it again", name_, id));
      return BagMessage{&topic->second, logged, {data, static_cast<size_t>(size)}};
    }
    return std::nullopt;
  }

  std::optional<std::vector<BagTopic>> TopicsInIndex() override {
    std::vector<BagTopic> topics;
    const Db3Statement rows = Prepare("SELECT id, topic_id FROM messages ORDER BY id");
    try {
      while (Step(rows.get())) {
        CheckOrder(sqlite3_column_int64(rows.get(), 0));
        const auto topic = by_id_.find(sqlite3_column_int64(rows.get(), 1));
        if (topic != by_id_.end()) CountMessages(topics, topic->second, 1);
      }
    } catch (const InputError&) {
      if (topics.empty()) throw;
    }
    latest_ = std::numeric_limits<int64_t>::min();
    return topics;
  }

 private:
  struct Close {
    void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
  };

  [[noreturn]] void Refuse() const {
    throw InputError(fmt::format("{}: cannot be read as a bag of ROS 2: {}; record it again", name_,
                                 database_ ? Printable(sqlite3_errmsg(database_.get())) : "out of memory"));
  }

  Db3Statement Prepare(const char* query) const {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database_.get(), query, -1, &statement, nullptr) != SQLITE_OK) Refuse();
    return Db3Statement(statement);
  }

  bool Step(sqlite3_stmt* statement) const {
    const int result = sqlite3_step(statement);
    if (result == SQLITE_NOMEM) throw std::bad_alloc();
    if (result != SQLITE_ROW && result != SQLITE_DONE) Refuse();
    return result == SQLITE_ROW;
  }

  // Pages of a damaged file may lead in a circle.
  void CheckOrder(int64_t id) {
    if (id <= latest_) throw InputError(fmt::format("{}: message {} comes twice; record it again", name_, id));
    latest_ = id;
  }

  void ReadTopics() {
    const Db3Statement rows = Prepare("SELECT id, name, type, serialization_format FROM topics ORDER BY id");
    for (size_t number = 0; Step(rows.get()); ++number) {
      if (number == kMostTopics) throw InputError(name_ + ": has too many topics");
      const auto text = [&](int column) {
        const auto* value = reinterpret_cast<const char*>(sqlite3_column_text(rows.get(), column));
        return value == nullptr ? std::string() : std::string(value);
      };
      const std::string name = text(1);
      if (name.size() > kLongestTopicName) throw InputError(name_ + ": has a topic name that is too long");
      const std::optional<BagContent> content = ContentOf(text(2));
      const bool wanted = topics_.empty() || std::find(topics_.begin(), topics_.end(), name) != topics_.end();
      if (!content || !wanted || text(3) != "cdr") continue;
      by_id_[sqlite3_column_int64(rows.get(), 0)] = {name, *content, BagSerialization::kCdr};
    }
  }

  std::string name_;
  std::vector<std::string> topics_;
  std::unique_ptr<sqlite3, Close> database_;
  std::map<int64_t, BagTopic> by_id_;
  Db3Statement messages_;
  int64_t latest_ = std::numeric_limits<int64_t>::min();
};

}  // namespace

std::unique_ptr<BagReader> OpenDb3(const std::filesystem::path& path, std::vector<std::string> topics) {
  return std::make_unique<Db3Reader>(path, std::move(topics));
}

}  // namespace turnscale

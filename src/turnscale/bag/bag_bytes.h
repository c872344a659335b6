// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "turnscale/bag/byte_reader.h"

namespace turnscale {

/// The bytes of a file, read one after another. Nothing is allocated that the file does not hold.
class BagBytes {
 public:
  /// Throws InputError if the file cannot be read.
  explicit BagBytes(const std::filesystem::path& path);

  uint64_t size() const { return size_; }
  uint64_t position() const { return position_; }
  uint64_t left() const { return size_ - position_; }
  const std::string& name() const { return name_; }

  /// Throws MalformedData beyond the end of the file.
  void Seek(uint64_t position);
  void Skip(uint64_t count);
  /// Throws MalformedData if the file ends before, or there are more than kLargestRecord, InputError if the disk fails.
  void Read(uint64_t count, std::vector<uint8_t>& bytes);
  void Read(std::span<uint8_t> bytes);

  /// A little-endian number.
  template <class Number>
  Number Read() {
    std::array<uint8_t, sizeof(Number)> bytes;
    Read(std::span<uint8_t>(bytes));
    return ByteReader(bytes).Read<Number>();
  }

  /// A record begins at the present position: ReadRecord names it in its message.
  void BeginRecord() { record_ = position_; }

  /// Result of `work`, a function without arguments, which begins a record. Where it throws MalformedData, this throws
  /// InputError that names the file, the latest record, and the program that repairs such files.
  template <class Work>
  auto ReadRecord(std::string_view repair, const Work& work) {
    BeginRecord();
    try {
      return work();
    } catch (const MalformedData& error) {
      RefuseRecord(error.what(), repair);
    }
  }

  /// Result of `work`, a function that returns an optional; empty where it throws MalformedData. The position is the
  /// same afterwards.
  template <class Work>
  auto Peek(const Work& work) {
    const uint64_t begin = position_;
    decltype(work()) found;
    try {
      found = work();
    } catch (const MalformedData&) {
      found.reset();
    }
    Seek(begin);
    return found;
  }

 private:
  [[noreturn]] void RefuseRecord(std::string_view what, std::string_view repair) const;

  std::string name_;
  std::ifstream stream_;
  uint64_t size_ = 0;
  uint64_t position_ = 0;
  uint64_t record_ = 0;  ///< where the latest record begins
};

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
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

 private:
  std::string name_;
  std::ifstream stream_;
  uint64_t size_ = 0;
  uint64_t position_ = 0;
};

}  // namespace turnscale

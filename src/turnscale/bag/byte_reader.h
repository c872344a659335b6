// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string_view>

namespace turnscale {

/// Bytes that are not what their format says. The message says what is wrong; whoever knows the file adds where.
class MalformedData : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads numbers and byte strings one after another, and never beyond the end: throws MalformedData there.
class ByteReader {
 public:
  explicit ByteReader(std::span<const uint8_t> bytes, std::endian order = std::endian::little)
      : bytes_(bytes), order_(order) {}

  size_t position() const { return position_; }
  size_t left() const { return bytes_.size() - position_; }

  std::span<const uint8_t> Bytes(uint64_t count) {
    if (count > left()) throw MalformedData("data end early");
    const auto read = bytes_.subspan(position_, static_cast<size_t>(count));
    position_ += read.size();
    return read;
  }

  std::string_view Text(uint64_t count) {
    const auto read = Bytes(count);
    return {reinterpret_cast<const char*>(read.data()), read.size()};
  }

  template <class Number>
  Number Read() {
    uint8_t stored[sizeof(Number)];
    const auto read = Bytes(sizeof(Number));
    std::copy(read.begin(), read.end(), stored);
    if (order_ != std::endian::native) std::reverse(stored, stored + sizeof(Number));
    Number value;
    std::memcpy(&value, stored, sizeof(Number));
    return value;
  }

  /// Passes over what fills the place up to a multiple of `size` bytes from the beginning.
  void Align(size_t size) { Bytes((size - position_ % size) % size); }

 private:
  std::span<const uint8_t> bytes_;
  std::endian order_;
  size_t position_ = 0;
};

}  // namespace turnscale

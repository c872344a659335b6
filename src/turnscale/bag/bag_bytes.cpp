// SPDX-License-Identifier: MIT
#include "turnscale/bag/bag_bytes.h"

#include <cerrno>
#include <system_error>

#include <fmt/format.h>

#include "turnscale/bag/bag_reader.h"
#include "turnscale/base/error.h"

namespace turnscale {

BagBytes::BagBytes(const std::filesystem::path& path) : name_(path.string()), stream_(path, std::ios::binary) {
  std::error_code error;
  size_ = std::filesystem::file_size(path, error);
  if (!stream_ || error) throw InputError(name_ + ": cannot be read");
}

void BagBytes::Seek(uint64_t position) {
  if (position > size_) throw MalformedData("the file ends early");
  stream_.seekg(static_cast<std::streamoff>(position));
  position_ = position;
}

void BagBytes::Skip(uint64_t count) {
  if (count > left()) throw MalformedData("the file ends early");
  if (count > 0) Seek(position_ + count);
}

void BagBytes::Read(uint64_t count, std::vector<uint8_t>& bytes) {
  if (count > left()) throw MalformedData("the file ends early");
  if (count > kLargestRecord) throw MalformedData("record of " + std::to_string(count) + " bytes is too large");
  bytes.resize(static_cast<size_t>(count));
  Read(std::span<uint8_t>(bytes));
}

void BagBytes::Read(std::span<uint8_t> bytes) {
  if (bytes.size() > left()) throw MalformedData("the file ends early");
  errno = 0;
  if (!stream_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()))) {
    throw InputError(name_ + ": cannot be read at byte " + std::to_string(position_) +
                     (errno == 0 ? std::string() : ": " + std::generic_category().message(errno)));
  }
  position_ += bytes.size();
}

void BagBytes::RefuseRecord(std::string_view what, std::string_view repair) const {
  throw InputError(
      fmt::format("{}: {} (record at byte {}); repair it with {}, or record it again", name_, what, record_, repair));
}

}  // namespace turnscale

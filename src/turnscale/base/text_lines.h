// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <istream>
#include <string>
#include <string_view>
#include <utility>

#include "turnscale/base/error.h"
#include "turnscale/base/input_file.h"

namespace turnscale {

/// With which some editors and spreadsheets begin a text in UTF-8.
inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// A text read line by line, without line ends of any system and without a byte-order mark.
/// Throws InputError for what is no such text: UTF-16, bytes of zero, a line above a megabyte.
class TextLines {
 public:
  /// `name` stands for the text in messages.
  TextLines(std::istream& stream, std::string name) : stream_(&stream), name_(std::move(name)) {}

  /// Throws InputError where the file cannot be opened. `kind` says what it should be, such as "camera file".
  TextLines(const std::filesystem::path& path, std::string_view kind)
      : file_(OpenInputFile(path, kind)), name_(path.string()) {}

  TextLines(const TextLines&) = delete;
  TextLines& operator=(const TextLines&) = delete;

  /// Goes to the next line; false at the end.
  bool Next() {
    if (!Read()) return false;
    if (++number_ == 1) {
      if (line_.starts_with("\xFF\xFE") || line_.starts_with("\xFE\xFF"))
        throw InputError(name_ + ": is text in UTF-16; save it as UTF-8");
      if (line_.starts_with(kByteOrderMark)) line_.erase(0, kByteOrderMark.size());
    }
    if (line_.size() > kLongest || line_.find('\0') != std::string::npos)
      throw InputError(Where() + ": is not text in UTF-8; give a text file, saved as UTF-8");
    if (line_.ends_with('\r')) line_.pop_back();
    return true;
  }

  const std::string& Line() const { return line_; }
  /// Of the line, from 1.
  int Number() const { return number_; }
  /// "name:line".
  std::string Where() const { return name_ + ":" + std::to_string(number_); }
  const std::string& Name() const { return name_; }

 private:
  static constexpr std::size_t kLongest = 1 << 20;

  std::istream& Stream() { return stream_ ? *stream_ : file_; }

  // The next line, or the beginning of one that is too long; false at the end.
  bool Read() {
    std::array<char, 1024> part{};
    line_.clear();
    std::istream& stream = Stream();
    while (line_.size() <= kLongest) {
      stream.getline(part.data(), part.size());
      const auto count = static_cast<std::size_t>(stream.gcount());
      if (stream.bad()) throw InputError(name_ + ": cannot be read to its end");
      const bool ended = !stream.fail() && !stream.eof();
      line_.append(part.data(), ended ? count - 1 : count);
      if (ended) return true;
      if (stream.eof()) return count > 0 || !line_.empty();
      stream.clear(stream.rdstate() & ~std::ios::failbit);
    }
    return true;
  }

  std::ifstream file_;
  std::istream* stream_ = nullptr;  // else `file_` is read
  std::string name_;
  std::string line_;
  int number_ = 0;
};

}  // namespace turnscale

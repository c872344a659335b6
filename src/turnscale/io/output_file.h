// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace turnscale {

/// A file that grows by whole lines. Nothing fails in silence: every write reaches the system before it returns.
class OutputFile {
 public:
  enum class Mode { kTruncate, kAppend };

  /// Throws InputError where the file cannot be made.
  explicit OutputFile(const std::filesystem::path& path, Mode mode = Mode::kTruncate);
  /// The same; messages say `name`.
  OutputFile(const std::filesystem::path& path, Mode mode, std::string name);

  /// Writes and flushes. Throws OutputError where the system refuses (disk full).
  void Write(std::string_view text);
  /// Throws OutputError where the system refuses at the last moment.
  void Close();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string name_;
  std::unique_ptr<std::FILE, Closer> file_;
};

/// Puts new contents in the place of the old in one step: a reader, or an interrupt, meets either the old file or the
/// new one. A link keeps pointing where it did. Throws as OutputFile does.
void ReplaceFile(const std::filesystem::path& path, std::string_view contents);

/// Writes to standard output, to the end. Throws OutputError where the system refuses.
void WriteStandardOutput(std::string_view text);

}  // namespace turnscale

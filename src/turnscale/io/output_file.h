// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

namespace turnscale {

/// What a file that is whole survives.
enum class Durability {
  kProcess,   ///< the end of the process, whatever ends it
  kPowerCut,  ///< that of the machine, too; the disk takes some milliseconds for it
};

/// The name of a file while it is being written: `path` with ".part" after it.
std::filesystem::path PartOf(const std::filesystem::path& path);

/// A file that grows as PartOf its path and gets its own name when it is whole: whatever ends the process, nothing
/// incomplete is found under that name. A link keeps pointing where it did. A device or pipe takes the text as it
/// comes. Nothing fails in silence: every write reaches the system before it returns.
class OutputFile {
 public:
  /// Throws InputError where the file cannot be made, OutputError where the machine is to blame (disk full).
  explicit OutputFile(const std::filesystem::path& path);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  /// A file that was not finished keeps its part.
  ~OutputFile();

  /// Throws OutputError where the system refuses (disk full); nothing of the text is in the file then.
  void Write(std::string_view text);
  /// Gives the file its name, in the place of an older one. Throws OutputError where the system refuses.
  void Finish(Durability durability = Durability::kPowerCut);
  /// Takes the part away.
  void Discard();

 private:
  [[noreturn]] void Fail(int error) const;
  void Close();

  std::string name_;              // in messages
  std::filesystem::path target_;  // where links lead
  bool in_place_ = false;         // a device or pipe
  int descriptor_ = -1;
  std::size_t size_ = 0;
};

/// Puts new contents in the place of the old in one step: a reader, or whatever ends the process, meets either the old
/// file or the new one. Throws as OutputFile does.
void ReplaceFile(const std::filesystem::path& path, std::string_view contents,
                 Durability durability = Durability::kPowerCut);

/// Throws as OutputFile does where the file could not be made, and leaves nothing behind: before work that takes long.
void CheckOutputFile(const std::filesystem::path& path);

/// Throws OutputError where the machine is to blame for a place that cannot be written (disk full), else InputError
/// with `advice`. `what`: the place, and what cannot be done.
[[noreturn]] void RefusePlace(const std::string& what, const std::error_code& error, const std::string& advice);

/// Takes away an older file and its part, so that it is not found beside newer ones; devices, pipes and folders stay.
/// Throws as RefusePlace does where it cannot be taken away.
void RemoveOldFile(const std::filesystem::path& path);

}  // namespace turnscale

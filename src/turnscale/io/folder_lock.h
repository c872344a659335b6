// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace turnscale {

/// Keeps other runs, also those of other processes, from writing to a folder for as long as it lives. It leaves no file
/// behind, and ends with the process. Where the file system has no locks, nothing is kept.
class FolderLock {
 public:
  /// Throws InputError where another run has the folder.
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  ~FolderLock();

 private:
  int descriptor_ = -1;
};

}  // namespace turnscale

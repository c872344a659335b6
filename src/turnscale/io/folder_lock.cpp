// SPDX-License-Identifier: MIT
#include "turnscale/io/folder_lock.h"

#include <cerrno>
#include <chrono>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "turnscale/base/error.h"

namespace turnscale {

FolderLock::FolderLock(const std::filesystem::path& folder)
    : descriptor_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0) return;
  // Another run may have it for a moment, to see whether it is free.
  constexpr int kAttempts = 10;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (attempt > 0) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  }
  close(descriptor_);
  throw InputError(folder.string() + ": another run is writing there; choose another --out");
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  // A child that was forked meanwhile has the descriptor, too.
  flock(descriptor_, LOCK_UN);
  close(descriptor_);
}

}  // namespace turnscale

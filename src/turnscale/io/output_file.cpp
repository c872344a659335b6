// SPDX-License-Identifier: MIT
#include "turnscale/io/output_file.h"

#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

std::string SystemMessage(int error) { return std::generic_category().message(error); }

// Another place would be of no help.
bool IsOfTheMachine(int error) {
  return error == ENOSPC || error == EDQUOT || error == EIO || error == EMFILE || error == ENFILE || error == ENOMEM;
}

}  // namespace

void RefusePlace(const std::string& what, const std::error_code& error, const std::string& advice) {
  if (IsOfTheMachine(error.value())) throw OutputError(what + ": " + error.message());
  throw InputError(what + ": " + error.message() + "; " + advice);
}

fs::path PartOf(const fs::path& path) { return path.string() + ".part"; }

OutputFile::OutputFile(const fs::path& path) : name_(path.string()), target_(path) {
  std::error_code error;
  const bool exists = fs::exists(path, error);
  in_place_ = exists && !fs::is_regular_file(path, error);
  if (exists && !in_place_) target_ = fs::canonical(path, error);
  const fs::path written = in_place_ ? target_ : PartOf(target_);
  descriptor_ = open(written.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ >= 0) return;
  RefusePlace(name_ + ": cannot be written", {errno, std::generic_category()}, "choose another place");
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

void OutputFile::Write(std::string_view text) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t written = write(descriptor_, text.data() + done, text.size() - done);
    if (written >= 0) {
      done += static_cast<std::size_t>(written);
    } else if (errno != EINTR) {
      const int error = errno;
      // Half a line is worth nothing.
      if (!in_place_ && done > 0 && ftruncate(descriptor_, static_cast<off_t>(size_)) == 0) {
        lseek(descriptor_, static_cast<off_t>(size_), SEEK_SET);
      }
      Fail(error);
    }
  }
  size_ += done;
}

void OutputFile::Finish(Durability durability) {
  // Some file systems cannot be told to.
  if (durability == Durability::kPowerCut && !in_place_ && fsync(descriptor_) != 0 && errno != EINVAL) Fail(errno);
  Close();
  if (in_place_) return;
  std::error_code error;
  fs::rename(PartOf(target_), target_, error);
  if (error) Fail(error.value());
}

void OutputFile::Discard() {
  if (descriptor_ >= 0) close(descriptor_);
  descriptor_ = -1;
  std::error_code error;
  if (!in_place_) fs::remove(PartOf(target_), error);
}

void OutputFile::Close() {
  const int result = close(descriptor_);
  descriptor_ = -1;
  if (result != 0 && errno != EINTR) Fail(errno);
}

void OutputFile::Fail(int error) const { throw OutputError(name_ + ": cannot be written: " + SystemMessage(error)); }

void ReplaceFile(const fs::path& path, std::string_view contents, Durability durability) {
  OutputFile file(path);
  try {
    file.Write(contents);
    file.Finish(durability);
  } catch (...) {
    file.Discard();
    throw;
  }
}

void CheckOutputFile(const fs::path& path) {
  std::error_code none;
  // Opening a pipe would wait for its reader.
  const bool is_ordinary = !fs::exists(path, none) || fs::is_regular_file(path, none) || fs::is_directory(path, none);
  if (is_ordinary) OutputFile(path).Discard();
}

void RemoveOldFile(const fs::path& path) {
  for (const fs::path& old : {path, PartOf(path)}) {
    std::error_code error;
    if (fs::is_regular_file(old, error))
      fs::remove(old, error);
    else
      error.clear();
    if (error)
      RefusePlace(old.string() + ": is of an earlier run and cannot be removed", error, "choose another place");
  }
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/io/output_file.h"

#include <cerrno>
#include <system_error>
#include <utility>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

std::string SystemMessage(int error) { return std::generic_category().message(error); }

}  // namespace

OutputFile::OutputFile(const fs::path& path, Mode mode) : OutputFile(path, mode, path.string()) {}

OutputFile::OutputFile(const fs::path& path, Mode mode, std::string name)
    : name_(std::move(name)), file_(std::fopen(path.c_str(), mode == Mode::kAppend ? "ab" : "wb")) {
  const int error = errno;
  if (file_) return;
  if (error == ENOSPC || error == EDQUOT || error == EIO) {
    throw OutputError(name_ + ": cannot be written: " + SystemMessage(error));
  }
  throw InputError(name_ + ": cannot be written: " + SystemMessage(error) + "; choose another place");
}

void OutputFile::Write(std::string_view text) {
  const bool written = std::fwrite(text.data(), 1, text.size(), file_.get()) == text.size();
  if (!written || std::fflush(file_.get()) != 0) {
    throw OutputError(name_ + ": cannot be written: " + SystemMessage(errno));
  }
}

void OutputFile::Close() {
  if (file_ && std::fclose(file_.release()) != 0) {
    throw OutputError(name_ + ": cannot be written: " + SystemMessage(errno));
  }
}

void ReplaceFile(const fs::path& path, std::string_view contents) {
  std::error_code error;
  const bool exists = fs::exists(path, error);
  // A device or pipe takes the text as it comes; it cannot be replaced.
  if (exists && !fs::is_regular_file(path, error)) {
    OutputFile file(path);
    file.Write(contents);
    file.Close();
    return;
  }
  const fs::path target = exists ? fs::canonical(path, error) : path;
  const fs::path temporary = target.string() + ".tmp";
  try {
    OutputFile file(temporary, OutputFile::Mode::kTruncate, path.string());
    file.Write(contents);
    file.Close();
    fs::rename(temporary, target, error);
    if (error) throw OutputError(path.string() + ": cannot be replaced: " + error.message());
  } catch (...) {
    fs::remove(temporary, error);
    throw;
  }
}

void WriteStandardOutput(std::string_view text) {
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    throw OutputError("standard output: cannot be written: " + SystemMessage(errno));
  }
}

}  // namespace turnscale

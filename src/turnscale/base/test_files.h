// SPDX-License-Identifier: MIT
#pragma once

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

#include <gtest/gtest.h>
#include <unistd.h>

namespace turnscale {

/// A new folder of this process, removed with what is in it when the process exits.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string path = ::testing::TempDir() + "turnscale_XXXXXX";
    if (mkdtemp(path.data()) == nullptr) throw std::system_error(errno, std::generic_category(), path);
    path_ = path;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    if (getpid() == process_) std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const std::filesystem::path& Path() const { return path_; }

 private:
  std::filesystem::path path_;
  pid_t process_ = getpid();
};

/// A path in a folder of this process: one for each test and name.
inline std::string ScratchPath(const std::string& name) {
  static const ScratchFolder folder;
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  return folder.Path() / (std::string(test->test_suite_name()) + "_" + test->name() + "_" + name);
}

/// What a file holds.
inline std::string TextOf(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "turnscale/base/input_file.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

std::string OpeningComplaint(const fs::path& path) {
  try {
    OpenInputFile(path, "trajectory file");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(InputFile, IsOpened) {
  const std::string path = ScratchPath("a.txt");
  std::ofstream(path) << "a\r\n";
  std::ifstream stream = OpenInputFile(path, "file");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(stream), {}), "a\r\n");
}

TEST(InputFile, ComplaintsSayWhy) {
  EXPECT_EQ(OpeningComplaint("/nowhere/a.tum"), "/nowhere/a.tum: no such trajectory file");
  EXPECT_EQ(OpeningComplaint("/"), "/: is a folder, not a trajectory file");
  const std::string file = ScratchPath("a.txt");
  std::ofstream(file) << "a";
  EXPECT_EQ(OpeningComplaint(file + "/b"), file + "/b: no such trajectory file");
  const std::string loop = ScratchPath("loop");
  fs::create_symlink(loop, loop);
  EXPECT_EQ(OpeningComplaint(loop), loop + ": cannot be read: Too many levels of symbolic links");
}

TEST(InputFile, WithoutPermissionIsNotMissing) {
  if (geteuid() == 0) GTEST_SKIP() << "root may read everything";
  const fs::path folder = ScratchPath("folder");
  fs::create_directory(folder);
  std::ofstream(folder / "a.tum") << "a";
  fs::permissions(folder / "a.tum", fs::perms::none);
  const std::string file = (folder / "a.tum").string();
  EXPECT_EQ(OpeningComplaint(file), file + ": cannot be read: Permission denied");
  fs::permissions(folder, fs::perms::none);
  EXPECT_EQ(OpeningComplaint(file), file + ": cannot be read: Permission denied");
  fs::permissions(folder, fs::perms::owner_all);
}

}  // namespace
}  // namespace turnscale

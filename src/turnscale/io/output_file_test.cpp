// SPDX-License-Identifier: MIT
#include "turnscale/io/output_file.h"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

// Files of this process end at so many bytes, for as long as it lives: a disk that is full.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit = {bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_ = {};
  void (*handler_)(int);
};

TEST(OutputFile, FullDiskAndForbiddenPlaces) {
  EXPECT_THROW(OutputFile("/dev/full").Write("text"), OutputError);
  EXPECT_THROW(ReplaceFile("/dev/full", "text"), OutputError);
  EXPECT_THROW(OutputFile("/proc/nothing_may_be_made_here"), InputError);
  EXPECT_THROW(OutputFile("/nonexistent/file"), InputError);
}

TEST(OutputFile, HasItsNameOnlyWhenItIsWhole) {
  const fs::path path = ScratchPath("grows");
  OutputFile file(path);
  file.Write("a\n");
  EXPECT_FALSE(fs::exists(path));
  EXPECT_EQ(TextOf(PartOf(path)), "a\n") << "with the system at once";
  file.Write("b\n");
  file.Finish();
  EXPECT_EQ(TextOf(path), "a\nb\n");
  EXPECT_FALSE(fs::exists(PartOf(path)));
}

TEST(OutputFile, KeepsItsPartWhereItIsNotFinished) {
  const fs::path path = ScratchPath("given_up");
  ReplaceFile(path, "old");
  { OutputFile(path).Write("new\n"); }
  EXPECT_EQ(TextOf(path), "old");
  EXPECT_EQ(TextOf(PartOf(path)), "new\n");
  OutputFile(path).Discard();
  CheckOutputFile(path);
  EXPECT_FALSE(fs::exists(PartOf(path)));
}

TEST(OutputFile, AFullDiskLeavesWholeLines) {
  const fs::path path = ScratchPath("full");
  OutputFile file(path);
  {
    const FullDisk disk(1000);
    file.Write("a line\n");
    EXPECT_THROW(file.Write(std::string(2000, 'x') + "\n"), OutputError);
  }
  file.Write("another\n");
  file.Finish();
  EXPECT_EQ(TextOf(path), "a line\nanother\n");
}

TEST(OutputFile, AFullDiskLeavesTheOlderFile) {
  const fs::path path = ScratchPath("replaced");
  ReplaceFile(path, "old");
  const FullDisk disk(1000);
  EXPECT_THROW(ReplaceFile(path, std::string(2000, 'x')), OutputError);
  EXPECT_EQ(TextOf(path), "old");
  EXPECT_FALSE(fs::exists(PartOf(path)));
}

TEST(OutputFile, ReplacesInOneStepAndFollowsLinks) {
  const fs::path target = ScratchPath("target");
  const fs::path link = ScratchPath("link");
  fs::remove(link);
  ReplaceFile(target, "old");
  fs::create_symlink(target, link);
  ReplaceFile(link, "new");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(TextOf(target), "new");
  EXPECT_FALSE(fs::exists(PartOf(target)));
}

TEST(OutputFile, AKillAtAnyMomentLeavesTheOlderFileOrTheNewer) {
  const fs::path path = ScratchPath("killed");
  const std::string texts[] = {std::string(300'000, 'a') + "\n", std::string(200'000, 'b') + "\n"};
  ReplaceFile(path, texts[0]);
  for (int kill_after = 0; kill_after < 20; ++kill_after) {
    const pid_t writer = fork();
    ASSERT_GE(writer, 0);
    if (writer == 0) {
      for (int i = 0;; ++i) ReplaceFile(path, texts[i % 2], Durability::kProcess);
    }
    while (!fs::exists(PartOf(path))) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::microseconds(137 * kill_after));
    kill(writer, SIGKILL);
    waitpid(writer, nullptr, 0);
    const std::string text = TextOf(path);
    EXPECT_TRUE(text == texts[0] || text == texts[1]) << text.size() << " bytes";
    fs::remove(PartOf(path));
  }
}

TEST(OutputFile, OldFilesAreRemovedWithTheirParts) {
  const fs::path path = ScratchPath("old");
  RemoveOldFile(path);
  ReplaceFile(path, "old");
  ReplaceFile(PartOf(path), "of a run that was killed");
  RemoveOldFile(path);
  EXPECT_FALSE(fs::exists(path));
  EXPECT_FALSE(fs::exists(PartOf(path)));
  RemoveOldFile("/dev/null");
  EXPECT_TRUE(fs::exists("/dev/null"));
}

}  // namespace
}  // namespace turnscale

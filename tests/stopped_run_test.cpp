// SPDX-License-Identifier: MIT
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>

#include "command_line.h"
#include "rendered_room.h"
#include "result_files.h"
#include "turnscale/base/test_files.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 20;

class StoppedRunTest : public ::testing::Test {
 protected:
  StoppedRunTest() : folder_(ScratchPath("folder")) {
    fs::create_directories(folder_);
    WriteRoomDrive(folder_ / "drive", kFrames);
  }
  ~StoppedRunTest() override { fs::remove_all(folder_); }

  fs::path Out() const { return folder_ / "out"; }
  std::vector<std::string> Arguments(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"run", (folder_ / "drive").string(), "--out", Out().string(), "--lever-arm",
                                          "1.5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  fs::path folder_;
};

TEST_F(StoppedRunTest, AKillAtAnyMomentLeavesWholeFilesOrNone) {
  for (const char* moment : {"frame 2/", "frame 8/", "frame 14/", "frame 20/"}) {
    Command command(Arguments(), folder_);
    ASSERT_TRUE(command.WaitForError(moment));
    command.Signal(SIGKILL);
    command.Wait();
    // There is no folder before the first pose.
    if (fs::exists(Out())) ExpectWholeFiles(Out());
  }
  // What such a run leaves is in nobody's way.
  ASSERT_EQ(RunCommand(Arguments({"--quiet"}), folder_).exit_code, 0);
  ExpectWholeFiles(Out());
  for (const auto& entry : fs::directory_iterator(Out())) EXPECT_NE(entry.path().extension(), ".part") << entry.path();
}

TEST_F(StoppedRunTest, AFileThatIsTooLargeForTheDiskKeepsNoOther) {
  ASSERT_EQ(RunCommand(Arguments({"--quiet"}), folder_).exit_code, 0);
  std::uintmax_t second = 0;
  for (const auto& entry : fs::recursive_directory_iterator(Out())) {
    if (entry.path().filename() != "report.html" && entry.is_regular_file())
      second = std::max(second, fs::file_size(entry.path()));
  }
  const auto limit = static_cast<unsigned>(second) + 100;
  ASSERT_GT(fs::file_size(Out() / "report.html"), limit) << "the largest, else the test needs another";
  const CommandResult result = Command(Arguments({"--quiet"}), folder_, {}, limit).Wait();
  ExpectComplaint(result, 1, {"report.html: cannot be written: File too large; the results so far are in"});
  EXPECT_FALSE(fs::exists(Out() / "report.html")) << "neither a part nor that of the run before";
  EXPECT_EQ(ReadTrajectory(Out() / "trajectory.tum").size(), static_cast<size_t>(kFrames));
  EXPECT_TRUE(fs::exists(Out() / "turns.csv"));
  const auto summary = nlohmann::json::parse(TextOf(Out() / "summary.json"));
  EXPECT_TRUE(summary["complete"].get<bool>()) << "the report is made of it";
  EXPECT_TRUE(fs::exists(Out() / "map.ply"));
}

TEST_F(StoppedRunTest, NothingThatATerminalObeysGetsThere) {
  const std::string clear = "\x1b[2J\x07\x9b\x7f";
  const auto expect_tame = [&](const std::vector<std::string>& more, int exit_code, const std::string& part) {
    const CommandResult result = RunCommand(Arguments(more), folder_);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_NE(result.err.find(part), std::string::npos) << result.err;
    const auto tame = [](unsigned char c) { return c == '\n' || (c >= 0x20 && c < 0x7f); };
    EXPECT_TRUE(std::ranges::all_of(result.out + result.err, tame)) << result.out << result.err;
  };
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  };
  expect_tame({"--settings", write("s.yaml", "\"veh\\e[31micle\": 1\n")}, 2, "s.yaml:1: veh\\x1b[31micle: unknown key");
  expect_tame({"--settings", write("s.yaml", "corners:\n  target: \"\\e]0;title\\a\"\n")}, 2,
              "is '\\x1b]0;title\\x07'");
  expect_tame({"--settings", write("s.yaml", "a\x1b[2J: 1\n")}, 2, "s.yaml");
  expect_tame({"--settings", folder_ / ("no" + clear + ".yaml")}, 2, "no\\x1b[2J\\x07\\x9b\\x7f.yaml: no such file");
  expect_tame({"--timestamps", write("t.txt", "0\n" + clear + "\n")}, 2,
              "t.txt:2: '\\x1b[2J\\x07\\x9b\\x7f' is not a time");
  expect_tame({"--camera", write("c.txt", "P0: " + clear + " 0 1 0 0 1 1 0 0 0 1 0\n")}, 2, "c.txt:1: P0: '\\x1b");
  expect_tame({"--frame", clear}, 2, "--frame");
  std::ofstream(folder_ / "drive/image_0" / ("000004" + clear + ".png")) << "no image";
  fs::remove(folder_ / "drive/image_0/000004.png");
  expect_tame({"--quiet"}, 0, "frame 4: 000004\\x1b[2J\\x07\\x9b\\x7f.png: is not a readable image; skipped");
}

}  // namespace
}  // namespace turnscale

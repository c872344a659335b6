// SPDX-License-Identifier: MIT
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/io/floor_plan_file.h"
#include "turnscale/io/height_file.h"
#include "turnscale/io/speed_file.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

// Files that people write, each with a valid text.
struct TextFile {
  const char* name;
  std::string text;
  std::function<void(const fs::path&)> read;
};

std::vector<TextFile> TextFiles() {
  return {
      {"times.txt", "0.5\n1\n", [](const fs::path& path) { EXPECT_EQ(ReadFrameTimes(path).times[0], 0.5); }},
      {"a.tum", "0 1 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n",
       [](const fs::path& path) { EXPECT_EQ(ReadTrajectory(path).size(), 2u); }},
      {"euroc.csv", "#time,x\n50000000,1,2,3,1,0,0,0\n100000000,1,2,3,1,0,0,0\n",
       [](const fs::path& path) { EXPECT_EQ(ReadTrajectory(path).size(), 2u); }},
      {"speed.csv", "0,1\n1,1\n", [](const fs::path& path) { EXPECT_EQ(ReadSpeedFile(path).times.size(), 2u); }},
      {"plan.csv", "outline,x_m,z_m\n0,1,2\n", [](const fs::path& path) { EXPECT_EQ(ReadFloorPlan(path).size(), 1u); }},
      {"heights.csv", "time,height\n0,1\n", [](const fs::path& path) { EXPECT_EQ(ReadHeightFile(path).size(), 1u); }},
  };
}

std::string ReadingComplaint(const TextFile& file, const fs::path& path) {
  try {
    file.read(path);
  } catch (const InputError& error) {
    const std::string message = error.what();
    return message.starts_with(path.string()) ? message.substr(path.string().size()) : message;
  }
  return "no error";
}

// Written to a file, and what its reader says to it.
std::string ReadingComplaint(const TextFile& file, const std::string& text) {
  const fs::path path = ScratchPath(file.name);
  std::ofstream(path, std::ios::binary) << text;
  return ReadingComplaint(file, path);
}

TEST(TextFiles, MayComeFromAnyEditor) {
  for (const TextFile& file : TextFiles()) {
    EXPECT_EQ(ReadingComplaint(file, file.text), "no error") << file.name;
    EXPECT_EQ(ReadingComplaint(file, "\xEF\xBB\xBF" + file.text), "no error") << file.name;
    std::string lines_of_windows;
    for (const char c : file.text) lines_of_windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
    EXPECT_EQ(ReadingComplaint(file, lines_of_windows), "no error") << file.name;
  }
}

TEST(TextFiles, InUtf16AreNamedSo) {
  for (const TextFile& file : TextFiles()) {
    std::string wide = "\xFF\xFE";
    for (const char c : file.text) wide += {c, '\0'};
    EXPECT_EQ(ReadingComplaint(file, wide), ": is text in UTF-16; save it as UTF-8") << file.name;
  }
}

TEST(TextFiles, BinaryFilesAreNotPrinted) {
  const std::string video = std::string("\0\0\0\x20", 4) + "ftypisom" + std::string(200, '\x1b');
  for (const TextFile& file : TextFiles()) {
    EXPECT_EQ(ReadingComplaint(file, video), ":1: is not text in UTF-8; give a text file, saved as UTF-8") << file.name;
    const std::string noise = ReadingComplaint(file, std::string(500, '\x1b') + file.text);
    EXPECT_LT(noise.size(), 150u) << file.name;
    EXPECT_EQ(noise.find('\x1b'), std::string::npos) << file.name;
  }
}

TEST(TextFiles, ThatCannotBeReadSayWhy) {
  const fs::path loop = ScratchPath("loop");
  fs::create_symlink(loop, loop);
  for (const TextFile& file : TextFiles()) {
    EXPECT_EQ(ReadingComplaint(file, loop), ": cannot be read: Too many levels of symbolic links") << file.name;
    EXPECT_TRUE(ReadingComplaint(file, fs::path("/nowhere/file")).starts_with(": no such ")) << file.name;
    EXPECT_TRUE(ReadingComplaint(file, fs::path("/")).starts_with(": is a folder, not a ")) << file.name;
  }
}

}  // namespace
}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include <csignal>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "failing_memory.h"
#include "rendered_room.h"
#include "result_files.h"
#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/io/output_file.h"
#include "turnscale/io/terminal.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/run/result_folder.h"
#include "turnscale/run/run_drive.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 20;
constexpr int kStop = 12;

// Runs over a drive's images, with something that happens before a frame is handed over; number kFrames is the end.
class FailuresTest : public ::testing::Test {
 protected:
  using Happening = std::function<void(int frame)>;

  static void SetUpTestSuite() {
    Drive() = ::testing::TempDir() + "failures_drive_" + std::to_string(getpid());
    WriteRoomDrive(Drive(), kFrames);
  }
  static void TearDownTestSuite() { fs::remove_all(Drive()); }
  static fs::path& Drive() {
    static fs::path drive;
    return drive;
  }

  ~FailuresTest() override { fs::remove_all(Out()); }
  static fs::path Out() { return ScratchPath("out"); }
  static fs::path WholeOut() { return ScratchPath("whole"); }

  static RunEnd Run(const fs::path& out, const Happening& happening, std::optional<int> max_frames = {}) {
    OdometryOptions options;
    options.vehicle.lever_arm = 1.5;
    ImageSource source(FindDrive(Drive()), {});
    Odometry odometry(options, ReadCameraFile(Drive() / "calib.txt"));
    Progress progress(kFrames, true);
    int frame = 0;
    DriveToRun drive;
    drive.next = [&] {
      happening(frame++);
      return source.Next();
    };
    drive.at_end = [&] { return EndOfDrive{.ends_early = source.EndsEarly()}; };
    drive.max_frames = max_frames;
    drive.output = {.folder = out};
    return RunDrive(drive, odometry, progress);
  }

  // The same as a run of so many frames that comes to a normal end.
  static void ExpectSameResultsAsOf(int frames) {
    const RunEnd whole = Run(
        WholeOut(), [](int) {}, frames);
    EXPECT_TRUE(whole.failures.empty());
    for (const std::string& name : NamesOfResults()) {
      EXPECT_TRUE(fs::exists(Out() / name)) << name;
      EXPECT_EQ(TextOf(Out() / name), TextOf(WholeOut() / name)) << name;
    }
    EXPECT_FALSE(fs::exists(Out() / "live.tum.part"));
    fs::remove_all(WholeOut());
  }

  static nlohmann::json Summary() { return nlohmann::json::parse(TextOf(Out() / "summary.json")); }
};

TEST_F(FailuresTest, WhateverALibraryThrowsResultsAreThoseOfANormalEnd) {
  const std::exception_ptr thrown[] = {
      std::make_exception_ptr(cv::Exception(cv::Error::StsAssert, "size > 0", "resize", "resize.cpp", 4052)),
      std::make_exception_ptr(std::out_of_range("vector::at")),
      std::make_exception_ptr(InternalError("broken")),
      std::make_exception_ptr(InputError("000012.png: is of another size")),
      std::make_exception_ptr(42),
  };
  for (const std::exception_ptr& exception : thrown) {
    const RunEnd end = Run(Out(), [&](int frame) {
      if (frame == kStop) std::rethrow_exception(exception);
    });
    ASSERT_EQ(end.failures.size(), 1u);
    const std::string message = FailureOf(exception).message;
    EXPECT_EQ(FailureOf(end.failures[0]).message, message);
    EXPECT_FALSE(end.interrupted);
    EXPECT_FALSE(Summary()["complete"].get<bool>());
    EXPECT_EQ(Summary()["stopped"], message);
    EXPECT_EQ(Summary()["frames"]["total"], kStop);
  }
  ExpectSameResultsAsOf(kStop);
}

TEST_F(FailuresTest, WhatTheFirstFrameThrowsLeavesNoTrace) {
  EXPECT_THROW(Run(Out(), [](int) { throw InputError("000000.png: is of another size"); }), InputError);
  EXPECT_FALSE(fs::exists(Out()));
}

TEST_F(FailuresTest, MemoryThatRunsOutInTheMiddleOfAFrame) {
  int refusals = 0;
  for (const int frame : {kStop, kStop + 1}) {
    for (int which = 1; which < 100'000; which *= 6) {
      const RunEnd end = Run(Out(), [&](int next) {
        if (next == frame) RefuseAllocation(which);
        if (next == frame + 1) AllocationWasRefused();
      });
      if (end.failures.empty()) continue;
      ++refusals;
      EXPECT_EQ(FailureOf(end.failures[0]).message, FailureOf(std::make_exception_ptr(std::bad_alloc())).message);
      EXPECT_EQ(end.failures.size(), 1u) << FailureOf(end.failures[1]).message;
      ExpectWholeFiles(Out());
      for (const std::string& name : NamesOfResults()) EXPECT_TRUE(fs::exists(Out() / name)) << name;
      EXPECT_GE(ReadTrajectory(Out() / "trajectory.tum").size(), static_cast<size_t>(frame));
      EXPECT_TRUE(Summary()["stopped"].get<std::string>().starts_with("out of memory"));
    }
  }
  EXPECT_GE(refusals, 6);
}

TEST_F(FailuresTest, MemoryThatRunsOutInTheFinalAdjustment) {
  int failures = 0;
  for (const int which : {1, 5, 25, 125}) {
    fs::remove_all(Out());
    const RunEnd end = Run(Out(), [&](int next) {
      // The summary is the last that is written before.
      if (next == kFrames) RefuseAllocation(which, Out() / "summary.json");
    });
    ASSERT_TRUE(AllocationWasRefused());
    // Some algorithms do without.
    if (end.failures.empty()) continue;
    ++failures;
    EXPECT_EQ(end.failures.size(), 1u);
    ExpectWholeFiles(Out());
    for (const std::string& name : NamesOfResults()) EXPECT_TRUE(fs::exists(Out() / name)) << name;
    EXPECT_EQ(ReadTrajectory(Out() / "trajectory.tum").size(), static_cast<size_t>(kFrames));
    EXPECT_EQ(Summary()["frames"]["total"], kFrames);
    EXPECT_TRUE(Summary()["stopped"].get<std::string>().starts_with("out of memory"));
  }
  EXPECT_GE(failures, 2);
}

TEST_F(FailuresTest, AKillInTheFinalAdjustmentLeavesResultsThatCanBeRead) {
  fs::create_directories(Out());
  const fs::path summary = Out() / "summary.json";
  ASSERT_EQ(mkfifo(summary.c_str(), 0600), 0);
  std::future<std::string> before = std::async(std::launch::async, [&] {
    const std::string text = TextOf(summary);
    TextOf(summary);
    return text;
  });
  const RunEnd end = Run(Out(), [](int) {});
  // Lets the reader go if there was no second summary.
  close(open(summary.c_str(), O_RDWR | O_NONBLOCK));
  const std::string text = before.get();
  EXPECT_EQ(end.summary.drive.ending.stopped, "");
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["stopped"], "the final adjustment was not finished");
  EXPECT_FALSE(json["complete"].get<bool>());
  EXPECT_EQ(json["frames"]["total"], kFrames);
  fs::remove(summary);
  std::ofstream(summary) << text;
  EXPECT_EQ(ReadResultFolder(Out()).frames.size(), static_cast<size_t>(kFrames));
}

TEST_F(FailuresTest, ADiskThatFillsUpOnTheWay) {
  rlimit before = {};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const RunEnd end = Run(Out(), [&](int frame) {
    if (frame != kStop) return;
    const rlimit limit = {1, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(end.failures.empty());
  EXPECT_THROW(std::rethrow_exception(end.failures[0]), OutputError);
  EXPECT_NE(end.summary.drive.ending.stopped.find("live.tum: cannot be written: File too large"), std::string::npos);
  ExpectWholeFiles(Out());
  EXPECT_GT(ReadTrajectory(Out() / "live.tum").size(), 0u) << "written before";
}

TEST_F(FailuresTest, OneFileThatCannotBeWrittenKeepsNoOther) {
  for (const std::string& name : NamesOfResults()) {
    fs::remove_all(Out());
    fs::create_directories(Out());
    fs::create_symlink("/dev/full", Out() / name);
    const RunEnd end = Run(Out(), [](int) {});
    ASSERT_FALSE(end.failures.empty());
    const std::string message = FailureOf(end.failures[0]).message;
    EXPECT_NE(message.find(name + ": cannot be written: No space left on device"), std::string::npos) << message;
    for (const std::string& other : NamesOfResults()) {
      EXPECT_TRUE(fs::exists(Out() / other)) << other;
    }
    EXPECT_EQ(Summary()["stopped"], message);
    EXPECT_FALSE(Summary()["complete"].get<bool>());
  }
}

}  // namespace
}  // namespace turnscale

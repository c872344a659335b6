// SPDX-License-Identifier: MIT
#include "turnscale/io/terminal.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <poll.h>
#include <unistd.h>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

template <class Exception>
Failure Of(const Exception& exception) {
  return FailureOf(std::make_exception_ptr(exception));
}

void ExpectInternal(const Failure& failure, const std::string& part) {
  EXPECT_EQ(failure.exit_code, 1);
  EXPECT_TRUE(failure.message.starts_with("internal error: ")) << failure.message;
  EXPECT_NE(failure.message.find(part), std::string::npos) << failure.message;
  EXPECT_NE(failure.message.find("please report it"), std::string::npos) << failure.message;
  EXPECT_EQ(failure.message.find('\n'), std::string::npos) << failure.message;
}

TEST(Failure, OfTheInputAndTheMachineSaysItsMessage) {
  EXPECT_EQ(Of(InputError("cam.yaml:1: bad")).exit_code, 2);
  EXPECT_EQ(Of(InputError("cam.yaml:1: bad")).message, "cam.yaml:1: bad");
  EXPECT_EQ(Of(OutputError("map.ply: full")).exit_code, 1);
  EXPECT_EQ(Of(OutputError("map.ply: full")).message, "map.ply: full");
  const Failure denied = Of(
      std::filesystem::filesystem_error("status", "/secret/file", std::make_error_code(std::errc::permission_denied)));
  EXPECT_EQ(denied.exit_code, 1);
  EXPECT_EQ(denied.message, "/secret/file: Permission denied");
  for (const Failure& memory : {Of(std::bad_alloc()), Of(cv::Exception(cv::Error::StsNoMem, "no", "f", "file", 1))}) {
    EXPECT_EQ(memory.exit_code, 1);
    EXPECT_TRUE(memory.message.starts_with("out of memory")) << memory.message;
  }
}

TEST(Failure, OfOursOrOfALibrarySaysWhere) {
  ExpectInternal(Of(InternalError("the map is empty")), "the map is empty at io/terminal_test.cpp:");
  ExpectInternal(Of(cv::Exception(cv::Error::StsAssert, "size > 0", "resize", "resize.cpp", 4052)), "resize.cpp:4052");
  ExpectInternal(Of(std::out_of_range("vector::at\n  twice")), "vector::at twice;");
  ExpectInternal(Of(NumericalError("a pose is not a number")), "a pose is not a number");
  ExpectInternal(Of(42), "no exception");
}

TEST(Message, IsOneLineThatATerminalDoesNotObey) {
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(Report({2, "a\x1b[2J\nb"}), 2);
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "turnscale: a\\x1b[2J\\x0ab\n");
  ::testing::internal::CaptureStdout();
  PrintText("folder \x1b[31m\nlast\n");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "folder \\x1b[31m\nlast\n");
}

// Standard error as a terminal, for as long as it lives.
class Terminal {
 public:
  Terminal() : terminal_(posix_openpt(O_RDWR | O_NOCTTY)), standard_error_(dup(STDERR_FILENO)) {
    grantpt(terminal_);
    unlockpt(terminal_);
    const int line = open(ptsname(terminal_), O_RDWR | O_NOCTTY);
    dup2(line, STDERR_FILENO);
    close(line);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal() {
    dup2(standard_error_, STDERR_FILENO);
    close(standard_error_);
    close(terminal_);
  }

  // What was shown up to this text; the system hands it over piece by piece.
  std::string ShownUpTo(const std::string& last) const {
    std::fflush(stderr);
    std::string shown;
    char text[4096];
    pollfd waiting = {terminal_, POLLIN, 0};
    while (!shown.ends_with(last) && poll(&waiting, 1, 5000) == 1) {
      const ssize_t size = read(terminal_, text, sizeof text);
      if (size <= 0) break;
      shown.append(text, static_cast<size_t>(size));
    }
    return shown;
  }

 private:
  int terminal_;
  int standard_error_;
};

TEST(Progress, TheLineEndsWhenARunFails) {
  const Terminal terminal;
  try {
    Progress progress(3, false);
    progress.Update(3, "scale pending");
    throw 0;
  } catch (int) {
    std::fprintf(stderr, "failed");
  }
  const std::string shown = terminal.ShownUpTo("failed");
  EXPECT_NE(shown.find("frame 3/3"), std::string::npos) << shown;
  EXPECT_TRUE(shown.ends_with("scale pending\r\nfailed")) << shown;
}

TEST(Progress, ATotalThatIsExceededIsNoLongerShown) {
  const Terminal terminal;
  Progress progress(3, false);
  progress.Update(3);
  EXPECT_NE(terminal.ShownUpTo("frames/s").find("frame 3/3"), std::string::npos);
  progress.Update(4);
  progress.Finish();
  std::fprintf(stderr, "over");
  const std::string shown = terminal.ShownUpTo("over");
  EXPECT_EQ(shown.find("/3"), std::string::npos) << shown;
}

TEST(Progress, WhatFollowsTheFramesIsShownWhileItLasts) {
  const Terminal terminal;
  Progress progress(3, false);
  progress.Update(3);
  progress.Finish();
  progress.Say("final adjustment");
  EXPECT_TRUE(terminal.ShownUpTo("final adjustment").ends_with("\r\x1b[Kfinal adjustment"));
  progress.Say("");
  progress.Finish();
  std::fprintf(stderr, "over");
  EXPECT_EQ(terminal.ShownUpTo("over"), "\r\x1b[Kover");
}

TEST(Progress, AShortRunPrintsNoLineOfWhatFollows) {
  ::testing::internal::CaptureStderr();
  Progress progress(3, false);
  progress.Say("final adjustment");
  progress.Say("");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace turnscale

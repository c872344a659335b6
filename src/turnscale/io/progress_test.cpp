// SPDX-License-Identifier: MIT
#include "turnscale/io/progress.h"

#include <cstdio>
#include <cstdlib>
#include <string>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

namespace turnscale {
namespace {

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

}  // namespace
}  // namespace turnscale

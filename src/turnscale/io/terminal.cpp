// SPDX-License-Identifier: MIT
#include "turnscale/io/terminal.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <new>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>
#include <unistd.h>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"

namespace turnscale {
namespace {

constexpr int kFailed = 1;
constexpr int kBadInput = 2;

// Libraries complain in several lines.
std::string InOneLine(std::string_view text) {
  std::string line;
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\n' || c == '\r' || c == '\t';
    if (!blank) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  if (line.ends_with(' ')) line.pop_back();
  return line;
}

Failure OutOfMemory() { return {kFailed, "out of memory; close other programs, or use a machine with more"}; }

Failure Internal(std::string_view what) {
  return {kFailed, "internal error: " + InOneLine(what) + "; please report it with the command and its input"};
}

constexpr auto kTerminalInterval = std::chrono::milliseconds(100);
constexpr auto kLineInterval = std::chrono::seconds(10);
constexpr int kBarWidth = 24;
const std::string kClearLine = "\r\x1b[K";

// A terminal that is gone is no reason to stop.
void Show(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

std::string Bar(int done, int all) {
  const int filled =
      std::clamp(static_cast<int>(static_cast<int64_t>(done) * kBarWidth / std::max(all, 1)), 0, kBarWidth);
  return fmt::format("[{:#<{}}{:.<{}}] ", "", filled, "", kBarWidth - filled);
}

}  // namespace

void PrintMessage(std::string_view line) {
  const std::string text = Printable(line) + "\n";
  std::fwrite(text.data(), 1, text.size(), stderr);
}

void PrintText(std::string_view lines) { WriteStandardOutput(Printable(lines, "\n")); }

void WriteStandardOutput(std::string_view text) {
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    throw OutputError("standard output: cannot be written: " + std::generic_category().message(errno));
  }
}

Failure FailureOf(const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const InputError& error) {
    return {kBadInput, error.what()};
  } catch (const OutputError& error) {
    return {kFailed, error.what()};
  } catch (const std::filesystem::filesystem_error& error) {
    return {kFailed, error.path1().string() + ": " + error.code().message()};
  } catch (const std::bad_alloc&) {
    return OutOfMemory();
  } catch (const cv::Exception& error) {
    return error.code == cv::Error::StsNoMem ? OutOfMemory() : Internal(error.what());
  } catch (const std::exception& error) {
    return Internal(error.what());
  } catch (...) {
    return Internal("something was thrown that is no exception");
  }
}

int Report(const Failure& failure) {
  PrintMessage("turnscale: " + failure.message);
  return failure.exit_code;
}

Progress::Progress(int frames, bool quiet, std::string unit)
    : frames_(frames), quiet_(quiet), unit_(std::move(unit)), on_terminal_(isatty(STDERR_FILENO) == 1) {}

void Progress::Update(int frames_done, const std::string& more) {
  if (quiet_) return;
  if (frames_done > frames_) frames_ = 0;
  const Clock::time_point now = Clock::now();
  const int tenths = frames_ > 0 ? static_cast<int>(static_cast<int64_t>(frames_done) * 10 / frames_) : 0;
  const bool due = on_terminal_ ? now - shown_ >= kTerminalInterval || frames_done == frames_
                                : tenths > shown_tenths_ || now - shown_ >= kLineInterval;
  if (!due) return;
  shown_ = now;
  shown_tenths_ = tenths;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const std::string text =
      fmt::format("{} {}{}, {:.1f} {}s/s{}{}", unit_, frames_done, frames_ > 0 ? fmt::format("/{}", frames_) : "",
                  frames_done / std::max(seconds, 1e-3), unit_, more.empty() ? "" : ", ", more);
  if (on_terminal_) {
    Show(kClearLine + (frames_ > 0 ? Bar(frames_done, frames_) : "") + text);
    line_open_ = true;
  } else {
    Show(text + "\n");
  }
}

void Progress::Say(const std::string& what) {
  if (quiet_) return;
  if (on_terminal_) {
    if (!what.empty() || line_open_) Show(kClearLine + what);
    line_open_ = !what.empty();
  } else if (!what.empty() && Clock::now() - start_ >= kLineInterval) {
    Show(what + "\n");
  }
}

void Progress::Warn(const std::string& message) {
  if (prints_warnings_) {
    if (line_open_) Show(kClearLine);
    line_open_ = false;
    PrintMessage("warning: " + message);
  }
  if (observer_) observer_(message);
}

void Progress::Finish() {
  if (line_open_) Show("\n");
  line_open_ = false;
}

}  // namespace turnscale

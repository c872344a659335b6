// SPDX-License-Identifier: MIT
#include "turnscale/io/progress.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "turnscale/io/message.h"

namespace turnscale {
namespace {

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

Progress::Progress(int frames, bool quiet, std::string unit)
    : frames_(frames), quiet_(quiet), unit_(std::move(unit)), on_terminal_(isatty(STDERR_FILENO) == 1) {}

void Progress::Update(int frames_done, const std::string& more) {
  if (quiet_) return;
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

void Progress::Warn(const std::string& message) {
  if (line_open_) Show(kClearLine);
  line_open_ = false;
  PrintMessage("warning: " + message);
}

void Progress::Finish() {
  if (line_open_) Show("\n");
  line_open_ = false;
}

const char* ScaleStateName(ScaleState state) {
  switch (state) {
    case ScaleState::kPending:
      return "pending";
    case ScaleState::kObserved:
      return "observed";
    case ScaleState::kHeld:
      return "held";
  }
  return "unknown";
}

const char* TrackingStateName(TrackingState state) {
  switch (state) {
    case TrackingState::kInitializing:
      return "initializing";
    case TrackingState::kTracked:
      return "tracked";
    case TrackingState::kRepeated:
      return "repeated";
    case TrackingState::kBridged:
      return "bridged";
    case TrackingState::kUnreadable:
      return "unreadable";
  }
  return "unknown";
}

}  // namespace turnscale

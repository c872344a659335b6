// SPDX-License-Identifier: MIT
#include "interrupt.h"

#include <atomic>
#include <csignal>
#include <cstddef>
#include <iterator>
#include <string_view>

#include <unistd.h>

#include "turnscale/commands/command_hooks.h"

namespace turnscale {
namespace {

// The last one comes when a terminal is closed.
constexpr int kStops[] = {SIGINT, SIGTERM, SIGHUP};

// Which of them are handled; the others stay ignored. Set before a handler can run.
bool installed[std::size(kStops)] = {};

// The handler may run on any thread.
std::atomic<bool> caught = false;
static_assert(std::atomic<bool>::is_always_lock_free);

// Calls only what a handler may call.
void OnEarlySignal(int /*signal*/) {
  constexpr std::string_view kMessage = "turnscale: interrupted before the first frame; nothing is written\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kMessage.data(), kMessage.size());
  _exit(kInterruptedExitCode);
}

void OnSignal(int /*signal*/) {
  caught = true;
  // A second signal, of whichever kind, meets the default and ends a run that hangs.
  for (size_t i = 0; i < std::size(kStops); ++i)
    if (installed[i]) std::signal(kStops[i], SIG_DFL);
}

void Handle(void (*handler)(int)) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (size_t i = 0; i < std::size(kStops); ++i) {
    struct sigaction before = {};
    sigaction(kStops[i], nullptr, &before);
    // nohup wants it to go on. Shells that start it in the background ignore SIGINT for it, which is not meant so.
    installed[i] = kStops[i] != SIGHUP || before.sa_handler != SIG_IGN;
  }
  for (size_t i = 0; i < std::size(kStops); ++i)
    if (installed[i]) sigaction(kStops[i], &action, nullptr);
}

}  // namespace

void EndOnInterrupts() { Handle(OnEarlySignal); }

void CatchInterrupts() {
  Handle(OnSignal);
  // A reader that is gone is found out where something is written.
  std::signal(SIGPIPE, SIG_IGN);
}

bool Interrupted() { return caught; }

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include "interrupt.h"

#include <atomic>
#include <csignal>

namespace turnscale {
namespace {

// The last one comes when a terminal is closed.
constexpr int kStops[] = {SIGINT, SIGTERM, SIGHUP};

// The handler may run on any thread.
std::atomic<bool> caught = false;
static_assert(std::atomic<bool>::is_always_lock_free);

void OnSignal(int /*signal*/) {
  caught = true;
  // A second signal, of whichever kind, meets the default and ends a run that hangs.
  for (const int stop : kStops) std::signal(stop, SIG_DFL);
}

}  // namespace

void CatchInterrupts() {
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int stop : kStops) {
    struct sigaction before = {};
    sigaction(stop, nullptr, &before);
    // nohup wants it to go on. Shells that start it in the background ignore SIGINT for it, which is not meant so.
    if (stop == SIGHUP && before.sa_handler == SIG_IGN) continue;
    sigaction(stop, &action, nullptr);
  }
  // A reader that is gone and a limit on the size of files are found out where something is written.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

bool Interrupted() { return caught; }

}  // namespace turnscale

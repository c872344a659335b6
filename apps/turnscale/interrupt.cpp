// SPDX-License-Identifier: MIT
#include "interrupt.h"

#include <csignal>

namespace turnscale {
namespace {

volatile std::sig_atomic_t interrupted = 0;

void OnSignal(int /*signal*/) {
  interrupted = 1;
  // A second signal, of either kind, meets the default and ends a run that hangs.
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

}  // namespace

void CatchInterrupts() {
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

bool Interrupted() { return interrupted != 0; }

}  // namespace turnscale

// SPDX-License-Identifier: MIT
#include <cstdlib>

#include <CLI/CLI.hpp>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "commands.h"
#include "installed_simulator.h"
#include "program.h"

namespace turnscale {
namespace {

void AddCommands(CLI::App& app) {
  AddRunCommand(app);
  AddBatchCommand(app);
  AddCalibrateCommand(app);
  AddEvaluateCommand(app);
  AddExportCommand(app);
  AddRescaleCommand(app);
  if constexpr (TURNSCALE_WITH_SIMULATION) {
    AddInstalledCommand(app, kSimulateCommand);
  } else {
    AddMissingCommand(app, kSimulateCommand, "simulator", "TURNSCALE_BUILD_SIMULATION");
  }
  if constexpr (TURNSCALE_WITH_LABORATORY) {
    AddInstalledCommand(app, kLabCommand);
  } else {
    AddMissingCommand(app, kLabCommand, "laboratory", "TURNSCALE_BUILD_LABORATORY");
  }
  AddViewCommand(app);
}

// All threads share one heap, so that memory freed by one can be reused by the others: a second heap costs 10 MB.
// Blocks up to 32 MB are allocated in the heap, too, and freed memory stays there. Otherwise the kernel clears new
// pages for each image and each bundle adjustment, which takes 5 % of the CPU time.
void SetUpHeap() {
#ifdef __GLIBC__
  constexpr int kMegabyte = 1 << 20;
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_MMAP_THRESHOLD, 32 * kMegabyte);
  mallopt(M_TRIM_THRESHOLD, 256 * kMegabyte);
#endif
}

}  // namespace
}  // namespace turnscale

int main(int argc, char** argv) {
  turnscale::SetUpHeap();
  return turnscale::RunProgram(argc, argv, turnscale::AddCommands);
}

// SPDX-License-Identifier: MIT
#include "failing_memory.h"

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <new>

#include <unistd.h>

namespace {

// Without constructors, as memory is allocated before any of them runs.
thread_local int countdown = 0;
thread_local bool waiting = false;
thread_local bool refused = false;
thread_local char awaited[4096] = {};

bool Refuses() {
  if (countdown == 0) return false;
  if (waiting && access(awaited, F_OK) != 0) return false;
  waiting = false;
  refused = --countdown == 0;
  return refused;
}

void* Allocate(std::size_t size, std::size_t alignment) {
  if (Refuses()) throw std::bad_alloc();
  const std::size_t whole = (size + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, whole > 0 ? whole : alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

namespace turnscale {

void RefuseAllocation(int which, const std::filesystem::path& after) {
  std::strncpy(awaited, after.c_str(), sizeof(awaited) - 1);
  waiting = !after.empty();
  refused = false;
  countdown = which;
}

bool AllocationWasRefused() {
  countdown = 0;
  return refused;
}

}  // namespace turnscale

void* operator new(std::size_t size) { return Allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return Allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t /*alignment*/) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*size*/, std::align_val_t /*alignment*/) noexcept { std::free(memory); }

// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

namespace turnscale {

/// A program that links failing_memory.cpp can run out of memory at a chosen moment: one allocation of this thread is
/// refused, number `which` from 1 on, counted from now or, where `after` is given, from when that file exists.
void RefuseAllocation(int which, const std::filesystem::path& after = {});

/// Whether that has come; no allocation is refused any more.
bool AllocationWasRefused();

}  // namespace turnscale
